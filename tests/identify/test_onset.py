"""Motion after a breakaway: the closed form against its differential equation, and the onset found
again from a coarse encoder."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from frictool.identify.breakaway.onset import (
    NO_MOTION,
    NOT_POSITIVE,
    OK,
    misfit,
    onset_times,
    phi3,
    search_span,
    travel,
)
from frictool.identify.breakaway.onset_detection import _line, _onset
from frictool.identify.motion_record import make_record
from frictool.typing import Vector

INERTIA, VISCOUS, COULOMB = 1.32e-5, 3.81e-4, 0.099
STEP = 0.1122
TIMING = 0.03
AT_ONCE = (1.0, np.zeros(2), np.empty((0, 1, 6)))  # no table of the travel: friction falls at once


def onset_time(
    time: Vector,
    seen: Vector,
    ramp: Vector,
    axis: Vector,
    resolution: float,
    expected: float,
    timing: float,
    span: float,
    velocity: float,
    exponent: float,
    immediate: float,
) -> list[float]:
    """Return t0, start, misfit and status of one onset, the last of two in one call."""
    other = np.linspace(0.0, 0.01, time.size + 1)
    rows = np.zeros((2, 2, time.size + 1))
    rows[0, 0], rows[1, 0], rows[0, 1, :-1], rows[1, 1, :-1] = other, 9.0 * other, time, seen
    found = onset_times(
        rows[0],
        rows[1],
        np.array([time.size + 1, time.size]),
        np.array([[0.2, 0.4], ramp]),
        np.array([2.0 * axis, axis]),
        resolution,
        expected,
        np.array([1.0, timing]),
        np.array([0.02, span]),
        velocity,
        exponent,
        np.array([math.nan, immediate]),
    )
    last: list[float] = found[1].tolist()
    return last


@settings(derandomize=True, deadline=None, max_examples=40)
@given(
    t=st.floats(1e-3, 0.1),
    excess=st.floats(0.0, 0.05),
    rate=st.floats(0.01, 1.0),
    viscous=st.floats(0.0, 1e-2),
)
def test_travel_solves_the_equation(t: float, excess: float, rate: float, viscous: float) -> None:
    run = solve_ivp(
        lambda s, y: [y[1], (excess + rate * s - viscous * y[1]) / INERTIA],
        (0.0, t),
        [0.0, 0.0],
        "DOP853",
        rtol=1e-11,
        atol=1e-13,
    )
    assert travel(t, excess, rate, INERTIA, viscous) == pytest.approx(run.y[0, -1], rel=1e-7)


def test_nothing_moves_before_the_onset() -> None:
    assert travel(-1e-3, 0.01, 0.3, INERTIA, VISCOUS) == 0.0
    assert travel(1e-2, -0.5, 0.3, INERTIA, VISCOUS) == travel(1e-2, 0.0, 0.3, INERTIA, VISCOUS)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(x=st.floats(-30.0, 1.0))
def test_phi3_by_quadrature(x: float) -> None:
    s, w = np.polynomial.legendre.leggauss(40)
    s, w = 0.5 * (s + 1.0), 0.5 * w
    assert phi3(x) == pytest.approx(float(np.sum(w * np.exp(x * (1.0 - s)) * s**2 / 2.0)), rel=1e-9)


def changes(
    t0: float, start: float, rate: float, breakaway: float, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Times and distances of the first `count` changes of an encoder, the time exact."""
    fine = np.linspace(0.0, 0.2, 400_001)
    path = np.array([travel(t, breakaway - COULOMB, rate, INERTIA, VISCOUS) for t in fine[::40]])
    times = np.interp(start + STEP * np.arange(count), path, fine[::40]) + t0
    return times, STEP * np.arange(count)


@settings(derandomize=True, deadline=None, max_examples=12)
@given(delay=st.floats(0.0, 5e-3), start=st.floats(0.05, 0.95), rate=st.floats(0.1, 0.6))
def test_onset_is_found_again(delay: float, start: float, rate: float) -> None:
    breakaway = 0.109
    times, seen = changes(delay, start * STEP, rate, breakaway, 4)
    ramp, axis = np.array([breakaway - rate * delay, rate]), np.array([INERTIA, VISCOUS, COULOMB])
    span = search_span(STEP, rate, INERTIA, 4.0)
    leant = onset_time(times, seen, ramp, axis, STEP, 0.5 * STEP, TIMING, span, 0.0, 2.0, math.nan)[
        1
    ]
    assert abs(leant - 0.5 * STEP) <= (abs(start - 0.5) + 1e-6) * STEP  # towards what is expected
    found, place, _, status = onset_time(
        times, seen, ramp, axis, STEP, start * STEP, TIMING, span, 0.0, 2.0, math.nan
    )
    assert status == OK
    assert found == pytest.approx(delay, abs=2e-6)
    assert place == pytest.approx(start * STEP, abs=2e-4 * STEP)


def test_one_change_is_read_as_if_the_axis_rested_where_it_is_expected() -> None:
    times, seen = changes(0.0, 0.3 * STEP, 0.3, 0.109, 1)
    ramp, axis = np.array([0.109, 0.3]), np.array([INERTIA, VISCOUS, COULOMB])
    span = search_span(STEP, 0.3, INERTIA, 4.0)
    assert onset_time(times, seen, ramp, axis, STEP, 0.3 * STEP, TIMING, span, 0.0, 2.0, math.nan)[
        0
    ] == pytest.approx(0.0, abs=1e-6)
    late, early = (
        onset_time(times, seen, ramp, axis, STEP, share * STEP, TIMING, span, 0.0, 2.0, math.nan)[0]
        for share in (0.1, 0.9)
    )
    assert early < 0.0 < late


