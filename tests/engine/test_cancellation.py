"""A spring whose effort is a small difference of large terms: rounding must not make a body stop
and start for ever (3.5)."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.engine.body import moving
from frictool.engine.drive import EffortFunction
from frictool.engine.law_simulation import body_of
from frictool.engine.status_codes import OK
from frictool.engine.stick_slip_run import simulate
from frictool.friction.law_extension import FrictionExtension
from frictool.friction.law_registry import LAWS
from studies.rigs.table_3_1 import STRIBECK

LAW = LAWS["stribeck"]


@pytest.mark.parametrize(
    "extension",
    [FrictionExtension(), FrictionExtension(rise_time=1e-12)],
    ids=["plain", "extended"],
)
@pytest.mark.parametrize("seed", range(3))
def test_a_slip_that_ends_as_it_begins_is_not_tried_again(
    extension: FrictionExtension, seed: int
) -> None:
    """At most a stop, a reversal and a stop at one instant, and a run that gets to its end: 20
    drives each."""
    draw = np.random.default_rng(seed)
    for _ in range(20):
        large, stiffness = 10.0 ** draw.uniform(7, 9), 10.0 ** draw.uniform(0, 3)
        pull = EffortFunction(
            offset=-large, proportional=stiffness, target=large / stiffness, target_speed=0.1
        )
        body = body_of(LAW, LAW.pack(STRIBECK), 10.0 ** draw.uniform(-2, 1), extension)
        run = simulate(body, [(1.0, pull)], [1.0], state=moving(0.0, 0.5), most_events=2000)
        assert run.status == OK
        assert np.max(np.unique(run.events[:, 0], return_counts=True)[1], initial=0) <= 3
