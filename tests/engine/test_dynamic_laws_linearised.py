"""The derivatives that the Rosenbrock steps of a dynamic law use are those of its field."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.engine.drive import EffortFunction
from frictool.engine.dynamic_law_motion import (
    DrivenContact,
    Linearisation,
    law_field,
    law_kernels,
    linearise,
)
from frictool.engine.rosenbrock import CONTACT
from frictool.engine.status_codes import OK
from frictool.friction.law import DynamicKernels
from frictool.friction.law_extension import pack_plain_law
from frictool.friction.law_registry import LAWS
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from studies.rigs.table_3_1 import TABLE_3_1

MASS = 0.7
DRIVE = EffortFunction(
    offset=0.3,
    slope=1.7,
    amplitude=2.0,
    frequency=3.0,
    phase=0.4,
    proportional=5.0,
    derivative=0.6,
    integral=7.0,
    target=0.1,
    target_speed=0.9,
)

LAG = [-1.5, 2.5]  # N, 1/s: the decaying part of a drive with a lag
LOAD = PositionLoad(0.8, (LoadHarmonic(9.0, 0.3, -0.2),)).as_array()


@pytest.mark.parametrize("lagged", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_the_derivatives_are_those_of_the_field(seed: int, lagged: bool) -> None:
    random = np.random.default_rng(seed)
    law = LAWS["lugre"]
    assert isinstance(law.kernels, DynamicKernels)
    p = law.pack(TABLE_3_1["lugre"])
    laws = (*pack_plain_law(p), p.copy())
    drive = np.append(DRIVE.as_array(), LAG) if lagged else DRIVE.as_array()
    driven = DrivenContact(law_kernels(law.kernels), laws, MASS, drive, LOAD)
    y = np.array([0.02, 0.05, 0.01, 2e-6]) * random.uniform(-1.0, 1.0, 4)
    t, slope = float(random.uniform(0.0, 2.0)), np.zeros(4)
    scales = np.array([1e-7, 1e-3, 0.0, 1e-5])
    linear = Linearisation(np.zeros(3), np.zeros((3, 1)), np.zeros(CONTACT))
    assert law_field(driven, t, y, slope) == OK
    assert linearise(driven, t, y, slope, scales, linear) == OK

    def field(t: float, y: np.ndarray) -> np.ndarray:
        out = np.zeros(4)
        assert law_field(driven, t, y, out) == OK
        return out

    in_time = (field(t + 1e-4, y) - field(t - 1e-4, y)) / 2e-4
    np.testing.assert_allclose(linear.in_time, in_time[:CONTACT], rtol=1e-5, atol=1e-7)
    steps = np.diag([1e-4, 1e-7, 1e-4, 1e-11])
    by_state = np.column_stack(
        [(field(t, y + e) - field(t, y - e)) / (2.0 * e.max()) for e in steps]
    )
    np.testing.assert_allclose(linear.gains, -by_state[1, :CONTACT], rtol=1e-4)
    np.testing.assert_allclose(
        linear.couplings[:, 0], [by_state[3, 1], by_state[3, 3], -by_state[1, 3]], rtol=1e-4
    )
