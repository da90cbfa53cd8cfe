"""Whether many identifications of one parameter are of one population: what they scatter against
what their intervals let expect.

The standard deviation s of a value is the half width of its interval over the normal quantile. With
weights w = 1/s^2 about the weighted mean, Q = sum w (x - mean)^2 has the chi-squared distribution
with n - 1 degrees of freedom where one value is behind them all (Cochran, Biometrics 10, 1954);
what it exceeds them by is the variance that the intervals do not explain (DerSimonian and Laird,
Controlled Clinical Trials 7, 1986). Where units are known, Q splits into what is within and what is
between them; the means of the units are held against each other with what the logs of one unit
scatter beyond their intervals added to s^2. The drift is one slope over the date about the mean of
each unit, its error widened where the scatter about it asks for it (Birge, Physical Review 40,
1932).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm
from scipy.stats import t as student

from frictool.identify.fit_result import Interval

Vector = NDArray[np.float64]
DAY_S = 86400.0


@dataclass(frozen=True)
class UnitValue:
    """One identification. unit: of which actuator. day: when, in days; None where nobody knows."""

    found: Interval
    unit: str | None = None
    day: float | None = None


@dataclass(frozen=True)
class ScatterTest:
    """p: the probability of a scatter as large where there is none beyond the intervals. beyond:
    what there is, a standard deviation."""

    p: float
    beyond: float


@dataclass(frozen=True)
class ParameterDrift:
    """slope [1/day], with its interval, and the probability of one as large where there is none."""

    slope: Interval
    p: float


@dataclass(frozen=True)
class Population:
    """Of one parameter, in SI. mean: weighted. spread: standard deviation of the values. expected:
    what their intervals let expect.

    whole: of all values; within, between: of the values of a unit, and of the units; None where too
    few are known. alone: the same of each unit by itself. level: the probability that one
    population is called several, by all tests together.
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
        """The units whose own logs differ."""
        return [unit for unit, test in self.alone.items() if test.p < self.limit / len(self.alone)]

    @property
    def limit(self) -> float:
        """The p below which a test says no."""
        return self.level / sum(
            test is not None for test in (self.whole, self.within, self.between, self.drift)
        )

    def rejects(self, test: ScatterTest | ParameterDrift | None) -> bool:
        """Whether a test that there is says no."""
        return test is not None and test.p < self.limit

    @property
    def one(self) -> bool:
        """Whether nothing speaks against one value behind all of them."""
        return not any(
            self.rejects(test) for test in (self.whole, self.within, self.between, self.drift)
        )


def populations(
    values: Mapping[str, Sequence[UnitValue]], confidence: float
) -> dict[str, Population]:
    """Parameter -> its population, of those that two identifications at least have given.

    confidence: of the intervals; and that no parameter of one population is called several,
    whichever they are (Bonferroni).
    """
    told = {name: own for name, own in values.items() if len(own) >= 2}
    return {
        name: population(own, confidence, (1.0 - confidence) / len(told))
        for name, own in told.items()
    }


def population(values: Sequence[UnitValue], confidence: float, level: float) -> Population:
    """Of one parameter, of two values at least."""
    found = np.array([one.found.value for one in values])
    s = _deviations(values, confidence)
    units = np.array(
        [one.unit if one.unit is not None else f"\0{place}" for place, one in enumerate(values)]
    )
    named = all(one.unit is not None for one in values)
    within, between = _by_unit(found, s, units) if named else (None, None)
    alone = {
        str(name): _test(found[units == name], s[units == name])
        for name in np.unique(units)
        if np.sum(units == name) > 1
    }
    return Population(
        len(values),
        np.unique(units).size,
        _mean(found, s),
        float(np.std(found, ddof=1)),
        float(np.sqrt(np.mean(s**2))),
        _test(found, s),
        within,
        between,
        alone if named else {},
        _drift(values, found, s, units, confidence),
        level,
    )


def _deviations(values: Sequence[UnitValue], confidence: float) -> Vector:
    """(n,) standard deviations: of the wider side, as an interval may be cut at zero."""
    reach = [
        max(one.found.high - one.found.value, one.found.value - one.found.low) for one in values
    ]
    smallest = 1e-12 * max(abs(one.found.value) for one in values) or 1e-300
    deviations: Vector = np.maximum(np.array(reach) / norm.ppf(0.5 * (1.0 + confidence)), smallest)
    return deviations


def _mean(found: Vector, s: Vector) -> float:
    return float(np.average(found, weights=s**-2.0))


def _test(found: Vector, s: Vector, group: NDArray[np.int64] | None = None) -> ScatterTest:
    """Of the scatter about the mean of each group (n,), all together; about the mean of all where
    there are none."""
    w = s**-2.0
    group = np.zeros(found.size, dtype=np.int64) if group is None else group
    q, free, reach = 0.0, found.size, 0.0
    for one in np.unique(group):
        own = group == one
        mean = np.average(found[own], weights=w[own])
        q += float(np.sum(w[own] * (found[own] - mean) ** 2))
        reach += float(np.sum(w[own]) - np.sum(w[own] ** 2) / np.sum(w[own]))
        free -= 1
    return ScatterTest(
        float(chi2.sf(q, free)), math.sqrt(max(0.0, (q - free) / reach)) if reach > 0.0 else 0.0
    )


def _by_unit(
    found: Vector, s: Vector, units: NDArray[np.str_]
) -> tuple[ScatterTest | None, ScatterTest | None]:
    """Within the units, and between them; None where there is but one log of each, or one unit."""
    names, group = np.unique(units, return_inverse=True)
    within = _test(found, s, group) if names.size < found.size else None
    if names.size < 2 or within is None:
        return within, None
    wide = np.hypot(s, within.beyond)
    means = np.array([_mean(found[group == one], wide[group == one]) for one in range(names.size)])
    errors = np.array(
        [float(np.sum(wide[group == one] ** -2.0)) ** -0.5 for one in range(names.size)]
    )
    return within, _test(means, errors)


def _drift(
    values: Sequence[UnitValue],
    found: Vector,
    s: Vector,
    units: NDArray[np.str_],
    confidence: float,
) -> ParameterDrift | None:
    """None where no unit has dates that differ, or nothing is left to tell how far the logs are off
    the line."""
    days = [one.day for one in values]
    if any(day is None for day in days):
        return None
    day, w = np.array(days, dtype=np.float64), s**-2.0
    names, group = np.unique(units, return_inverse=True)
    for one in range(names.size):
        own = group == one
        day[own] -= np.average(day[own], weights=w[own])
    about = (
        found
        - np.array([_mean(found[group == one], s[group == one]) for one in range(names.size)])[
            group
        ]
    )
    reach, free = float(np.sum(w * day**2)), found.size - names.size - 1
    if free < 1 or float(np.ptp(day)) == 0.0:
        return None
    slope = float(np.sum(w * day * about)) / reach
    birge = math.sqrt(max(1.0, float(np.sum(w * (about - slope * day) ** 2)) / free))
    error = birge / math.sqrt(reach)
    half = float(student.ppf(0.5 * (1.0 + confidence), free)) * error
    return ParameterDrift(
        Interval(slope, slope - half, slope + half),
        2.0 * float(student.sf(abs(slope) / error, free)),
    )
