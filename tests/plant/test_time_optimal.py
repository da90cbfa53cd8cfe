"""The shortest response against linear programming, random commands and closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.signal import cont2discrete

from frictool.plant.time_optimal import (
    DrivenAxis,
    StepZone,
    shortest_time,
    step_zone,
    time_optimal_response,
)
from frictool.typing import Vector

# worst and best vertex of the clutch (table 5.2), 50 rad
WORST = DrivenAxis(1.53e-5, 7.62e-4, 0.18, 50.0 * 12.8e-3, 0.003)
BEST = DrivenAxis(1.11e-5, 0.0, 0.018, 50.0 * 14.0e-3, 0.003)
axes = st.builds(
    DrivenAxis,
    st.floats(0.2, 5.0),
    st.floats(0.0, 3.0),
    st.floats(0.0, 0.9),
    st.just(1.0),
    st.sampled_from([0.0, 1e-6, 0.1, 1.0]) | st.floats(0.0, 1.0),
)


def played(axis: DrivenAxis, commands: Vector, period: float) -> tuple[Vector, Vector]:
    """Return positions and velocities (n,) of an axis from rest, by small explicit steps."""
    kept = math.exp(-period / axis.lag) if axis.lag > 0.0 else 0.0
    position = velocity = effort = 0.0
    states = []
    for command in commands:
        effort = command + (effort - command) * kept
        level = axis.backlash_coulomb if position < axis.backlash else axis.coulomb
        free = velocity + period * (effort - axis.viscous * velocity) / axis.inertia
        change = period * level / axis.inertia
        velocity = math.copysign(max(abs(free) - change, 0.0), free)
        position += period * velocity
        states.append((position, velocity))
    return np.array([x for x, _ in states]), np.array([v for _, v in states])


@pytest.mark.parametrize(("axis", "expected"), [(WORST, 0.104), (BEST, 0.050)])
def test_the_clutch_needs_104_ms_at_its_worst_vertex_and_50_ms_at_its_best(
    axis: DrivenAxis, expected: float
) -> None:
    zone = step_zone(50.0, 2.0 * math.pi / 56.0, 0.05)
    assert zone == pytest.approx((47.5, 52.5))
    assert time_optimal_response(axis, zone, 1e-3, 1) == pytest.approx(expected, abs=1e-12)


@given(st.floats(0.1, 10.0), st.floats(0.0, 0.9), st.floats(0.0, 0.05))
def test_a_drive_without_lag_follows_the_closed_form(
    inertia: float, coulomb: float, overshoot: float
) -> None:
    """Accelerate with a+, brake with a- from x1 = (1 + o) a-/(a+ + a-) on."""
    up, down = (1.0 - coulomb) / inertia, (1.0 + coulomb) / inertia
    turn = (1.0 + overshoot) * down / (up + down)
    if turn >= 0.95:
        expected = math.sqrt(1.9 / up)
    else:
        speed = math.sqrt(2.0 * up * turn)
        expected = speed / up + (speed - math.sqrt(2.0 * (overshoot + 0.05) * down)) / down
    axis = DrivenAxis(inertia, 0.0, coulomb, 1.0)
    assert shortest_time(axis, step_zone(1.0, 0.0, overshoot)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    "axis",
    [
        DrivenAxis(1.0, 0.0, 0.0, 1.0, 0.3),
        DrivenAxis(1.0, 0.8, 0.0, 1.0, 0.1),
        DrivenAxis(0.5, 2.0, 0.0, 1.0, 0.25),  # both time constants are equal
        DrivenAxis(1.0, 0.2, 0.0, 1.0, 0.0),
    ],
)
@pytest.mark.parametrize("overshoot", [0.0, 0.05])
def test_linear_programming_over_all_sampled_commands_finds_the_same_time(
    axis: DrivenAxis, overshoot: float
) -> None:
    """Bisect on the number of samples: the largest position after n samples, of all commands that
    let the axis stop by `farthest`."""
    zone = step_zone(1.0, 0.0, overshoot)
    bound = shortest_time(axis, zone)
    period = bound / 60.0
    low, high = 40, 80
    while high - low > 1:
        middle = (low + high) // 2
        if _furthest(axis, zone.farthest, period, middle) >= zone.arrival:
            high = middle
        else:
            low = middle
    assert bound * (1.0 - 1e-9) <= high * period <= bound + 2.0 * period


def _furthest(axis: DrivenAxis, farthest: float, period: float, samples: int) -> float:
    """Return the largest position after `samples` that a rest at `farthest` still allows."""
    lagged = axis.lag > 0.0
    s = axis.viscous / axis.inertia
    a = np.array([[0.0, 1.0, 0.0], [0.0, -s, 1.0 / axis.inertia], [0.0, 0.0, 0.0]])
    b = np.array([[0.0], [0.0], [0.0]])
    if lagged:
        a[2, 2], b[2, 0] = -1.0 / axis.lag, 1.0 / axis.lag
    else:
        a[1, 2], b[1, 0] = 0.0, 1.0 / axis.inertia
    ad, bd, *_ = cont2discrete((a, b, np.eye(3), np.zeros((3, 1))), period)
    total = 2 * samples
    answers = [bd[:, 0]]
    for _ in range(total - 1):
        answers.append(ad @ answers[-1])
    pulse = np.array(answers)  # state k samples after a command of one sample

    def row(sample: int, state: int) -> Vector:
        weights = np.zeros(total)
        weights[:sample] = pulse[:sample, state][::-1]
        return weights

    result = linprog(
        -row(samples, 0),
        A_ub=np.array([row(k, 0) for k in range(1, total + 1)]),
        b_ub=np.full(total, farthest),
        A_eq=np.array([row(total, 1), row(total, 2)])[: 2 if lagged else 1],
        b_eq=np.zeros(2 if lagged else 1),
        bounds=[(-1.0, 1.0)] * total,
    )
    assert result.status == 0
    return float(-result.fun)


@settings(max_examples=25)
@given(axes, st.floats(0.0, 0.05), st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_no_random_command_is_faster(
    axis: DrivenAxis, overshoot: float, part: float, seed: int
) -> None:
    """Commands at one of the limits with up to four switches, then full braking; some steps begin
    inside the backlash."""
    loose = replace(axis, backlash=part, backlash_coulomb=0.3 * axis.coulomb)
    zone = step_zone(1.0, 0.0, overshoot)
    for one in (axis, loose):
        bound = shortest_time(one, zone)
        assert math.isfinite(bound)
        period = bound / 400.0
        rng = np.random.default_rng(seed)
        for _ in range(4):
            switches = np.sort(rng.uniform(0.0, bound, rng.integers(1, 5)))
            times = period * np.arange(2000)
            signs = 1.0 - 2.0 * (np.searchsorted(switches, times) % 2)
            commands = np.where(times < bound, signs, -1.0)
            position, velocity = played(one, commands, period)
            turned = np.flatnonzero((velocity <= 0.0) & (times >= bound))
            peak = position[: turned[0] + 1].max() if turned.size else math.inf
            if peak <= zone.farthest:
                inside = np.flatnonzero(position >= zone.arrival)
                assert not inside.size or times[inside[0]] >= bound * (1.0 - 0.02)


@settings(max_examples=8)
@given(axes)
def test_the_switched_command_comes_to_rest_at_the_end_of_the_zone(axis: DrivenAxis) -> None:
    """The bound is attained: of the commands with one switch, the last that stops in time."""
    zone = StepZone(0.95, 1.05)
    bound = shortest_time(axis, zone)
    period = bound / 2000.0
    low, high = 0.0, bound
    for _ in range(12):
        switch = 0.5 * (low + high)
        commands = np.where(period * np.arange(6000) < switch, 1.0, -1.0)
        position, velocity = played(axis, commands, period)
        turned = np.flatnonzero((velocity <= 0.0) & (period * np.arange(6000) >= switch))
        low, high = (switch, high) if position[turned[0]] <= zone.farthest else (low, switch)
    arrived = np.flatnonzero(
        played(axis, np.where(period * np.arange(6000) < low, 1.0, -1.0), period)[0] >= zone.arrival
    )
    assert period * arrived[0] == pytest.approx(bound, rel=5e-3)


@given(axes, st.floats(0.0, 0.05))
def test_a_weaker_drive_or_a_larger_inertia_lag_or_backlash_friction_is_slower(
    axis: DrivenAxis, overshoot: float
) -> None:
    zone = step_zone(1.0, 0.0, overshoot)
    bound = shortest_time(axis, zone)
    margin = 1.0 + 1e-9
    assert shortest_time(replace(axis, inertia=1.2 * axis.inertia), zone) * margin >= bound
    assert shortest_time(replace(axis, effort=1.3), zone) <= bound * margin
    assert shortest_time(replace(axis, lag=axis.lag + 0.1), zone) * margin >= bound
    loose = replace(axis, backlash=0.3, backlash_coulomb=0.5 * axis.coulomb)
    assert shortest_time(loose, zone) <= bound * margin
    assert shortest_time(axis, zone._replace(farthest=math.inf)) <= bound * margin


def test_a_drive_below_the_friction_never_arrives() -> None:
    zone = step_zone(1.0, 0.0)
    assert shortest_time(DrivenAxis(1.0, 0.0, 1.0, 1.0, 0.1), zone) == math.inf
    assert time_optimal_response(DrivenAxis(1.0, 0.0, 2.0, 1.0), zone, 1e-3, 1) == math.inf


def test_the_zone_is_not_narrower_than_the_sensor() -> None:
    assert step_zone(1.0, 0.1) == pytest.approx((0.9, 1.1))
    assert step_zone(1.0, 0.01, 0.0) == pytest.approx((0.95, 1.01))
    assert step_zone(1.0, 0.0, 0.2) == pytest.approx((0.95, 1.05))
    assert shortest_time(WORST, step_zone(1.0, 1.0)) == 0.0
