"""Profile, derivatives of a reference and feedforward: their limits, ends, times and physics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.control.effort_feedforward import (
    FeedforwardGains,
    delayed,
    feedforward,
    sample_motion,
)
from frictool.control.jerk_limited_profile import ProfileLimits, duration, profile
from frictool.control.prefilter import prefilter
from frictool.control.reference_derivatives import reference_derivatives
from frictool.typing import Vector
from tests.support.single_block import Block
from tests.support.single_block import given as input_of

PERIOD = 1e-3
limits_drawn = st.builds(
    ProfileLimits, st.floats(0.05, 5.0), st.floats(0.5, 100.0), st.integers(2, 60)
)


def profile_block(limits: ProfileLimits) -> Block:
    return Block(lambda p: profile(p, input_of(p, "reference"), limits, PERIOD)[0])


def played(limits: ProfileLimits, targets: Vector, start: float = 0.0) -> tuple[Vector, Vector]:
    """Return position and speed of the profile for a target at each sample."""
    block = profile_block(limits)
    block.set(reference_before=start, filtered_before=start)
    rows = [(block.step(reference=target), block.value("filtered_speed")) for target in targets]
    position, speed = np.array(rows).T
    return position, speed


def samples_for(distance: float, limits: ProfileLimits) -> int:
    return math.ceil(duration(distance, limits, PERIOD) / PERIOD) + 20


@given(limits_drawn, st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=4), st.data())
@settings(max_examples=settings.default.max_examples // 3)
def test_no_limit_is_exceeded_and_the_target_is_reached_exactly(
    limits: ProfileLimits, targets: list[float], data: st.DataObject
) -> None:
    """Targets that change in motion, too: speed, acceleration and jerk by differences."""
    counts = [
        min(data.draw(st.integers(1, samples_for(4.0, limits))), 2000) for _ in targets[1:]
    ] + [samples_for(4.0 + 3.0 * limits.speed**2 / limits.acceleration, limits) + 1500]
    position, speed = played(limits, np.repeat(targets, counts))
    tolerance = 1e-9
    acceleration = np.diff(speed, prepend=0.0) / PERIOD
    jerk = np.diff(acceleration, prepend=0.0) / PERIOD
    assert np.max(np.abs(speed)) <= limits.speed * (1.0 + tolerance)
    assert np.max(np.abs(acceleration)) <= limits.acceleration * (1.0 + 1.0 / 128.0)
    assert np.max(np.abs(jerk)) <= limits.jerk(PERIOD) * (1.0 + 1.0 / 128.0)
    moved = np.diff(position, prepend=0.0)
    means = 0.5 * PERIOD * (speed + np.concatenate([[0.0], speed[:-1]]))
    end = limits.acceleration * PERIOD**2 / 200.0
    assert np.max(np.abs(moved - means)) <= end  # the speed is the derivative of the position
    assert position[-1] == targets[-1]
    assert speed[-1] == 0.0


@given(limits_drawn, st.floats(0.001, 2.0))
@settings(max_examples=settings.default.max_examples // 3)
def test_a_move_takes_the_time_of_the_trapezoid_and_the_mean(
    limits: ProfileLimits, distance: float
) -> None:
    """At most three samples more than the time-optimal trapezoid, and never past the target."""
    count = samples_for(distance, limits) + 10
    position, _ = played(limits, np.full(count, distance))
    assert np.max(position) <= distance * (1.0 + 1e-12)
    assert np.all(np.diff(position) >= -1e-15)
    off = np.flatnonzero(position != distance)
    taken = (off[-1] + 2) * PERIOD  # the first sample moves already
    least = duration(distance, limits, PERIOD)
    assert least - 2.0 * PERIOD <= taken <= least + 3.0 * PERIOD


@pytest.mark.parametrize("distance", [0.005, 0.05, 0.2, 1.0])
def test_the_time_is_near_the_time_optimum_of_ruckig(distance: float) -> None:
    """Longer than the optimum of the same limits by at most the time of the mean."""
    ruckig = pytest.importorskip("ruckig", reason="ruckig is a development dependency")
    limits = ProfileLimits(0.3, 2.0, 20)
    wanted = ruckig.InputParameter(1)
    wanted.current_position, wanted.target_position = [0.0], [distance]
    wanted.max_velocity, wanted.max_acceleration = [limits.speed], [limits.acceleration]
    wanted.max_jerk = [limits.jerk(PERIOD)]
    best = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(wanted, best)
    window = limits.smoothing_samples * PERIOD
    taken = duration(distance, limits, PERIOD)
    assert best.duration - PERIOD <= taken <= best.duration + window


def test_a_target_that_does_not_move_changes_no_bit() -> None:
    position, speed = played(ProfileLimits(1.0, 5.0, 7), np.full(50, 0.3), start=0.3)
    assert set(position) == {0.3}
    assert set(speed) == {0.0}


@given(
    st.floats(50.0, 1500.0),
    st.floats(0.0, 5e-3),
    st.tuples(st.floats(-1.0, 1.0), st.floats(-5.0, 5.0), st.floats(-50.0, 50.0)),
)
@settings(max_examples=30, deadline=None)
def test_derivatives_of_a_cubic_are_those_ahead(
    bandwidth: float, ahead: float, rates: tuple[float, float, float]
) -> None:
    """Constant jerk: once the filter has settled, speed and acceleration are exact, but for
    Tustin's T^2."""
    found: list[tuple[float, float]] = []
    block = Block(
        lambda p: reference_derivatives(p, input_of(p, "reference"), bandwidth, ahead, PERIOD)[0]
    )
    other = Block(
        lambda p: reference_derivatives(p, input_of(p, "reference"), bandwidth, ahead, PERIOD)[1]
    )
    v, a, j = rates
    time = np.arange(math.ceil(40.0 / (bandwidth * PERIOD))) * PERIOD
    for t in time:
        r = v * t + a * t**2 / 2.0 + j * t**3 / 6.0
        found.append((block.step(reference=r), other.step(reference=r)))
    at = time[-1] + ahead
    size = 1.0 + abs(v) + abs(a) + abs(j)
    assert found[-1][1] == pytest.approx(a + j * at, abs=1e-6 * bandwidth * size)
    assert found[-1][0] == pytest.approx(v + a * at + j * at**2 / 2.0, abs=1e-6 * bandwidth * size)


