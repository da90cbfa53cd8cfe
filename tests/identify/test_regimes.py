"""Straight pieces of friction over speed: the knees are found where they are, and none where there
is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.identify.estimators.piecewise_friction import StrokeMeans, fit_pieces


def means(friction, noise: float, seed: int, top: float = 400.0) -> StrokeMeans:
    """60 strokes whose middles sweep from half to all of their top speed; friction: of speed."""
    generator = np.random.default_rng(seed)
    tops = np.linspace(0.1 * top, top, 60)
    speed = np.concatenate(
        [tops_ * np.sin(np.linspace(np.pi / 6.0, 5.0 * np.pi / 6.0, 25)) for tops_ in tops]
    )
    starts = np.arange(60) * 25
    sign = np.where(np.arange(60) % 2 == 0, 1.0, -1.0)
    effort = sign * np.add.reduceat(
        friction(speed), starts
    ) / 25.0 + noise * generator.standard_normal(60)
    return StrokeMeans(
        np.column_stack((sign, np.ones(60))),
        effort,
        sign,
        np.ones(60),
        np.arange(60),
        speed,
        starts,
    )


@settings(max_examples=25, deadline=None)
@given(st.floats(120.0, 330.0), st.floats(1e-4, 1e-3), st.floats(0.0, 2e-4))
def test_a_knee_is_found_where_it_is(knee: float, beyond: float, below: float) -> None:
    found = fit_pieces(
        means(lambda v: 0.1 + below * v + (beyond + below) * np.maximum(v - knee, 0.0), 1e-5, 1)
    )
    assert found.knees[0] == pytest.approx(knee, abs=1.0)
    assert found.solution.value[0] == pytest.approx(below, abs=3e-6)
    assert found.solution.value[len(found.knees)] == pytest.approx(beyond + 2.0 * below, rel=0.02)


def test_a_straight_line_has_no_knee() -> None:
    """At most one in a hundred: what Schwarz's criterion and the evidence asked for let through."""
    found = [fit_pieces(means(lambda v: 0.1 + 2e-4 * v, 2e-3, seed)) for seed in range(40)]
    assert sum(bool(pieces.knees) for pieces in found) <= 1


def test_what_an_unknown_inertia_explains_is_no_knee() -> None:
    """A curve over speed that the nuisance has too; without it two straight pieces are the better
    fit."""
    bent = means(lambda v: 0.1 + 2e-4 * v, 1e-4, 2)
    extra = bent.sign * (bent.mean(bent.speed) / 400.0) ** 2
    bent = replace(bent, effort=bent.effort + 5e-3 * extra)
    assert fit_pieces(bent).knees
    assert not fit_pieces(replace(bent, nuisance=extra[:, None])).knees


def test_two_knees() -> None:
    found = fit_pieces(
        means(
            lambda v: 0.1 + 4e-4 * np.maximum(v - 120.0, 0.0) - 3e-4 * np.maximum(v - 280.0, 0.0),
            2e-5,
            3,
        )
    )
    assert found.knees == pytest.approx((120.0, 280.0), abs=3.0)


def test_the_interval_of_a_knee_covers() -> None:
    hits = 0
    for seed in range(60):
        found = fit_pieces(
            means(lambda v: 0.1 + 4e-4 * np.maximum(v - 260.0, 0.0), 1e-3, seed), most=1
        )
        assert len(found.knees) == 1
        hits += abs(found.knees[0] - 260.0) <= found.solution.half_width(0.95)[-1]
    assert 51 <= hits <= 60  # binomial at 95 %, once in a thousand


@pytest.mark.parametrize(("stroke", "error"), [(58, -5e-3), (59, 5e-3), (59, -5e-3)])
def test_one_wrong_stroke_is_no_knee(stroke: int, error: float) -> None:
    """A transient of one of the fastest strokes pays for the two parameters of a knee."""
    straight = means(lambda v: 0.1 + 2e-4 * v, 1e-4, 4)
    effort = straight.effort.copy()
    effort[stroke] += error
    assert not fit_pieces(replace(straight, effort=effort)).knees


def test_a_piece_is_the_mean_of_the_clipped_speeds() -> None:
    one = means(lambda v: 0.1 + 1e-3 * v, 1e-4, seed=3)
    one = replace(one, speed=one.speed - 30.0)  # negative at the ends of slow strokes
    fast = float(one.speed.max())
    ranges = [(0.0, np.inf), (0.0, 0.3), (0.2, 0.7), (0.7, 0.2), (1.0, np.inf)]
    for low, high in ((fast * low, fast * high) for low, high in ranges):
        clipped = np.minimum(np.maximum(one.speed, low), high) - low
        np.testing.assert_allclose(
            one.piece(low, high), one.sign * one.mean(clipped), rtol=0.0, atol=1e-9 * fast
        )
    still = replace(one, speed=0.0 * one.speed)
    assert not np.any(still.piece(0.0, np.inf))
