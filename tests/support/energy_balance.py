"""Energy balance of random mechanisms."""

from __future__ import annotations

import numpy as np

from frictool.engine.mechanism.energy import balance
from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.mechanism.state import work_by_element
from tests.support.mechanism_runs import ready
from tests.support.random_mechanisms import drawn

CLOSED = 1e-6  # relative to the energy handled


def balance_error(
    seed: int, stiffer: float = 1.0, samples: int | None = None, least: float = 1e-6
) -> float:
    """Return the balance error of one random mechanism, relative to the energy that it handled.

    stiffer: factor of the stiffness of links without backlash. least: smallest energy [J] to which
    the error is relative.
    """
    b, commands, period = drawn(seed)
    commands = commands[:samples]
    for row in b.couplings:
        row["stiffness"] *= stiffer if row["gap"] == 0.0 else 1.0
    machine, state = ready(b)
    before = balance(machine, state)
    result = run(machine, state, commands, period)
    assert result.status == 0, f"seed {seed}: status {result.status} at {result.reached} s"
    after, work = balance(machine, state), work_by_element(machine, state)
    through = max(
        after.lost + after.kinetic + abs(after.stored - before.stored),
        float(np.abs(work.sources).sum()),
        least,
    )
    never_back = [work.joints, work.couplings, work.pressings, work.impacts, work.stops]
    assert min((float(w.min()) for w in never_back if w.size), default=0.0) >= -1e-9 * through, (
        f"seed {seed}: a loss is negative"
    )
    return abs(after.total - before.total) / through