def test_the_coulomb_friction_has_a_hysteresis_around_zero_speed() -> None:
    gains = FeedforwardGains(0.0, 0.0, 1.0, 0.2, 0.1)
    block = Block(
        lambda p: feedforward(p, input_of(p, "speed"), input_of(p, "acceleration"), gains, 10.0)
    )
    speeds = [0.0, 0.15, 0.21, 0.15, 0.11, 0.09, 0.15, -0.15, -0.3, -0.11, 0.15, 0.21, -0.15, 0.0]
    signs = [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 1.0, 0.0, 0.0]
    found = [block.step(speed=speed, acceleration=0.0) for speed in speeds]
    assert found == signs


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_the_feedforward_never_asks_for_more_than_the_limit(
    speed: float, acceleration: float
) -> None:
    gains = FeedforwardGains(0.3, 0.2, 1.0, 0.2, 0.1)
    block = Block(
        lambda p: feedforward(p, input_of(p, "speed"), input_of(p, "acceleration"), gains, 2.0)
    )
    asked = 0.3 * acceleration + 0.2 * speed + math.copysign(1.0, speed) * (abs(speed) > 0.2)
    found = block.step(speed=speed, acceleration=acceleration)
    assert found == pytest.approx(min(max(asked, -2.0), 2.0))


def frictionless_error(block: Block, delay: int, targets: Vector) -> float:
    """Largest distance of a double integrator under the feedforward alone from the tracked
    reference; the drive acts `delay` samples late."""
    waiting = [0.0] * delay
    filtered = [0.0] * (1 + delay)
    position = speed = worst = 0.0
    for target in targets:
        drive = block.step(reference=target)
        filtered.append(block.value("filtered"))
        worst = max(worst, abs(filtered[-2 - delay] - position))
        waiting.append(drive)
        acting = waiting.pop(0)
        position += PERIOD * speed + 0.5 * PERIOD**2 * acting
        speed += PERIOD * acting
    return worst


@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize("source", ["profile", "prefilter"])
def test_the_feedforward_alone_moves_an_exact_inertia_without_error(
    delay: int, source: str
) -> None:
    gains = FeedforwardGains(1.0, 0.0, 0.0, 1e-3, 5e-4)
    limits = ProfileLimits(0.5, 3.0, 15)

    def build(p):  # type: ignore[no-untyped-def]  # as Block takes it
        reference = input_of(p, "reference")
        filtered = (
            profile(p, reference, limits, PERIOD)
            if source == "profile"
            else prefilter(p, reference, 25.0, 0.9, PERIOD)
        )
        drive = feedforward(p, *sample_motion(p, filtered[1], PERIOD), gains, 1e3)
        delayed(p, 1.0 + delay)
        return drive

    targets = np.repeat([0.2, -0.1], [1500, 1500])
    error = frictionless_error(Block(build), delay, targets)
    end = 0.005 * limits.acceleration * PERIOD if source == "profile" else 0.0
    assert error <= 1e-10 + end * PERIOD * targets.size  # END leaves a speed below a T/256


def test_a_delay_between_samples_lies_between_its_neighbours() -> None:
    def build(p):  # type: ignore[no-untyped-def]  # as Block takes it
        prefilter(p, input_of(p, "reference"), 40.0, 0.8, PERIOD)
        return delayed(p, 2.25)

    block = Block(build)
    filtered, tracked = [0.0] * 4, []
    for _ in range(200):
        tracked.append(block.step(reference=1.0))
        filtered.append(block.value("filtered"))
    ages = [np.array(filtered[4 - k : 204 - k]) for k in (2, 3)]
    assert np.array(tracked) == pytest.approx(0.75 * ages[0] + 0.25 * ages[1])
