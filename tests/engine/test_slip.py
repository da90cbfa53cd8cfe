"""A phase of slip: the closed form against its differential equation, its first stop and its travel
against dense sampling."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from frictool.engine.slip_closed_form import (
    NEVER,
    Phase,
    acceleration,
    distance,
    fall_time,
    rise_time,
    speed,
    travel_time,
)

DURATION = 0.05
PHASES = st.tuples(
    st.one_of(st.just(0.0), st.floats(1e-3, 100.0)),  # w0
    st.floats(-2e4, 2e4),  # settled
    st.one_of(st.just(0.0), st.floats(-2e4, 2e4)),  # transient
    st.one_of(st.just(0.0), st.floats(0.1, 500.0)),  # decay
    st.floats(20.0, 2000.0),  # rate
)


@given(phase=PHASES, twin=st.booleans())
def test_closed_form_solves_the_equation(phase: Phase, twin: bool) -> None:
    w0, settled, transient, decay, rate = phase
    if twin:
        phase = (w0, settled, transient, rate, rate)
        decay = rate
    times = np.linspace(0.0, DURATION, 7)

    def field(t: float, y: list[float]) -> list[float]:
        return [-decay * y[0] + settled + transient * math.exp(-rate * t), y[0]]

    scale = w0 + (abs(settled) + abs(transient)) * DURATION
    exact = 1e-12 * max(scale, 1e-300) * DURATION
    run = solve_ivp(
        field, (0.0, DURATION), [w0, 0.0], "DOP853", t_eval=times, rtol=1e-12, atol=exact
    )
    for index, t in enumerate(times):
        assert speed(phase, t) == pytest.approx(run.y[0, index], rel=1e-9, abs=1e-9 * scale)
        assert distance(phase, t) == pytest.approx(
            run.y[1, index], rel=1e-9, abs=1e-9 * scale * DURATION
        )
        assert acceleration(phase, t) == pytest.approx(
            field(t, [speed(phase, t), 0.0])[0], rel=1e-9, abs=1e-9 * scale / DURATION
        )


@settings(max_examples=2 * settings.default.max_examples)
@given(phase=PHASES)
def test_stop_is_the_first_zero(phase: Phase) -> None:
    w0, settled, transient, decay, _ = phase
    start = settled + transient - decay * w0
    assume(w0 > 0.0 or start > 1.0)
    stop = fall_time(phase, 0.0, DURATION)
    scale = w0 + (abs(settled) + abs(transient)) * DURATION
    before = np.linspace(0.0, DURATION if stop == NEVER else stop, 400)[1:-1]
    assert min(speed(phase, t) for t in before) > -1e-12 * scale
    if stop != NEVER:
        assert 0.0 < stop <= DURATION
        assert abs(speed(phase, stop)) <= 1e-12 * scale
    else:
        assert speed(phase, DURATION) > 0.0


@settings(max_examples=2 * settings.default.max_examples)
@given(phase=PHASES, part=st.floats(1e-6, 1.0))
def test_travel_time_inverts_the_distance(phase: Phase, part: float) -> None:
    stop = fall_time(phase, 0.0, DURATION)
    end = DURATION if stop == NEVER else stop
    assume(end > 0.0)
    length = part * distance(phase, end)
    assume(length > 0.0)
    assert distance(phase, travel_time(phase, length, end)) == pytest.approx(length, rel=1e-12)
    assert travel_time(phase, 1.001 * distance(phase, end), end) == NEVER


def test_a_start_at_rest_that_accelerates_only_later_is_no_stop() -> None:
    rising: Phase = (
        0.0,
        100.0,
        -100.0,
        0.0,
        300.0,
    )  # acceleration 0 at first, then 100 (1 - e^{-300 t})
    assert fall_time(rising, 0.0, DURATION) == NEVER
    assert speed(rising, 0.01) == pytest.approx(1.0 + (math.exp(-3.0) - 1.0) / 3.0, rel=1e-12)


def test_a_start_at_rest_against_the_acceleration_stops_at_once() -> None:
    assert fall_time((0.0, -100.0, 0.0, 0.0, 0.0), 0.0, DURATION) == 0.0


@settings(max_examples=2 * settings.default.max_examples)
@given(phase=PHASES, above=st.floats(1e-3, 50.0))
def test_a_level_of_speed_is_reached_first_at_its_time(phase: Phase, above: float) -> None:
    """Upwards from below, and downwards through the mirrored phase; dense samples before it stay on
    their side."""
    w0, settled, transient, _, _ = phase
    scale = w0 + above + (abs(settled) + abs(transient)) * DURATION
    for sign, find in ((1.0, rise_time), (-1.0, fall_time)):
        level = w0 + sign * above
        reached = find(phase, level, DURATION)
        ahead = [
            sign * (level - speed(phase, t))
            for t in np.linspace(0.0, DURATION if reached == NEVER else reached, 400)
        ]
        assert min(ahead[:-1]) > -1e-12 * scale
        assert abs(ahead[-1]) <= 1e-12 * scale if reached != NEVER else ahead[-1] > -1e-12 * scale
