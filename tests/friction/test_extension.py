"""Extensions: position, direction, dwell, speed regimes, film; each alone against its formula, and
together on any law."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.friction import lubricant_film
from frictool.friction.law_extension import FrictionExtension, levels
from frictool.friction.law_registry import LAWS
from frictool.friction.position_kernels import position_factor
from frictool.friction.position_polynomial import normalise
from frictool.friction.rising_breakaway import dwell_factor
from frictool.friction.speed_regimes import knee_force, knee_slope, regimes_from
from frictool.friction.stribeck import slip_force
from studies.rigs.clutch_friction import BACKWARD, FORWARD
from studies.rigs.table_3_1 import STRIBECK, TABLE_3_1, packed

TRAVEL = (0.0, 63.0)
KNEE = regimes_from([(260.0, 4e-4)])


@given(coefficients=st.lists(st.floats(-2, 2), min_size=1, max_size=5), x=st.floats(-5, 5))
def test_position_factor_is_the_polynomial_within_the_travel(
    coefficients: list[float], x: float
) -> None:
    inside = min(max(x, -1.0), 2.0)
    expected = max(0.0, sum(b * inside**i for i, b in enumerate(coefficients)))
    assert position_factor(np.array(coefficients), -1.0, 2.0, x) == pytest.approx(
        expected, rel=1e-9, abs=1e-9
    )


@pytest.mark.parametrize(
    ("coefficients", "lowest", "highest"),
    [(np.array(FORWARD), 0.079, 0.181), (np.array(BACKWARD), 0.058, 0.210)],
)
def test_breakaway_of_the_clutch(coefficients: np.ndarray, lowest: float, highest: float) -> None:
    """Table 4.7 over 0..63 rad; normalised to a mean of 1. The lowest backward value has the digits
    of b2- against it."""
    factors, mean = normalise(coefficients, *TRAVEL)
    x = np.linspace(*TRAVEL, 6301)
    values = np.array([mean * position_factor(factors, *TRAVEL, place) for place in x])
    assert values.min() == pytest.approx(lowest, abs=0.002)
    assert values.max() == pytest.approx(highest, abs=0.002)
    assert np.trapezoid(values / mean, x) / 63.0 == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("coefficients", "low", "high"), [([], 0, 1), ([math.nan], 0, 1), ([1.0], 1, 1), ([-1.0], 0, 1)]
)
def test_polynomials_that_give_no_factor_are_refused(
    coefficients: list[float], low: float, high: float
) -> None:
    with pytest.raises(ValueError, match=r"needs finite coefficients|allowed: > 0"):
        normalise(np.array(coefficients), low, high)


@given(dwell=st.floats(0, 1e6), fresh=st.floats(0.1, 1.0), rise=st.floats(0, 100))
def test_dwell_factor_rises_from_fresh_to_one(dwell: float, fresh: float, rise: float) -> None:
    factor = dwell_factor(dwell, fresh, rise)
    assert fresh - 1e-12 <= factor <= 1.0
    assert dwell_factor(dwell + 1.0, fresh, rise) >= factor
    assert factor == pytest.approx(
        1.0 if rise == 0 else fresh + (1 - fresh) * dwell / (rise + dwell), rel=1e-9
    )


@given(v=st.floats(-400, 400))
def test_knee_force_is_continuous_odd_and_dissipates(v: float) -> None:
    expected = math.copysign(4e-4 * max(0.0, abs(v) - 260.0), v)
    assert knee_force(v, KNEE) == pytest.approx(expected, abs=1e-15)
    assert knee_force(-v, KNEE) == -knee_force(v, KNEE)
    assert knee_force(v, KNEE) * v >= 0.0
    if abs(abs(v) - 260.0) > 1e-3:
        found = (knee_force(v + 1e-4, KNEE) - knee_force(v - 1e-4, KNEE)) / 2e-4
        assert knee_slope(v, KNEE) == pytest.approx(found, abs=1e-9)
    assert knee_force(v, np.zeros(0)) == 0.0


@pytest.mark.parametrize("speed", [50.0, 180.0, 300.0, -300.0])
def test_the_slope_of_two_knees_is_that_of_their_force(speed: float) -> None:
    knees = regimes_from([(100.0, 4e-4), (260.0, -1e-4)])
    difference = knee_force(speed + 1e-4, knees) - knee_force(speed - 1e-4, knees)
    assert knee_slope(speed, knees) == pytest.approx(difference / 2e-4, abs=1e-9)


@pytest.mark.parametrize(
    "points", [[(260.0, 1e-4), (200.0, 1e-4)], [(260.0, -1e-4)], [(0.0, 1.0)], [(math.nan, 1.0)]]
)
def test_speed_regimes_out_of_order_are_refused(points: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="allowed: rising knees > 0"):
        regimes_from(points)


@given(start=st.floats(-1, 1), end=st.floats(-1, 1), held=st.floats(-1, 1), lag=st.floats(0.01, 10))
def test_lagged_film_is_the_response_of_the_lag(
    start: float, end: float, held: float, lag: float
) -> None:
    """Against 4000 steps of the trapezoidal rule."""
    step, count = 0.5, 4000
    h, w = step / count, held
    for k in range(count):
        before, after = (start + (end - start) * (k + i) / count for i in (0, 1))
        w = (w * (1 - h / (2 * lag)) + h / (2 * lag) * (before + after)) / (1 + h / (2 * lag))
    assert lubricant_film.lagged_film(held, start, end, lag, step) == pytest.approx(w, abs=1e-4)
    assert lubricant_film.lagged_film(held, start, end, 0.0, step) == end


@given(velocities=st.lists(st.floats(-1, 1), min_size=1, max_size=20), samples=st.integers(0, 5))
def test_delayed_film_is_the_velocity_of_n_samples_ago(
    velocities: list[float], samples: int
) -> None:
    history = np.zeros(samples + 1)
    found = [lubricant_film.delayed_film(history, v) for v in velocities]
    assert found == ([0.0] * samples + velocities)[: len(velocities)]


def test_frictional_memory_makes_a_loop_of_the_curve() -> None:
    """At the same speed friction is higher while the body accelerates than while it slows down
    (3.4.2.3)."""
    p, lag, step, w, forces = packed(LAWS["stribeck"]), 0.05, 1e-3, 1e-3, []
    t = np.arange(0, 4, step)
    v = 2e-3 + 1e-3 * np.sin(2 * math.pi * t)
    for before, after in itertools.pairwise(v):
        w = lubricant_film.lagged_film(w, before, after, lag, step)
        forces.append(lubricant_film.film_force(slip_force(w, 1.0, p), after, w, p[4]))
    speeding, slowing = forces[3000 - 1], forces[3500 - 1]
    assert v[3000] == pytest.approx(v[3500])
    assert speeding > slowing + 1e-3
    assert lubricant_film.film_force(slip_force(2e-3, 1.0, p), 2e-3, 2e-3, p[4]) == slip_force(
        2e-3, 1.0, p
    )


@given(scale=st.floats(1e-4, 1.0), exponent=st.floats(0.6, 3.0), viscous=st.floats(0.01, 2.0))
def test_full_film_begins_at_the_minimum_of_the_curve(
    scale: float, exponent: float, viscous: float
) -> None:
    p = packed(
        LAWS["stribeck"],
        {**STRIBECK, "stribeck_velocity": scale, "stribeck_exponent": exponent, "viscous": viscous},
    )
    start = lubricant_film.full_film_velocity(p)
    speeds = np.concatenate([np.geomspace(1e-6 * scale, 1e3 * scale, 400)])
    forces = np.array([slip_force(v, 1.0, p) for v in speeds])
    beyond = forces[speeds > start]
    assert np.all(np.diff(beyond) >= 0.0)
    if start > 0.0:
        falling = slip_force(0.999 * start, 1.0, p)
        assert falling >= slip_force(start, 1.0, p)
        assert slip_force(1.001 * start, 1.0, p) >= slip_force(start, 1.0, p)


def test_the_four_regimes_of_figure_2_16_follow_each_other() -> None:
    p, boundary = packed(LAWS["stribeck"]), 1e-3
    full = boundary + lubricant_film.full_film_velocity(p)
    speeds = [0.0, 0.5 * boundary, boundary, 1.001 * boundary, 0.999 * full, 1.001 * full, -1.0]
    assert [lubricant_film.regime(v, boundary, p) for v in speeds] == [1, 2, 2, 3, 3, 4, 4]
    flat = [
        lubricant_film.film_force(
            slip_force(lubricant_film.boundary_film(v, boundary), 1.0, p),
            v,
            lubricant_film.boundary_film(v, boundary),
            0.4,
        )
        for v in (1e-4, 1e-3)
    ]
    assert flat[1] - flat[0] == pytest.approx(
        0.4 * 9e-4, rel=1e-9
    )  # dry friction does not depend on the velocity
    assert (
        lubricant_film.full_film_velocity(packed(LAWS["stribeck"], STRIBECK | {"viscous": 0.0}))
        == math.inf
    )
    assert (
        lubricant_film.full_film_velocity(packed(LAWS["stribeck"], STRIBECK | {"breakaway": 1.0}))
        == 0.0
    )


EXTENSION = FrictionExtension(
    backward_values={"coulomb": 0.8},
    forward=(0.5, 1.0),
    backward=(1.5, -1.0),
    travel=(0.0, 1.0),
)


@pytest.mark.parametrize("name", sorted(LAWS))
@settings(derandomize=True, deadline=None, max_examples=15)
@given(x=st.floats(-0.5, 1.5), forward=st.booleans(), dwell=st.floats(0, 10))
def test_every_law_takes_the_levels(name: str, x: float, forward: bool, dwell: float) -> None:
    """F_c and F_s follow direction, position and dwell; nothing else in p changes."""
    law, q = LAWS[name], {**TABLE_3_1[name]}
    if name == "elasto_plastic":
        q["elastic_limit"] = 1e-6
    stores = law.kind == "dynamic" and "presliding_limit" in q
    if stores:
        with pytest.raises(ValueError, match="more energy than was stored"):
            EXTENSION.pack(law, law.pack(q))
    even = (
        FrictionExtension(forward=EXTENSION.forward, backward=EXTENSION.forward)
        if stores
        else EXTENSION
    )
    rests = "breakaway" in q and law.kind != "dynamic"
    rising = (
        FrictionExtension(**{**vars(EXTENSION), "fresh": 0.7, "rise_time": 1.0}) if rests else even
    )
    plus, minus, packed_extension = rising.pack(law, law.pack(q))
    out = np.empty_like(plus)
    levels(plus, minus, packed_extension, x, 1.0 if forward else -1.0, dwell, out)
    inside = min(max(x, 0.0), 1.0)
    factor = 0.5 + inside if forward or stores else 1.5 - inside
    coulomb = (1.0 if forward or stores else 0.8) * factor
    assert out[0] == pytest.approx(coulomb, rel=1e-12)
    if "breakaway" in q:
        rested = 1.5 * factor * (1.0 if not rests else 0.7 + 0.3 * dwell / (1.0 + dwell))
        assert out[1] == pytest.approx(max(coulomb, rested), rel=1e-12)
    kept = 2 if "breakaway" in q else 1
    np.testing.assert_array_equal(out[kept:], (plus if forward else minus)[kept:])


def test_the_default_extension_changes_nothing() -> None:
    plus, minus, packed_extension = FrictionExtension().pack(
        LAWS["stribeck"], packed(LAWS["stribeck"])
    )
    out = np.empty_like(plus)
    for direction in (1.0, -1.0):
        levels(plus, minus, packed_extension, 12.3, direction, 0.0, out)
        np.testing.assert_array_equal(out, packed(LAWS["stribeck"]))


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"fresh": 0.0}, "fresh in"),
        ({"rise_time": -1.0}, "rise_time >= 0"),
        ({"travel": (1.0, 1.0)}, "low < high"),
        ({"forward": ()}, "at least one, all finite"),
        ({"forward": (1.0, -4.0, 3.9)}, "falls to -0.02"),
        ({"fresh": 0.6, "rise_time": 1.0}, "allowed: >= coulomb"),
        ({"lag": -1.0}, "lag is -1"),
        ({"lag": 1.0, "delay": 1.0}, "not both"),
        ({"backward_values": {"viscos": 1.0}}, "did you mean viscous"),
        ({"backward_values": {"breakaway": 0.5}}, "allowed: >= coulomb"),
    ],
)
def test_extensions_out_of_range_are_refused(changes: dict, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        FrictionExtension(**changes).pack(LAWS["stribeck"], packed(LAWS["stribeck"]))


def test_a_law_without_breakaway_takes_no_rise() -> None:
    with pytest.raises(ValueError, match="dahl never rests"):
        FrictionExtension(rise_time=1.0).pack(LAWS["dahl"], packed(LAWS["dahl"], TABLE_3_1["dahl"]))
