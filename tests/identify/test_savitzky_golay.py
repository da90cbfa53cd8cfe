"""The weights of Savitzky and Golay are those of scipy, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import savgol_coeffs

from frictool.identify.rows.savitzky_golay import savitzky_golay


@pytest.mark.parametrize("window", [11, 21, 73, 501, 4001])
@pytest.mark.parametrize(("degree", "derivative"), [(3, 1), (3, 2), (4, 2)])
def test_weights_are_those_of_scipy(window: int, degree: int, derivative: int) -> None:
    weights = savitzky_golay(window, degree, derivative, 1e-3)
    scipys = savgol_coeffs(window, degree, deriv=derivative, delta=1e-3, use="dot")
    assert np.array_equal(weights, scipys)
    convolved = savitzky_golay(window, degree, derivative, 1e-3, last_first=True)
    assert np.array_equal(convolved, savgol_coeffs(window, degree, deriv=derivative, delta=1e-3))


def test_the_derivative_of_a_cubic_is_exact() -> None:
    t = 1e-3 * np.arange(-10, 11)
    weights = savitzky_golay(21, 3, 1, 1e-3)
    assert weights @ (2.0 + 3.0 * t - 4.0 * t**2 + 5.0 * t**3) == pytest.approx(3.0, rel=1e-12)
