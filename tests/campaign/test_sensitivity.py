"""Factors that cause failures, question by question, and effects that two factors have only
together."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from frictool.campaign.draws.factor_space import Factor, FactorSpace
from frictool.campaign.statistics.sensitivity import masks, sensitivity
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, Trials
from tests.support.campaign_trials import factors, trials_of
from tests.support.sensitivity_functions import vertices

Array = np.ndarray


def late(v: Array) -> Array:
    """Large where x1 is large, more so with x2."""
    return np.asarray(v[:, 0] * (1.0 + v[:, 1]))


def far(v: Array) -> Array:
    return np.asarray(np.abs(v[:, 2] - 0.5))


def test_each_requirement_has_the_factors_that_break_it() -> None:
    found = sensitivity(trials_of(factors(5), [late, far], [1.4, 0.47], 1500), drawn=True)
    any_, first, second = found.questions
    assert (any_.name, first.name, second.name) == ("", "metric_1", "metric_2")
    assert set(any_.named) == {0, 1, 2}
    assert first.named == (0, 1)
    assert second.named == (2,)
    assert [first.regions[i].direction for i in (0, 1)] == ["high", "high"]
    assert second.regions[2].direction == "both ends"


def test_a_question_that_only_repeats_another_is_not_asked_twice_and_none_without_failures() -> (
    None
):
    assert [name for name, _, _ in masks(trials_of(factors(3), [late, far], [1.4, 9.0], 300))] == [
        ""
    ]
    assert sensitivity(trials_of(factors(2), [late], [9.0], 300), drawn=True).questions == ()
    assert (
        sensitivity(trials_of(factors(2), [late], [-1.0], 300), drawn=True).questions == ()
    )  # none passes
    assert sensitivity(trials_of(factors(2), [late], [-1.0], 300), drawn=True).pair is None


def test_what_cannot_be_simulated_is_a_question_of_its_own() -> None:
    made = trials_of(factors(3), [late], [9.0], 400)
    stopped = np.flatnonzero(made.values[:, 2] < 0.1)
    found = sensitivity(
        trials_of(factors(3), [late], [1.8], 400, failed=stopped.tolist()), drawn=True
    )
    assert [question.name for question in found.questions] == ["", "metric_1", "not simulated"]
    assert found.questions[-1].named == (2,)
    assert found.questions[-1].failing == stopped.size


def test_undecided_trials_are_on_neither_side() -> None:
    made = trials_of(factors(2), [late], [1.0], 200)
    passed = made.passed.copy()
    passed[:50] = UNDECIDED
    question = sensitivity(dataclasses.replace(made, passed=passed), drawn=True).questions[0]
    assert question.failing == np.count_nonzero(passed == BROKEN)
    assert question.passing == np.count_nonzero(passed == MET)


def _parity(v: Array) -> Array:
    """1 where just one of x2, x4 is in its upper half: neither does anything alone."""
    return np.asarray(((v[:, 1] > 0.5) != (v[:, 3] > 0.5)).astype(float))


def test_the_pair_is_found_that_acts_only_together() -> None:
    found = sensitivity(trials_of(factors(5), [_parity], [0.5], 1000), drawn=True)
    assert found.questions[0].named == ()
    assert found.pair is not None
    assert (found.pair.first, found.pair.second) == (1, 3)
    assert found.pair.joint > 0.9
    assert found.pair.beyond > 0.9


def test_without_an_interaction_there_is_nothing_beyond() -> None:
    beyond = []
    for seed in range(30):
        coin = np.random.default_rng(1000 + seed).random(500)
        found = sensitivity(
            trials_of(factors(2), [lambda v, c=coin: 0.5 * v[:, 0] + c], [1.2], 500, seed),
            drawn=True,
        ).pair
        assert found is not None
        beyond.append(found.beyond / found.error)
    assert np.std(beyond) < 1.5
    assert abs(np.mean(beyond)) < 0.6


def test_vertices_have_no_probabilities() -> None:
    found = sensitivity(vertices(4, lambda v: 3.0 * v[:, 0] + 1.5 * v[:, 1]), drawn=False)
    question = found.questions[0]
    assert question.named == (0, 1)
    assert all(one.chance is None for one in question.regions)
    assert found.pair is not None
    assert (found.pair.first, found.pair.second, found.pair.error) == (0, 1, 0.0)
    assert found.pair.joint == pytest.approx(1.0)
    assert found.pair.beyond == pytest.approx(
        1.0 / 3.0
    )  # both are needed: shares of 1/3 each alone


def _counts(n: int) -> Trials:
    made = trials_of(factors(1), [lambda v: v[:, 0]], [9.0], n)
    space = FactorSpace((Factor("lost", -2.0, 2.0, "1", "lost counts", 0.0, "sensor", whole=True),))
    values = space.values(made.units)
    met = np.where(np.abs(values) > 1.5, BROKEN, MET).astype(np.int8)
    return dataclasses.replace(
        made, space=space, values=values, metric_values=np.abs(values), met=met, passed=met[:, 0]
    )


def test_a_factor_of_whole_numbers_has_a_slice_for_each() -> None:
    found = sensitivity(_counts(400), drawn=True)
    one = found.questions[0].regions[0]
    np.testing.assert_array_equal(one.centres, [-2.0, -1.0, 0.0, 1.0, 2.0])
    np.testing.assert_array_equal(one.failing, [1.0, 0.0, 0.0, 0.0, 1.0])
    assert found.influences[0].shares[0].share == pytest.approx(1.0)


def test_a_campaign_without_a_factor_has_nothing_to_explain() -> None:
    made = trials_of(factors(1), [late_of_noise], [0.5], 100)
    found = sensitivity(
        dataclasses.replace(
            made, space=FactorSpace(()), units=made.units[:, :0], values=made.values[:, :0]
        ),
        drawn=True,
    )
    assert found.pair is None
    assert found.influences[0].shares == ()
    assert found.questions[0].named == ()


def late_of_noise(v: Array) -> Array:
    return np.asarray(v[:, 0])
