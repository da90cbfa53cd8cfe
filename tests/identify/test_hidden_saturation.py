"""An effort that saturates softly or under its noise is refused; what the motion explains is kept.

Constant speeds, gravity, and friction that varies over direction and position must be kept.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.identify.hidden_saturation import (
    HIGHEST,
    SHARPNESS,
    START,
    _linear,
    _samples,
    _saturating,
    hidden_saturation,
)
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.typing import Vector
from studies.command_line import run
from studies.violations.families import draw_violation
from studies.violations.recording import record as violating_record
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log
from tests.support.command_line import refused

TIME: Vector = np.arange(12_000, dtype=np.float64) * PERIOD
NOISE = 0.03  # standard deviation of the noise behind the clipping, relative to the peak effort
RIGS = range(6)


def rig(seed: int, gravity: float = 0.0) -> tuple[Arm, Vector, Vector]:
    """Return an arm of any size under a servo on two sines, its position (n,) and its effort
    (n,)."""
    draw = np.random.default_rng([seed, 31])
    coulomb, rate = draw.uniform(0.05, 0.5), draw.uniform(15.0, 30.0)
    arm = Arm(
        10.0 ** draw.uniform(-1.0, 0.0),
        draw.uniform(0.01, 0.3),
        coulomb,
        1.1 * coulomb,
        gravity,
        counts=int(10.0 ** draw.uniform(4.0, 5.3)),
    )
    command = draw.uniform(0.2, 0.6) * np.sin(draw.uniform(3.0, 8.0) * TIME)
    command += draw.uniform(0.1, 0.3) * np.sin(draw.uniform(8.0, 12.0) * TIME)
    stiffness = arm.inertia * rate**2
    gains = stiffness, 0.2 * stiffness * rate, 1.6 * arm.inertia * rate
    return arm, *play(arm, command, gains)


def noisy(effort: Vector, seed: int, low: float = -np.inf, high: float = np.inf) -> Vector:
    """Return the effort (n,), clipped to [low, high] in N m, with noise afterwards."""
    peak = float(np.quantile(np.abs(effort), 0.999))
    noise = np.random.default_rng(seed).standard_normal(effort.size)
    return np.asarray(np.clip(effort, low, high) + NOISE * peak * noise)


def soft(effort: Vector, seed: int, share: float) -> Vector:
    """Return the effort (n,) behind tanh with a limit at this share of its peak, with noise."""
    peak = float(np.quantile(np.abs(effort), 0.999))
    noise = np.random.default_rng(seed).standard_normal(effort.size)
    return np.asarray(share * peak * np.tanh(effort / (share * peak)) + NOISE * peak * noise)


def sine_rig(seed: int) -> tuple[Arm, Vector, Vector]:
    """Return an arm under a servo on one sine, in which friction takes half of the peak effort."""
    draw = np.random.default_rng([seed, 32])
    rate, size, inertia = draw.uniform(3.0, 6.0), draw.uniform(0.4, 0.8), draw.uniform(0.1, 1.0)
    inertial = inertia * size * rate**2
    coulomb = draw.uniform(0.6, 0.9) * inertial
    arm = Arm(inertia, 0.2 * inertial / (size * rate), coulomb, 1.1 * coulomb, counts=65_536)
    loop = 12.0 * rate
    gains = inertia * loop**2, 0.2 * inertia * loop**3, 1.6 * inertia * loop
    command = np.minimum(TIME, 1.0) ** 2 * size * np.sin(rate * TIME)
    return arm, *play(arm, command, gains)


def record(arm: Arm, position: Vector, effort: Vector) -> MotionRecord:
    return make_record("log", TIME, position, effort, arm.step, 0.0)


def bench_of(folder: Path, arm: Arm) -> Bench:
    return load(write_bench(folder, arm), Bench)


@pytest.mark.parametrize("method", ["auto", "least-squares", "output-error"])
def test_an_effort_that_saturates_under_its_noise_is_refused(tmp_path: Path, method: str) -> None:
    arm, position, effort = rig(0)
    level = float(np.quantile(np.abs(effort), 0.8))
    log = write_log(tmp_path / "flat.csv", position, noisy(effort, 0, -level, level))
    model = tmp_path / "model.yaml"
    bench = write_bench(tmp_path, arm)
    result = run("identify", log, "--bench", bench, "--method", method, "-o", model)
    refused(result, 1, "the effort stays near", "where the motion needs up to", "widen its range")
    assert not model.exists()


@pytest.mark.parametrize("share", [0.2, 0.3, 0.6])
@pytest.mark.parametrize(("lower", "upper"), [(True, True), (True, False), (False, True)])
@pytest.mark.parametrize("seed", RIGS)
def test_the_level_is_found_on_both_sides_and_on_one(
    tmp_path: Path, seed: int, lower: bool, upper: bool, share: float
) -> None:
    arm, position, effort = rig(seed)
    level = float(np.quantile(np.abs(effort), 1.0 - share))
    clipped = noisy(effort, seed, -level if lower else -np.inf, level if upper else np.inf)
    found = hidden_saturation(record(arm, position, clipped), bench_of(tmp_path, arm))
    assert found is not None
    assert found.level == pytest.approx(level, rel=0.1)
    assert found.needed > 1.05 * level


@pytest.mark.parametrize("method", ["auto", "least-squares"])
def test_a_soft_saturation_is_refused(tmp_path: Path, method: str) -> None:
    """An amplifier that saturates like tanh attenuates the inertia by a quarter and more."""
    arm, position, effort = rig(0)
    log = write_log(tmp_path / "soft.csv", position, soft(effort, 0, 0.6))
    model = tmp_path / "model.yaml"
    bench = write_bench(tmp_path, arm)
    result = run("identify", log, "--bench", bench, "--method", method, "-o", model)
    refused(result, 1, "the effort stays near", "where the motion needs up to", "widen its range")
    assert not model.exists()


@pytest.mark.parametrize("share", [0.5, 0.8])
@pytest.mark.parametrize("seed", RIGS)
def test_a_soft_saturation_is_found(tmp_path: Path, seed: int, share: float) -> None:
    arm, position, effort = rig(seed)
    found = hidden_saturation(
        record(arm, position, soft(effort, seed, share)), bench_of(tmp_path, arm)
    )
    assert found is not None
    assert 1.05 * found.level < found.needed
    top = np.abs(effort) > np.quantile(np.abs(effort), 0.99)
    assert found.needed == pytest.approx(np.abs(effort[top]).mean(), rel=0.3)


@pytest.mark.parametrize("share", [0.4, 0.5, 0.6])
@pytest.mark.parametrize("seed", RIGS)
def test_a_sine_that_saturates_most_of_the_time_is_refused(
    tmp_path: Path, seed: int, share: float
) -> None:
    """A clip far below friction and inertia leaves hardly a sample between its limits."""
    arm, position, effort = sine_rig(seed)
    level = share * float(np.quantile(np.abs(effort), 0.999))
    log = write_log(tmp_path / "sine.csv", position, noisy(effort, seed, -level, level))
    bench = write_bench(tmp_path, arm)
    result = run("identify", log, "--bench", bench, "--method", "least-squares")
    refused(result, 1, "the measurement is saturated")


@pytest.mark.parametrize("seed", RIGS)
def test_a_sine_that_the_motion_explains_is_kept(tmp_path: Path, seed: int) -> None:
    arm, position, effort = sine_rig(seed)
    assert (
        hidden_saturation(record(arm, position, noisy(effort, seed)), bench_of(tmp_path, arm))
        is None
    )


@pytest.mark.parametrize("excess", ["direction", "position"])
@pytest.mark.parametrize("seed", RIGS)
def test_friction_that_varies_is_kept(tmp_path: Path, seed: int, excess: str) -> None:
    """Friction that is larger in one direction, or at one end, bends the effort like a limit."""
    arm, position, effort = rig(seed)
    speed = np.gradient(position, PERIOD)
    more = (
        np.maximum(speed, 0.0) * arm.viscous
        if excess == "direction"
        else 0.5 * arm.coulomb * np.sign(speed) * position / np.ptp(position)
    )
    assert (
        hidden_saturation(
            record(arm, position, noisy(effort - more, seed)), bench_of(tmp_path, arm)
        )
        is None
    )


@pytest.mark.parametrize("gravity", [0.0, 2.0])
@pytest.mark.parametrize("seed", RIGS)
def test_an_effort_that_the_motion_explains_is_kept(
    tmp_path: Path, seed: int, gravity: float
) -> None:
    """Gravity bends the effort over the position, also where the bench does not name it."""
    arm, position, effort = rig(seed, gravity)
    assert (
        hidden_saturation(record(arm, position, noisy(effort, seed)), bench_of(tmp_path, arm))
        is None
    )


@pytest.mark.parametrize("seed", RIGS)
def test_strokes_of_constant_speed_are_kept(tmp_path: Path, seed: int) -> None:
    """Their effort is flat, as the motion needs it."""
    arm, _, _ = rig(seed)
    command = 0.5 * (2.0 / np.pi) * np.arcsin(np.sin((2.0 + 0.3 * seed) * TIME))
    stiffness = 400.0 * arm.inertia
    position, effort = play(arm, command, (stiffness, 4.0 * stiffness, 32.0 * arm.inertia))
    assert (
        hidden_saturation(record(arm, position, noisy(effort, seed)), bench_of(tmp_path, arm))
        is None
    )


@pytest.mark.parametrize(
    ("seed", "family", "number"),
    [("jw1", "coarse_encoder", 6), ("jw1", "belt", 5), ("jw2", "mild_mix", 0)],
)
def test_an_effort_that_another_effect_bends_is_kept(
    tmp_path: Path, seed: str, family: str, number: int
) -> None:
    """A compliance or a friction law bends the largest efforts of a few strokes."""
    log = violating_record(draw_violation(seed, family, number), seed)
    path = tmp_path / "bench.yaml"
    path.write_text(log.bench)
    bench = load(path, Bench)
    step, constant = bench.encoder.resolution, bench.actuator.constant.value
    motion = make_record("log", log.time, log.counts * step, log.current * constant, step, 0.0)
    assert hidden_saturation(motion, bench) is None


@pytest.mark.parametrize("seed", [0, 3])
def test_the_fit_of_a_clip_starts_near_its_limits(tmp_path: Path, seed: int) -> None:
    """The efforts below the clip determine the limits to a few percent in a few evaluations."""
    arm, position, effort = rig(seed)
    level = float(np.quantile(np.abs(effort), 0.6))
    clipped = record(arm, position, noisy(effort, seed, -level, level))
    samples = _samples(clipped, bench_of(tmp_path, arm))
    assert samples is not None
    scale = float(np.quantile(np.abs(samples.effort), HIGHEST))
    linear = _linear(samples.model, samples.effort / scale)
    start = np.append(linear, 2 * [np.log(START)])
    found = _saturating(samples.model, samples.effort / scale, SHARPNESS[-1], start)
    assert np.exp(found.unknowns[-2:]) * scale == pytest.approx(level, rel=0.02)
    assert found.evaluations <= 10


@pytest.mark.parametrize("seed", RIGS)
def test_a_current_of_two_levels_is_kept(tmp_path: Path, seed: int) -> None:
    """The acceleration responds to each step of the current, so that no effort is missing."""
    draw = np.random.default_rng([seed, 33])
    arm = Arm(draw.uniform(0.02, 0.1), 0.05, 0.4, 0.45, counts=int(10.0 ** draw.uniform(4.0, 5.0)))
    hold = int(draw.uniform(100.0, 200.0))
    pairs = draw.choice((-1.0, 1.0), (TIME.size // (2 * hold) + 1, 1)) * (1.0, -1.0)
    position, effort = play(arm, 0.8 * np.repeat(pairs.ravel(), hold)[: TIME.size])
    logged = record(arm, position, noisy(effort, seed))
    assert hidden_saturation(logged, bench_of(tmp_path, arm)) is None


def test_a_chirp_of_constant_amplitude_is_not_saturated(tmp_path: Path) -> None:
    """Its tops are equal at all frequencies; at the highest, the motion is a few counts, whose
    noise in the acceleration looks like an effort that the motion needs."""
    arm = Arm(0.02, 0.05, 0.4, 0.5, counts=2000)
    time = np.arange(20_000) * PERIOD
    effort = 0.9 * np.sin(2.0 * np.pi * (0.5 * time + 0.1 * time**2))
    position = np.zeros(time.size)
    x = v = 0.0
    for k, u in enumerate(effort):
        position[k] = x
        if v == 0.0 and abs(u) <= arm.breakaway:
            continue
        sign = np.sign(v) if v != 0.0 else np.sign(u)
        after = v + PERIOD / arm.inertia * (u - sign * arm.coulomb - arm.viscous * v)
        v = 0.0 if v * after < 0.0 else after
        x += PERIOD * v
    seen = np.floor(position / arm.step) * arm.step
    log = make_record("log", time, seen, effort, arm.step, 0.0)
    assert hidden_saturation(log, bench_of(tmp_path, arm)) is None
