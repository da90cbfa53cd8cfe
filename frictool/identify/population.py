"""Tests whether many estimates of one parameter have the same true value.

The observed scatter is compared with the scatter that the intervals predict. The standard deviation
s of an estimate x is the half width of its interval divided by the normal quantile. With weights
1/s^2, Q = sum (x - mean)^2/s^2 has a chi-squared distribution with n - 1 degrees of freedom if all
estimates have one true value (Cochran 1954). The excess of Q over n - 1 gives the variance that the
intervals do not explain (DerSimonian and Laird, 1986).

A unit is a machine that was tested. If the units are known, Q is the sum of a term within units and
a term between units. In the test between units, the unexplained scatter within units is added to
s^2.

If all dates are known, the drift of the parameter is the slope of a line that is fitted to the
estimates over the dates of their logs. The fit has one slope for all units, and an intercept for
each unit. If the Birge ratio of this fit, sqrt(chi^2/(degrees of freedom)), exceeds 1, the interval
of the drift is multiplied by this ratio.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.identify.fit_result import Interval
from frictool.typing import Vector

DAY_S = 86400.0


@dataclass(frozen=True)
class UnitValue:
    """Estimate of a parameter in one model of a batch.

    - unit: name of the machine that was tested; None if unknown
    - day: date of the model's log in days since any common origin; None if unknown
    """

    interval: Interval
    unit: str | None = None
    day: float | None = None


@dataclass(frozen=True)
class ScatterTest:
    """Result of a chi-squared test of scatter.

    - p: probability of at least this scatter if the intervals explain the whole scatter
    - beyond: standard deviation of the scatter that the intervals do not explain
    """

    p: float
    beyond: float


@dataclass(frozen=True)
class ParameterDrift:
    """Slope of a parameter over time [parameter's unit per day], and p-value of a zero slope."""

    slope: Interval
    p: float


@dataclass(frozen=True)
class Population:
    """Scatter of one parameter over many models, in SI units.

    - count, units: number of models, and number of units (tested machines)
    - mean: mean value, weighted by inverse variances
    - spread: standard deviation of the values
    - expected: standard deviation that the intervals predict for the values
    - whole: test whether all models have one true value
    - within: test whether the models of each unit have one true value; None if there are too few
      models
    - between: test whether all units have one true value; None if there are too few units
    - alone: for each unit with several models, test whether these models have one true value
    - drift: drift of the parameter with the date; None if the dates do not determine a drift
    - level: probability that at least one test rejects although all true values are equal
    """

    count: int
    units: int
    mean: float
    spread: float
    expected: float
    whole: ScatterTest
    within: ScatterTest | None
    between: ScatterTest | None
    alone: dict[str, ScatterTest]
    drift: ParameterDrift | None
    level: float

    @property
    def changing(self) -> list[str]:
        """Return the units whose models differ: the test in `alone` rejects equal true values."""
        return [unit for unit, test in self.alone.items() if test.p < self.limit / len(self.alone)]

    @property
    def limit(self) -> float:
        """Return the p-value below which a single test rejects (Bonferroni)."""
        return self.level / sum(
            test is not None for test in (self.whole, self.within, self.between, self.drift)
        )

    def rejects(self, test: ScatterTest | ParameterDrift | None) -> bool:
        """Return True if the p-value of `test` is below the limit; False if `test` is None."""
        return test is not None and test.p < self.limit

    @property
    def one(self) -> bool:
        """Return True if no test rejects the hypothesis of one common value."""
        return not any(
            self.rejects(test) for test in (self.whole, self.within, self.between, self.drift)
        )


def populations(
    values: Mapping[str, Sequence[UnitValue]], confidence: float
) -> dict[str, Population]:
    """Return the scatter of each parameter with at least two values, and its tests.

    `confidence` is the confidence of the intervals, and the probability that no test of any
    parameter rejects if all true values are equal (Bonferroni).
    """
    repeated = {name: estimates for name, estimates in values.items() if len(estimates) >= 2}
    return {
        name: population(estimates, confidence, (1.0 - confidence) / len(repeated))
        for name, estimates in repeated.items()
    }


def population(values: Sequence[UnitValue], confidence: float, level: float) -> Population:
    """Return the scatter of one parameter with at least two values, and its tests.

    `level` is the probability that at least one test rejects although all true values are equal.
    """
    estimates = np.array([one.interval.value for one in values])
    s = _deviations(values, confidence)
    units = np.array(
        [one.unit if one.unit is not None else f"\0{index}" for index, one in enumerate(values)]
    )
    named = all(one.unit is not None for one in values)
    within, between = _by_unit(estimates, s, units) if named else (None, None)
    alone = {
        str(name): _test(estimates[units == name], s[units == name])
        for name in np.unique(units)
        if np.sum(units == name) > 1
    }
    return Population(
        len(values),
        np.unique(units).size,
        _mean(estimates, s),
        float(np.std(estimates, ddof=1)),
        float(np.sqrt(np.mean(s**2))),
        _test(estimates, s),
        within,
        between,
        alone if named else {},
        _drift(values, estimates, s, units, confidence),
        level,
    )


def _deviations(values: Sequence[UnitValue], confidence: float) -> Vector:
    """Return the standard deviations (n,) of the values, from the longer side of each interval."""
    reach = [
        max(one.interval.high - one.interval.value, one.interval.value - one.interval.low)
        for one in values
    ]
    smallest = 1e-12 * max(abs(one.interval.value) for one in values) or 1e-300
    deviations: Vector = np.maximum(
        np.array(reach) / scipy.stats.norm.ppf(0.5 * (1.0 + confidence)), smallest
    )
    return deviations


def _mean(values: Vector, s: Vector) -> float:
    return float(np.average(values, weights=s**-2.0))


def _test(values: Vector, s: Vector, group: NDArray[np.int64] | None = None) -> ScatterTest:
    """Return the test of the scatter around the mean of each group.

    `group` contains the group number of each value; None for a single group.
    """
    w = s**-2.0
    group = np.zeros(values.size, dtype=np.int64) if group is None else group
    q = 0.0
    free = values.size
    reach = 0.0
    for one in np.unique(group):
        in_group = group == one
        mean = np.average(values[in_group], weights=w[in_group])
        q += float(np.sum(w[in_group] * (values[in_group] - mean) ** 2))
        reach += float(np.sum(w[in_group]) - np.sum(w[in_group] ** 2) / np.sum(w[in_group]))
        free -= 1
    return ScatterTest(
        float(scipy.stats.chi2.sf(q, free)),
        math.sqrt(max(0.0, (q - free) / reach)) if reach > 0.0 else 0.0,
    )


def _by_unit(
    values: Vector, s: Vector, units: NDArray[np.str_]
) -> tuple[ScatterTest | None, ScatterTest | None]:
    names, group = np.unique(units, return_inverse=True)
    within = _test(values, s, group) if names.size < values.size else None
    if names.size < 2 or within is None:
        return within, None
    wide = np.hypot(s, within.beyond)
    means = np.array([_mean(values[group == one], wide[group == one]) for one in range(names.size)])
    errors = np.array(
        [float(np.sum(wide[group == one] ** -2.0)) ** -0.5 for one in range(names.size)]
    )
    return within, _test(means, errors)


def _drift(
    values: Sequence[UnitValue],
    estimates: Vector,
    s: Vector,
    units: NDArray[np.str_],
    confidence: float,
) -> ParameterDrift | None:
    days = [one.day for one in values]
    if any(day is None for day in days):
        return None
    day = np.array(days, dtype=np.float64)
    w = s**-2.0
    names, group = np.unique(units, return_inverse=True)
    for one in range(names.size):
        in_group = group == one
        day[in_group] -= np.average(day[in_group], weights=w[in_group])
    about = (
        estimates
        - np.array([_mean(estimates[group == one], s[group == one]) for one in range(names.size)])[
            group
        ]
    )
    reach = float(np.sum(w * day**2))
    free = estimates.size - names.size - 1
    if free < 1 or float(np.ptp(day)) == 0.0:
        return None
    slope = float(np.sum(w * day * about)) / reach
    birge = math.sqrt(max(1.0, float(np.sum(w * (about - slope * day) ** 2)) / free))
    error = birge / math.sqrt(reach)
    half = float(scipy.stats.t.ppf(0.5 * (1.0 + confidence), free)) * error
    return ParameterDrift(
        Interval.around(slope, half), 2.0 * float(scipy.stats.t.sf(abs(slope) / error, free))
    )
