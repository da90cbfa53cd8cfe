"""Functions with known variance shares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from frictool.campaign.draws.factor_space import FactorSpace
from frictool.campaign.trials.trials import Trials
from tests.support.campaign_trials import Function, factors, trials_of

Array = np.ndarray
ISHIGAMI = (0.313905, 0.442411, 0.0, 0.0)  # Ishigami and Homma 1990; the variance is 13.8446
G = np.array([0.0, 1.0, 4.5, 9.0])  # Sobol's g-function


def ishigami(v: Array) -> Array:
    """sin x1 + 7 sin² x2 + 0.1 x3⁴ sin x1 over [-pi, pi]: x3 acts only together with x1, a fourth
    factor not at all."""
    return np.asarray(
        np.sin(v[:, 0]) + 7.0 * np.sin(v[:, 1]) ** 2 + 0.1 * v[:, 2] ** 4 * np.sin(v[:, 0])
    )


def g_function(v: Array) -> Array:
    return np.asarray(np.prod((np.abs(4.0 * v - 2.0) + G) / (1.0 + G), axis=1))


def g_indices() -> Array:
    parts = 1.0 / (3.0 * (1.0 + G) ** 2)
    return np.asarray(parts / (np.prod(1.0 + parts) - 1.0))


def linear(v: Array) -> Array:
    return np.asarray(v @ np.array([4.0, -2.0, 1.0, 0.0]))


def vertices(d: int, function: Function) -> Trials:
    """All corners of the unit cube; passed where the function is at most 3."""
    trials = trials_of(factors(d), [function], [3.0], 2**d)
    units = ((np.arange(2**d)[:, None] >> np.arange(d)) & 1).astype(float)
    found = function(units)[:, None]
    passed = (found[:, 0] <= 3.0).astype(np.int8)
    return replace(
        trials, units=units, values=units, metric_values=found, met=passed[:, None], passed=passed
    )


FUNCTIONS: dict[str, tuple[FactorSpace, Function, Array]] = {
    "ishigami": (factors(4, -np.pi, np.pi), ishigami, np.array(ISHIGAMI)),
    "g": (factors(4), g_function, g_indices()),
    "linear": (factors(4), linear, np.array([16.0, 4.0, 1.0, 0.0]) / 21.0),
}
