"""Many identifications of one population keep the level; of different ones, the difference is
reported."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from scipy.stats import binom, norm

from frictool.identify.batch import BatchModel, BatchResult, LogGroup
from frictool.identify.batch_table import batch_populations
from frictool.identify.fit_result import Interval
from frictool.identify.population import Population, UnitValue, population, populations
from frictool.logs.origin import LogOrigin

CONFIDENCE, DRAWS = 0.95, 500
Z = float(norm.ppf(0.975))
MEAN = 0.1


def drawn(
    generator: np.random.Generator,
    units: int,
    logs: int,
    between: float = 0.0,
    within: float = 0.0,
    slope: float = 0.0,
) -> list[UnitValue]:
    """Values whose standard deviations s are 1e-3 to 3e-3. between, within: what the units and
    their logs scatter beyond, in 1e-3."""
    values = []
    for unit in range(units):
        own = MEAN + 1e-3 * between * generator.normal()
        for log in range(logs):
            s = 1e-3 * generator.uniform(1.0, 3.0)
            truth = own + 1e-3 * within * generator.normal() + slope * 30.0 * log
            found = float(truth + s * generator.normal())
            values.append(
                UnitValue(Interval(found, found - Z * s, found + Z * s), f"U{unit}", 30.0 * log)
            )
    return values


def share_of(told: list[bool]) -> float:
    return sum(told) / len(told)


def test_one_population_is_called_several_as_rarely_as_asked() -> None:
    generator = np.random.default_rng(1)
    found = [population(drawn(generator, 3, 4), CONFIDENCE, 0.05) for _ in range(DRAWS)]
    wrong = sum(not one.one for one in found)
    assert wrong <= binom.ppf(
        0.999, DRAWS, 0.05
    )  # four tests share the level, so that it is kept and not reached
    p = np.sort(
        [one.whole.p for one in found]
    )  # uniform: Kolmogorov's distance stays below its bound at 0.1 %
    assert np.max(np.abs(p - (np.arange(DRAWS) + 0.5) / DRAWS)) < 1.95 / np.sqrt(DRAWS)


def test_units_that_differ_are_told_from_logs_that_do() -> None:
    generator = np.random.default_rng(2)
    apart = [population(drawn(generator, 6, 4, between=8.0), CONFIDENCE, 0.05) for _ in range(100)]
    assert share_of([one.rejects(one.between) for one in apart]) > 0.95
    assert share_of([one.rejects(one.within) for one in apart]) < 0.05
    beyond = np.array([one.between.beyond for one in apart if one.between is not None])
    assert np.sqrt(np.mean(beyond**2)) == pytest.approx(8e-3, rel=0.15)
    restless = [
        population(drawn(generator, 6, 8, within=6.0), CONFIDENCE, 0.05) for _ in range(100)
    ]
    assert share_of([one.rejects(one.within) for one in restless]) > 0.99
    # units are held against what their own logs scatter, and not called different for it more often
    # than a test of few units is
    assert share_of([one.rejects(one.between) for one in restless]) < 0.08
    assert np.sqrt(
        np.mean([one.within.beyond**2 for one in restless if one.within is not None])
    ) == pytest.approx(6e-3, rel=0.15)


def test_a_drift_is_found_and_its_interval_holds_it() -> None:
    generator = np.random.default_rng(3)
    slope = 4e-5  # per day: about six of its standard errors
    found = [
        population(drawn(generator, 3, 8, between=5.0, within=1.0, slope=slope), CONFIDENCE, 0.05)
        for _ in range(200)
    ]
    drifts = [one.drift for one in found if one.drift is not None]
    assert len(drifts) == 200
    assert share_of([one.rejects(one.drift) for one in found]) > 0.9
    held = sum(one.slope.low <= slope <= one.slope.high for one in drifts)
    assert binom.ppf(0.001, 200, 0.90) <= held
    only = drawn(np.random.default_rng(4), 2, 6)
    only[7] = UnitValue(Interval(0.2, 0.198, 0.202), "U1", 30.0)
    assert population(only, CONFIDENCE, 0.05).changing == ["U1"]


def test_what_is_not_known_is_not_tested() -> None:
    unnamed = [UnitValue(value.interval) for value in drawn(np.random.default_rng(5), 2, 4)]
    found = population(unnamed, CONFIDENCE, 0.05)
    assert (found.within, found.between, found.drift, found.alone) == (None, None, None, {})
    assert found.limit == 0.05
    once = [
        UnitValue(value.interval, f"U{number}", value.day) for number, value in enumerate(unnamed)
    ]
    assert population(once, CONFIDENCE, 0.05).within is None
    undated = [
        UnitValue(value.interval, value.unit) for value in drawn(np.random.default_rng(5), 2, 4)
    ]
    assert population(undated, CONFIDENCE, 0.05).drift is None


def test_parameters_share_the_level_and_one_model_is_no_population() -> None:
    generator = np.random.default_rng(6)
    told = populations(
        {
            "inertia": drawn(generator, 2, 3),
            "coulomb": drawn(generator, 2, 3),
            "offset": [],
            "breakaway": once(),
        },
        CONFIDENCE,
    )
    assert set(told) == {"inertia", "coulomb"}
    assert all(one.level == pytest.approx(0.025) for one in told.values())


def once() -> list[UnitValue]:
    return [UnitValue(Interval(1.0, 0.9, 1.1))]


def test_intervals_that_are_cut_at_zero_or_points_are_taken() -> None:
    cut = [UnitValue(Interval(value, 0.0, value + Z)) for value in (0.2, 0.5, 0.1)]
    found: Population = population(cut, CONFIDENCE, 0.05)
    assert found.expected == pytest.approx(1.0)  # of the side that is not cut
    assert found.one
    points = [UnitValue(Interval(value, value, value)) for value in (1.0, 1.0, 1.5)]
    assert not population(points, CONFIDENCE, 0.05).one
    assert population(points[:2], CONFIDENCE, 0.05).one


def test_the_drift_of_a_batch_is_per_day_and_an_hour_of_a_zone_counts() -> None:
    slope, start = 1e-4, datetime(2025, 3, 1, tzinfo=UTC)
    batch = []
    for number, zone in enumerate((0, 9, -5, 0, 2)):
        day = 40.0 * number
        date = (start + timedelta(days=day)).astimezone(timezone(timedelta(hours=zone)))
        value = Interval.around(MEAN + slope * day, 1e-3)
        model = BatchModel({"coulomb": value}, "least-squares", None, "", {}, ())
        origin = LogOrigin("U1", date.isoformat())
        batch.append(BatchResult(LogGroup(f"log{number}", ()), origin, model))
    drift = batch_populations(batch, CONFIDENCE)["coulomb"].drift
    assert drift is not None
    assert drift.slope.value == pytest.approx(slope, rel=1e-9)
