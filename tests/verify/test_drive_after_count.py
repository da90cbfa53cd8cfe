"""The drive that one encoder count asks for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from frictool.plant.lti import Lti
from frictool.verify.encoder_count_drive import HORIZON, drive_after_count


def of(zero: float, pole: float, period: float = 1e-3) -> Lti:
    """(z - zero)/(z (z - pole)): a sample late."""
    a = np.array([[pole, 0.0], [1.0, 0.0]])
    return Lti(a, np.array([[1.0], [0.0]]), np.array([[1.0, -zero]]), np.zeros((1, 1)), period)


def test_a_gain_asks_for_itself_at_once() -> None:
    assert drive_after_count(
        Lti(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.array([[-30.0]]), 1e-3), 0.1
    ) == pytest.approx(3.0)


def test_a_response_that_peaks_later_counts_with_its_peak() -> None:
    """A delayed lead: nothing at once, most one sample after."""
    system = of(-3.0, 0.5)
    (response,) = signal.dstep((system.a, system.b, system.c, system.d, 1e-3), n=HORIZON)[1]
    assert response[0, 0] == 0.0
    assert drive_after_count(system, 0.1122) == pytest.approx(0.1122 * np.max(np.abs(response)))


def test_an_integral_counts_over_the_horizon_only() -> None:
    integral = of(0.0, 1.0)
    assert drive_after_count(integral, 1.0) == pytest.approx(HORIZON - 1)


def test_a_continuous_controller_is_refused() -> None:
    with pytest.raises(ValueError, match="sampled"):
        drive_after_count(of(0.0, -1.0, 0.0), 1.0)
