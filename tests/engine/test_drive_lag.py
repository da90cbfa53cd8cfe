"""Lag of a drive: the response of first order, and its limits."""

from __future__ import annotations

import math

import pytest

from frictool.engine.drive_lag import lagged_drive


@pytest.mark.parametrize("t", [0.0, 1e-3, 2.0])
def test_a_drive_without_lag_gives_its_command_at_once(t: float) -> None:
    assert lagged_drive(1.0, 3.0, 0.0, t) == 3.0


@pytest.mark.parametrize("t", [0.0, 1e-3, 2.0])
def test_a_drive_at_its_command_stays_there(t: float) -> None:
    assert lagged_drive(0.3, 0.3, 0.1, t) == 0.3


@pytest.mark.parametrize("t", [0.0, 0.05, 0.3])
def test_the_difference_decays_exponentially(t: float) -> None:
    assert lagged_drive(1.0, 3.0, 0.1, t) == pytest.approx(3.0 - 2.0 * math.exp(-10.0 * t))