def test_search_agrees_with_a_slow_one() -> None:
    times, seen = changes(0.0, 0.3 * STEP, 0.3, 0.109, 4)
    times = np.round(times, 3)
    ramp, axis = np.array([0.109, 0.3]), np.array([INERTIA, VISCOUS, COULOMB])
    span = search_span(STEP, 0.3, INERTIA, 4.0)
    grid = np.linspace(times[0] - span, times[0], 4000)
    around = grid[
        np.argmin(
            [
                misfit(t, times, seen, ramp, axis, STEP, 0.5 * STEP, TIMING, *AT_ONCE)[0]
                for t in grid
            ]
        )
    ]
    slow = minimize_scalar(
        lambda t: misfit(t, times, seen, ramp, axis, STEP, 0.5 * STEP, TIMING, *AT_ONCE)[0],
        bounds=(around - 2e-5, around + 2e-5),
        method="bounded",
        options={"xatol": 1e-10},
    )
    assert onset_time(times, seen, ramp, axis, STEP, 0.5 * STEP, TIMING, span, 0.0, 2.0, math.nan)[
        0
    ] == pytest.approx(slow.x, abs=1e-7)


@pytest.mark.parametrize("velocity", [0.0, 1.0, math.inf])
def test_an_onset_that_is_known_for_an_immediate_fall_changes_no_bit(velocity: float) -> None:
    times, seen = changes(0.0, 0.3 * STEP, 0.3, 0.109, 4)
    ramp, axis = np.array([0.109, 0.3]), np.array([INERTIA, VISCOUS, COULOMB])
    known = (
        times,
        seen,
        ramp,
        axis,
        STEP,
        0.5 * STEP,
        TIMING,
        search_span(STEP, 0.3, INERTIA, 4.0),
    )
    immediate = onset_time(*known, 0.0, 2.0, math.nan)[0]
    assert onset_time(*known, velocity, 2.0, immediate) == onset_time(
        *known, velocity, 2.0, math.nan
    )


def test_misfit_eliminates_the_start_within_one_count() -> None:
    times, seen = changes(0.0, 0.5 * STEP, 0.3, 0.109, 4)
    ramp, axis = np.array([0.109, 0.3]), np.array([INERTIA, VISCOUS, COULOMB])
    path = np.array(
        [travel(t + 2e-3, 0.109 - COULOMB - 0.3 * 2e-3, 0.3, INERTIA, VISCOUS) for t in times]
    )
    starts = np.linspace(0.0, STEP, 20_001)
    squares = [
        float(np.sum((path - seen - start) ** 2)) + TIMING * (start - 0.5 * STEP) ** 2
        for start in starts
    ]
    least, start = misfit(-2e-3, times, seen, ramp, axis, STEP, 0.5 * STEP, TIMING, *AT_ONCE)
    assert least == pytest.approx(min(squares), rel=1e-6)
    assert start == pytest.approx(starts[int(np.argmin(squares))], abs=1e-5)


def test_statuses() -> None:
    axis = np.array([INERTIA, VISCOUS, COULOMB])
    assert (
        onset_time(
            np.empty(0),
            np.empty(0),
            np.array([0.1, 0.3]),
            axis,
            STEP,
            0.5 * STEP,
            TIMING,
            0.1,
            0.0,
            2.0,
            math.nan,
        )[3]
        == NO_MOTION
    )
    assert (
        onset_time(
            np.zeros(1),
            np.zeros(1),
            np.array([0.1, 0.0]),
            axis,
            STEP,
            0.5 * STEP,
            TIMING,
            0.1,
            0.0,
            2.0,
            math.nan,
        )[3]
        == NOT_POSITIVE
    )


@pytest.mark.parametrize(("reaction", "used"), [(0, 1), (3, 1), (7, 2), (12, 3), (60, 4)])
def test_only_counts_before_the_drive_leaves_the_ramp_are_used(reaction: int, used: int) -> None:
    """A count every 5 samples after a rest of 200; a servo halves its effort `reaction` samples
    after the first. The first count belongs to the ramp in any case."""
    n, rest = 260, 200
    after = np.arange(n) - rest
    position = np.asarray(STEP * np.where(after < 0, 0, 1 + after // 5), dtype=np.float64)
    share = np.where(after < reaction, 1.0, 0.5)
    effort = np.asarray(1e-3 * np.arange(n) * share, dtype=np.float64)
    record = make_record("ramp", 1e-3 * np.arange(n), position, effort, STEP, 0.0)
    onset = _onset(record, 0, rest, n, 1.0)
    assert onset is not None
    assert onset.seen.size == used
    assert onset.rate == pytest.approx(1.0)


def test_the_tail_of_a_lag_is_no_ramp() -> None:
    """A current with a short lag decays until the squares of its changes underflow."""
    effort = 0.03 * math.exp(-25.0) ** np.arange(55.0)
    record = make_record("log", 0.01 * np.arange(55.0), np.zeros(55), effort, STEP, 0.0)
    assert _line(record, 0, 54) is None
