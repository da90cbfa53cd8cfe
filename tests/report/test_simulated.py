"""Logs as the simulation writes them: the limit cycle that friction makes of a PID, and the load
behind the clutch's backlash."""

from __future__ import annotations

import msgspec
import pytest

from tests.accept import check_report


@pytest.mark.parametrize("name", ["pid", "pi_p", "pid_limiter", "pi_root"])
def test_limit_cycles_of_table_5_1_are_told_with_amplitude_and_period(name: str) -> None:
    found = check_report.limit_cycle(name)
    assert found["passed"], found


def test_the_bounds_of_the_load_hold_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        check_report, "RANDOM", msgspec.structs.replace(check_report.RANDOM, plants=10)
    )
    found = check_report.load_behind_the_backlash()
    assert found["passed"], found
