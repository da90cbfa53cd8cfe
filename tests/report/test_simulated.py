"""Logs as the simulation writes them: the limit cycle that friction makes of a PID, and the load
behind the clutch's backlash."""

from __future__ import annotations

import pytest

from tests.support.reported_logs import limit_cycle, load_behind_the_backlash


@pytest.mark.parametrize(
    "name",
    [
        "pid",
        "pid_limiter",
        *(pytest.param(one, marks=pytest.mark.accept) for one in ("pi_p", "pi_root")),
    ],
)
def test_limit_cycles_of_table_5_1_are_told_with_amplitude_and_period(name: str) -> None:
    found = limit_cycle(name)
    assert found["passed"], found


@pytest.mark.parametrize("plants", [3, pytest.param(10, marks=pytest.mark.accept)])
def test_the_bounds_of_the_load_hold_it(plants: int) -> None:
    found = load_behind_the_backlash(plants=plants)
    assert found["passed"], found
