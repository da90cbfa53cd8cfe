"""Trials: put in order whatever order they come in; what could not be simulated is there and has
not passed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from frictool.campaign.draws.factor_space import Factor, FactorSpace, plant_factors, space_of
from frictool.campaign.trials.trials import (
    BROKEN,
    MET,
    UNDECIDED,
    MetricLimit,
    TrialResult,
    collect_trials,
    trial_outcomes,
)
from frictool.documents.quantity import Quantity
from frictool.simulate.simulated_plant import VariedParameter
from tests.support.campaign_trials import factors, trials_of

METRIC = MetricLimit("overshoot", "overshoot_percent", "%", 5.0, "<=")


def test_trials_are_in_the_order_of_their_indices() -> None:
    units = np.array([[0.1], [0.2], [0.3]])
    of = [
        TrialResult(0, (1.0,), (MET,)),
        TrialResult(1, (9.0,), (BROKEN,)),
        TrialResult(2, (np.nan,), (UNDECIDED,)),
    ]
    for order in ([0, 1, 2], [2, 0, 1], [1, 2, 0]):
        trials = collect_trials(factors(1), [METRIC], units, [of[k] for k in order])
        np.testing.assert_array_equal(trials.metric_values[:, 0], [1.0, 9.0, np.nan])
        np.testing.assert_array_equal(trials.passed, [MET, BROKEN, UNDECIDED])
        assert trials.count == 3


def test_a_trial_that_is_missing_is_named() -> None:
    with pytest.raises(ValueError, match="trial 1 is missing"):
        collect_trials(
            factors(1),
            [METRIC],
            np.zeros((3, 1)),
            [TrialResult(0, (1.0,), (MET,)), TrialResult(2, (1.0,), (MET,))],
        )


def test_what_could_not_be_simulated_has_not_passed_and_no_metric_of_it_is_decided() -> None:
    trials = trials_of(factors(2), [lambda x: x[:, 0]], [0.5], 50, failed=(7,))
    assert trials.failed == {7: "the plant is out of range"}
    assert trials.passed[7] == BROKEN
    assert trials.met[7, 0] == UNDECIDED
    assert np.isnan(trials.metric_values[7, 0])
    assert np.sum(trials.passed == MET) == np.sum(np.delete(trials.values[:, 0], 7) <= 0.5)


def test_a_factor_that_may_not_fall_below_another_is_drawn_from_what_lies_above() -> None:
    """Breakaway [mN m] and Coulomb friction [N m]: each in its range, and every corner a plant."""
    ranges = {
        "coulomb": VariedParameter(0.03, 0.07, 0.05, "N m", "c"),
        "breakaway": VariedParameter(33.0, 77.0, 55.0, "mN m", "b", ("coulomb", 1000.0)),
    }
    space = space_of(plant_factors(ranges, {}, {}))
    coulomb, breakaway = space.values(np.random.default_rng(0).random((2000, 2))).T
    assert np.all(breakaway > np.maximum(33.0, 1000.0 * coulomb))
    assert stats.kstest((coulomb - 0.03) / 0.04, "uniform").pvalue > 1e-3
    above = (breakaway - np.maximum(33.0, 1000.0 * coulomb)) / (
        77.0 - np.maximum(33.0, 1000.0 * coulomb)
    )
    assert stats.kstest(above, "uniform").pvalue > 1e-3
    assert space.values(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])).tolist() == [
        [0.03, 33.0],
        [0.07, 70.0],
        [0.07, 77.0],
    ]
    known = {"coulomb": Quantity(value=40.0, unit="mN m")}
    (alone,) = space_of(
        plant_factors(
            ranges | {"coulomb": VariedParameter(0.05, 0.05, 0.05, "N m", "c")}, {}, known
        )
    ).factors
    assert (alone.low, alone.high, alone.least) == (pytest.approx(40.0), 77.0, None)


def test_values_fill_their_range_and_whole_numbers_are_equally_likely() -> None:
    units = np.linspace(0.0, 1.0, 10_001)[:, None]
    counts = Factor("lost", -2.0, 2.0, "1", "counts lost", 0.0, "sensor", whole=True)
    found, times = np.unique(FactorSpace((counts,)).values(units), return_counts=True)
    np.testing.assert_array_equal(found, [-2.0, -1.0, 0.0, 1.0, 2.0])
    assert np.ptp(times) <= 1
    line = FactorSpace(
        (Factor("coulomb", 0.02, 0.07, "N m", "Coulomb friction", 0.033, "plant"),)
    ).values(units)
    assert (line.min(), line.max()) == (0.02, 0.07)


def test_what_does_not_vary_is_no_factor() -> None:
    fixed = Factor("inertia", 1.0, 1.0, "kg", "inertia", 1.0, "plant")
    assert space_of([fixed, *factors(2).factors]).names == ("x1", "x2")


def test_a_trial_is_undecided_by_what_another_trial_decides() -> None:
    """No trial decides the last of three requirements; the second trial leaves the second one
    undecided."""
    met = np.array(
        [
            [MET, MET, UNDECIDED],
            [MET, UNDECIDED, UNDECIDED],
            [UNDECIDED, BROKEN, UNDECIDED],
            [UNDECIDED] * 3,
        ],
        dtype=np.int8,
    )
    np.testing.assert_array_equal(trial_outcomes(met), [MET, UNDECIDED, BROKEN, UNDECIDED])
    np.testing.assert_array_equal(trial_outcomes(met, (0,)), [BROKEN, UNDECIDED, BROKEN, UNDECIDED])
    np.testing.assert_array_equal(trial_outcomes(met[:, 2:]), [UNDECIDED] * 4)
