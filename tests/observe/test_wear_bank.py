"""The filters of a bank against least squares and densities written out, what tells a change, and
how weights follow the moves."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal, norm

from frictool.observe.wear.change_detection import MEMORIES, SURPRISE, ChangeDetector
from frictool.observe.wear.filter_bank import (
    BEFOREHAND,
    EVIDENCE,
    PRIOR_ROWS,
    SLOPES,
    UNMODELLED,
    FilterBank,
)
from frictool.observe.wear.log_moves import Move
from frictool.observe.wear.parameter_restriction import ParameterRestriction, multiplicative
from frictool.observe.wear.weak_form_layout import layout_of
from frictool.typing import Vector
from studies.rigs.clutch_fleet import clutch

NAMES = ("a", "b", "wear")
COUNT = len(BEFOREHAND)


def restrictions(draw: np.random.Generator) -> list[ParameterRestriction]:
    """Return restrictions of five columns to three parameters, which differ in their prior
    knowledge."""
    matrix, fixed = draw.normal(size=(5, 3)), draw.normal(size=5)
    return [
        ParameterRestriction(NAMES, matrix, fixed, draw.normal(size=3), draw.uniform(0.5, 2.0, 3))
        for _ in range(COUNT)
    ]


class Still(ChangeDetector):
    """Tells of no change, and notes what it is given."""

    def add_move(self, step: Vector, weight: Vector) -> Vector:
        self.given = step, weight
        return np.zeros_like(step)


def unchanging(known: list[ParameterRestriction], variance: float, inflation: float) -> FilterBank:
    bank = FilterBank(known, variance, inflation, "wear", 0.0)
    bank._changes = Still(bank.means.shape, 2)
    return bank


def moved(rows: Vector, effort: Vector, time: float = 0.0) -> Move:
    whole = np.column_stack([rows, effort])
    return Move(whole.T @ whole, rows.shape[0], time, 1, 1.0)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**31))
def test_a_filter_is_least_squares_with_what_is_known(seed: int) -> None:
    draw = np.random.Generator(np.random.PCG64(seed))
    known = restrictions(draw)
    bank = unchanging(known, 1.0, 2.0)
    rows, noise = draw.normal(size=(12, 5)), bank.noise
    own = known[0]
    truth = own.mean + own.deviation * draw.normal(size=3)
    effort = rows @ (own.fixed + own.matrix @ truth) + 0.3 * draw.normal(size=12)
    assert noise == 2.0
    bank.take(moved(rows, effort))
    for index, one in enumerate(known):
        design, weight = rows @ one.matrix, np.diag(one.deviation**-2.0)
        precision = design.T @ design / noise + weight
        found = np.linalg.solve(
            precision, design.T @ (effort - rows @ one.fixed) / noise + weight @ one.mean
        )
        np.testing.assert_allclose(
            bank.means[index] + bank.deviations[index] * bank.states[index],
            found,
            rtol=1e-8,
            atol=1e-8,
        )
        scale = np.outer(one.deviation, one.deviation)
        np.testing.assert_allclose(
            bank.spreads[index] * scale, np.linalg.inv(precision), rtol=1e-7, atol=1e-9
        )


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**31))
def test_weights_are_the_densities_of_what_was_not_foreseen(seed: int) -> None:
    draw = np.random.Generator(np.random.PCG64(seed))
    known = restrictions(draw)
    bank = unchanging(known, 1.0, 1.5)
    rows, noise = draw.normal(size=(9, 5)), 1.5
    effort = rows @ (known[1].fixed + known[1].matrix @ known[1].mean) + draw.normal(size=9)
    bank.take(moved(rows, effort))
    density = []
    for one in known:
        design = rows @ one.matrix
        spread = design @ np.diag(one.deviation**2) @ design.T + noise * np.eye(9)
        density.append(
            multivariate_normal.logpdf(effort, rows @ (one.fixed + one.matrix @ one.mean), spread)
        )
    likely = EVIDENCE * np.array(density) + np.array(BEFOREHAND)
    np.testing.assert_allclose(
        bank.weights,
        np.exp(likely - likely.max()) / np.exp(likely - likely.max()).sum(),
        rtol=1e-6,
        atol=1e-12,
    )
    values = np.array([one.mean for one in known]) + bank.deviations * bank.states
    mean, deviation = bank.value("b")
    assert mean == pytest.approx(bank.weights @ values[:, 1])
    assert deviation**2 >= bank.weights @ (values[:, 1] - mean) ** 2 * (1.0 - 1e-9)


def test_an_interval_holds_its_share_of_the_mixture() -> None:
    draw = np.random.default_rng(3)
    bank = unchanging(restrictions(draw), 0.1, 1.0)
    bank.take(moved(draw.normal(size=(4, 5)), draw.normal(size=4)))
    means = bank.means[:, 2] + bank.deviations[:, 2] * bank.states[:, 2]
    deviations = bank.deviations[:, 2] * np.sqrt(bank.spreads[:, 2, 2])
    for end, share in zip(bank.interval("wear", 0.9), (0.05, 0.95), strict=True):
        assert bank.weights @ norm.cdf(end, means, deviations) == pytest.approx(share, abs=1e-8)


def test_the_variance_of_a_row_is_learned() -> None:
    draw = np.random.Generator(np.random.PCG64(5))
    known = restrictions(draw)
    bank = unchanging(known, 100.0, 1.0)
    truth = known[0].fixed + known[0].matrix @ known[0].mean
    for _ in range(200):
        rows = draw.normal(size=(20, 5))
        bank.take(moved(rows, rows @ truth + 0.1 * draw.normal(size=20)))
    left = 100.0 * PRIOR_ROWS / (PRIOR_ROWS + 4000.0)  # of what was known beforehand
    assert bank.noise - left == pytest.approx(0.01, rel=0.1)


def test_a_step_is_found_by_generalised_least_squares() -> None:
    """The numerators and denominators that ChangeDetector is given, against S written out over
    rows."""
    draw = np.random.Generator(np.random.PCG64(11))
    known = [dataclasses.replace(one, deviation=np.full(3, 0.1)) for one in restrictions(draw)]
    bank = unchanging(known, 1.0, 1.0)
    rows, effort = draw.normal(size=(15, 5)), draw.normal(size=15)
    bank.take(moved(rows, effort))
    watching = bank._changes
    assert isinstance(watching, Still)
    step, weight = watching.given
    for index, one in enumerate(known):
        design = rows @ one.matrix * one.deviation
        inverse = np.linalg.inv(np.eye(15) + design @ design.T)
        missed = effort - rows @ (one.fixed + one.matrix @ one.mean)
        np.testing.assert_allclose(step[index], design.T @ inverse @ missed, rtol=1e-8)
        np.testing.assert_allclose(weight[index], np.diag(design.T @ inverse @ design), rtol=1e-8)


def test_changes_are_told_at_the_stated_rate_and_drifts_before_any_single_move_shows_them() -> None:
    draw = np.random.Generator(np.random.PCG64(3))
    moves, trials = 50, 400
    false, found, single = 0, 0, 0
    for _ in range(trials):
        quiet, drifting = ChangeDetector((1, 2), 0), ChangeDetector((1, 2), 0)
        for _ in range(moves):
            z = draw.normal(size=(1, 2))
            false += bool(np.any(quiet.add_move(z, np.ones((1, 2))) > 0.0))
            lagging = z + np.array([[1.5, 0.0]])
            single += bool(abs(lagging[0, 0]) > SURPRISE)
            if drifting.add_move(lagging, np.ones((1, 2)))[0, 0] > 0.0:
                found += 1
                break
    assert (
        false / (trials * moves) < 2.0 * MEMORIES.size * 2.0 * 6.4e-5
    )  # two-sided 4 deviations, two parameters
    assert found == trials
    assert single < 0.5 * trials


def test_the_wear_is_told_before_another_parameter_that_explains_as_much() -> None:
    change = ChangeDetector((1, 3), 2)
    walked = change.add_move(np.array([[0.0, 6.1, 6.0]]), np.ones((1, 3)))
    assert walked[0, :2].tolist() == [0.0, 0.0]
    assert walked[0, 2] == pytest.approx(np.sqrt(9.0 - 1.0))  # what is left is 2 deviations
    other = ChangeDetector((1, 3), 2).add_move(np.array([[0.0, 9.0, 6.0]]), np.ones((1, 3)))
    assert other[0].tolist() == pytest.approx([0.0, np.sqrt(4.5**2 - 1.0), 0.0])
    assert np.all(ChangeDetector((1, 3), 2).add_move(np.zeros((1, 3)), np.zeros((1, 3))) == 0.0)


def test_what_a_model_lets_its_unit_be() -> None:
    model, layout = clutch(), layout_of(clutch())
    tight, loose = (
        multiplicative(model, layout, UNMODELLED[0]),
        multiplicative(model, layout, UNMODELLED[len(SLOPES) - 1]),
    )
    inertia, wear, knee = (tight.index(name) for name in ("inertia", "wear", "bend_2"))
    assert tight.mean[inertia] == model.parameters.inertia.value
    assert tight.deviation[inertia] >= 0.3 * model.parameters.inertia.value
    assert layout.knees[2] == 260.0
    assert tight.mean[knee] == pytest.approx(3.81e-4)  # table 5.2
    assert tight.mean[wear] == 1.0
    top = model.bench.mechanics.top_speed
    assert top is not None
    slope = loose.mean[loose.index("viscous")] * top.value / layout.friction
    assert slope == pytest.approx(1.0)
    assert tight.mean[tight.index("viscous")] == pytest.approx(
        0.003 * loose.mean[loose.index("viscous")]
    )
    dry = np.array([name.startswith("dry") for name in layout.names])
    np.testing.assert_array_equal(tight.matrix[:, wear], dry.astype(float))


def test_a_first_move_that_is_noisier_than_was_known_weighs_by_its_own_noise() -> None:
    draw = np.random.Generator(np.random.PCG64(17))
    errors = []
    for _ in range(200):
        known = restrictions(draw)[:1] * COUNT
        own = known[0]
        bank = unchanging(known, 1e-4, 1.0)  # 0.01 is known beforehand, 1 is true
        truth = own.mean + own.deviation * draw.normal(size=3)
        rows = draw.normal(size=(40, 5))
        bank.take(moved(rows, rows @ (own.fixed + own.matrix @ truth) + draw.normal(size=40)))
        value, deviation = bank.value("wear")
        errors.append((value - truth[own.index("wear")]) / deviation)
    assert 0.8 <= np.std(errors) <= 1.3


@pytest.mark.parametrize("seed", range(3))
def test_the_noise_of_a_rough_first_move_scales_with_the_unit_of_effort(seed: int) -> None:
    """An effort in mN has a variance of 1e-6 of that in N, with the same rows spent."""
    draw = np.random.default_rng(seed)
    known, rows = restrictions(draw), draw.normal(size=(12, 5))
    effort = rows @ known[0].fixed + 20.0 * draw.normal(size=12)
    found = []
    for unit in (1.0, 1e-3):
        scaled = [
            dataclasses.replace(
                one, fixed=unit * one.fixed, mean=unit * one.mean, deviation=unit * one.deviation
            )
            for one in known
        ]
        bank = unchanging(scaled, 1e-2 * unit**2, 2.0)
        bank.take(moved(rows, unit * effort))
        found.append([bank.noise / unit**2, *(bank.spreads.ravel())])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6, atol=1e-9)
    assert found[0][0] > 10.0 * 1e-2
