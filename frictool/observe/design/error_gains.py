"""Velocity error of a tracking observer under white noise.

    e+ = F ((1 - L C) e - L n) + B a        e: error before the correction, + at the next sample

e contains the errors of position x, speed v and d/J (d: disturbance effort, J: inertia). n is a
white error of the measured position, and a is a white error of the acceleration. F and B follow
from the model x'' = a + d/J over one period. L are the gains, and C = [1 0 0]. Smith's doubling
method computes the steady covariance of e. If time is expressed in periods, the matrices depend on
the gains only.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictool.errors import NoSolutionError
from frictool.typing import Matrix

DOUBLINGS = 60  # largest number of steps of Smith's method
CONVERGED = 1e-12  # relative change below which Smith's method stops


class ErrorGains(NamedTuple):
    """Ratios of the standard deviations of the velocity error and a position error [1/s].

    - rounding: (velocity error)/(position error), for a white error of the measured position
    - misfit: (velocity error)/(error of the predicted position), both caused by a white error of
      the acceleration
    """

    rounding: float
    misfit: float


def error_gains(gains: tuple[float, float, float], inertia: float, period: float) -> ErrorGains:
    """Return the error gains of a tracking observer.

    - gains: L1 [1], L2 [1/s], L3 [N m/rad | N/m]
    - inertia: kg m^2 | kg
    - period: sample period, s

    Raises NoSolutionError if the observer's error does not decay.
    """
    one, two, three = gains
    correction = np.array([[one], [two * period], [three * period**2 / inertia]])
    model = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    kept = np.eye(3)
    kept[:, :1] -= correction
    disturbed = np.array([[0.5], [1.0], [0.0]])
    by_rounding = _covariance(model @ kept, model @ correction)
    by_acceleration = _covariance(model @ kept, disturbed)
    velocity = (kept @ by_acceleration @ kept.T)[1, 1]
    rounded = (kept @ by_rounding @ kept.T)[1, 1] + correction[1, 0] ** 2
    return ErrorGains(
        float(np.sqrt(rounded)) / period, float(np.sqrt(velocity / by_acceleration[0, 0])) / period
    )


def _covariance(a: Matrix, b: Matrix) -> Matrix:
    """Return the steady covariance (n, n) of x+ = a x + b w for white noise w of variance 1."""
    total = b @ b.T
    power = a
    if np.max(np.abs(np.linalg.eigvals(a))) >= 1.0:
        raise NoSolutionError(
            "the error of the tracking observer does not decay with its gains, "
            "so that the velocity has no interval; design the observer again: "
            "frictool observe design MODEL --kind tracking"
        )
    for _ in range(DOUBLINGS):
        added = power @ total @ power.T
        total = total + added
        if np.max(np.abs(added)) <= CONVERGED * np.max(np.abs(total)):
            break
        power = power @ power
    return total
