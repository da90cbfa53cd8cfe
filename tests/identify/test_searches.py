"""Searches of `identify/regression` against those of scipy."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.levenberg_marquardt import levenberg_marquardt
from frictool.typing import Matrix, Vector


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    centre=st.floats(-3.0, 3.0),
    power=st.sampled_from([1.0, 2.0, 4.0]),
    tilt=st.floats(-0.5, 0.5),
    scale=st.sampled_from([1e-6, 1.0, 1e6]),
)
def test_minimum_of_unimodal_functions(
    centre: float, power: float, tilt: float, scale: float
) -> None:
    calls: list[float] = []

    def value(x: float) -> float:
        calls.append(x)
        return scale * (abs(x - centre) ** power + tilt * x)

    found = bounded_minimum(value, -2.0, 2.0, 1e-6)
    steps = len(calls)
    peer = scipy.optimize.minimize_scalar(
        value, bounds=(-2.0, 2.0), method="bounded", options={"xatol": 1e-6}
    )
    assert all(-2.0 <= x <= 2.0 for x in calls)
    assert value(found) == pytest.approx(peer.fun, rel=1e-6, abs=1e-6 * scale)
    assert steps <= peer.nfev + 2


def test_minimum_at_an_end_and_of_a_constant() -> None:
    assert bounded_minimum(lambda x: x, 1.0, 3.0, 1e-6) == pytest.approx(1.0, abs=1e-6)
    assert bounded_minimum(lambda x: -x, 1.0, 3.0, 1e-6) == pytest.approx(3.0, abs=1e-6)
    assert 1.0 <= bounded_minimum(lambda _: 0.0, 1.0, 3.0) <= 3.0


@settings(derandomize=True, deadline=None, max_examples=30)
@given(rate=st.floats(0.3, 3.0), size=st.floats(0.5, 5.0), seed=st.integers(0, 1000))
def test_least_squares_of_an_exponential(rate: float, size: float, seed: int) -> None:
    t = np.linspace(0.0, 3.0, 60)
    measured = size * np.exp(-rate * t) + 0.01 * np.random.default_rng(seed).normal(size=t.size)

    def residual(x: Vector) -> Vector:
        return np.asarray(x[0] * np.exp(-x[1] * t) - measured)

    def jacobian(x: Vector) -> Matrix:
        fall = np.exp(-x[1] * t)
        return np.column_stack((fall, -x[0] * t * fall))

    start = np.array([1.0, 1.0])
    fit = levenberg_marquardt(residual, jacobian, start, 1e-12, 200)
    peer = scipy.optimize.least_squares(residual, start, jacobian, method="lm")
    assert fit.unknowns == pytest.approx(peer.x, rel=1e-4)
    assert fit.residual == pytest.approx(residual(fit.unknowns), abs=0.0)


def test_least_squares_never_ends_above_its_start() -> None:
    """A column without influence, and a single evaluation."""
    start = np.array([2.0, 5.0])
    fit = levenberg_marquardt(
        lambda x: np.array([x[0] ** 2 - 1.0, x[0]]),
        lambda x: np.array([[2.0 * x[0], 0.0], [1.0, 0.0]]),
        start, 1e-12, 100,
    )  # fmt: skip
    # the sum (x^2 - 1)^2 + x^2 is least at x = sqrt(1/2)
    assert fit.unknowns == pytest.approx([np.sqrt(0.5), 5.0], rel=1e-6)
    once = levenberg_marquardt(lambda x: x, lambda _: np.eye(2), start, 1e-12, 1)
    assert once.unknowns is start
