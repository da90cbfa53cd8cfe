"""The pass rate: undecided trials on neither side, those that could not be simulated as failures,
vertices without a rate."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from frictool.campaign.statistics.clopper_pearson import interval, lower
from frictool.campaign.statistics.pass_rate import pass_rate
from frictool.campaign.trials.trials import UNDECIDED
from tests.support.campaign_trials import factors, trials_of


def test_the_rate_counts_what_passed_and_what_could_not_be_simulated_as_failed() -> None:
    trials = trials_of(factors(2), [lambda v: v[:, 0]], [0.9], 200, seed=3, failed=(0, 1, 2))
    rate = pass_rate(trials, "random")
    assert rate.passed + rate.failed == rate.count == 200
    assert rate.passed == np.count_nonzero(trials.values[3:, 0] <= 0.9)
    assert rate.not_run == 3
    assert (rate.low, rate.high) == interval(rate.passed, 200)
    assert rate.at_least == lower(rate.passed, 200)
    assert rate.low < rate.at_least < rate.share < rate.high


def test_undecided_trials_widen_the_interval_to_both_sides() -> None:
    trials = trials_of(factors(1), [lambda v: v[:, 0]], [0.9], 100)
    open_ = trials.passed.copy()
    open_[:20] = UNDECIDED
    rate = pass_rate(dataclasses.replace(trials, passed=open_), "random")
    passed = int(np.count_nonzero(open_ == 1))
    assert rate.undecided == 20
    assert rate.low == interval(passed, 100)[0]
    assert rate.high == interval(passed + 20, 100)[1]
    assert not rate.reaches(0.9)


def test_all_vertices_have_no_rate_and_a_part_of_them_tells_of_all() -> None:
    trials = trials_of(factors(3), [lambda v: v[:, 0]], [0.9], 8)
    whole = pass_rate(trials, "vertices")
    assert whole.whole
    assert whole.low is whole.high is whole.at_least is None
    assert whole.reaches(whole.passed / 8)
    part = pass_rate(trials_of(factors(4), [lambda v: v[:, 0]], [0.9], 8), "vertices")
    assert not part.whole
    assert part.at_least == pytest.approx(lower(part.passed, 8))
