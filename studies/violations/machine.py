"""Random machines and tests; a text and numbers determine them."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field

import numpy as np

from frictool.typing import Vector
from studies.violations.motion import Physics, Servo

DURATION = 10.0  # s
PERIODS = 0.5e-3, 1e-3, 2e-3  # s
TESTS = "sines", "half_sines", "steps", "multisine", "moves"


@dataclass(frozen=True)
class Instruments:
    """Errors of the logged signals.

    - period: sample period [s]
    - count: encoder step [rad]
    - noise, noise_time: deviation of the current's noise [N m], and its correlation time [s]
    - gain: measured current divided by true current
    - delay, jitter: delay of the current channel in samples, and its deviation
    - eccentric, eccentric_phase: amplitude of the encoder's error over a turn, and its phase [rad]
    """

    period: float
    count: float
    noise: float
    noise_time: float = 0.0
    gain: float = 1.0
    delay: float = 0.0
    jitter: float = 0.0
    eccentric: float = 0.0
    eccentric_phase: float = 0.0


@dataclass(frozen=True)
class Machine:
    """Random machine with its test and the prior knowledge of its bench.

    - constant, constant_share: torque constant of the bench [N m/A], and its relative half width
    - bench_inertia, bench_viscous, bench_coulomb: value, low and high of the bench (SI)
    - speed, rate: largest speed of the test, and its angular frequency [rad/s]
    - severity: 0 (mild) to 1 (gross)
    """

    physics: Physics
    instruments: Instruments
    servo: Servo
    test: str
    played: Vector = field(repr=False)
    rate_played: Vector = field(repr=False)
    constant: float
    constant_share: float
    bench_inertia: tuple[float, float, float]
    bench_viscous: tuple[float, float, float]
    bench_coulomb: tuple[float, float, float]
    speed: float
    rate: float
    severity: float


def generator_of(*parts: object) -> np.random.Generator:
    """Return the generator that the text of `parts` determines."""
    digest = hashlib.sha256("/".join(map(str, parts)).encode()).digest()
    return np.random.default_rng(int.from_bytes(digest[:16], "big"))


def draw_machine(draw: np.random.Generator) -> Machine:
    """Return a machine that obeys the model, with a reasonable test."""
    inertia = 10.0 ** draw.uniform(-6.0, -1.0)
    frequency = 10.0 ** draw.uniform(math.log10(0.6), math.log10(2.5))
    rate = 2.0 * math.pi * frequency
    amplitude = 10.0 ** draw.uniform(-0.3, 1.3)
    speed = amplitude * rate
    coulomb = inertia * speed * rate * 10.0 ** draw.uniform(-0.4, 0.5)
    viscous = coulomb / speed * 10.0 ** draw.uniform(-0.6, 0.3)
    offset = coulomb * draw.uniform(-0.12, 0.12)
    test = TESTS[int(draw.integers(len(TESTS)))]
    period = PERIODS[int(draw.integers(len(PERIODS)))]
    top = inertia * speed * rate + viscous * speed + coulomb
    servo = Servo(0.0, 0.0, 4.0 * top)
    time = np.asarray(np.arange(round(DURATION / period)) * period, dtype=np.float64)
    if test == "half_sines":
        played = _half_sines(draw, time, rate, top)
        rate_played = np.zeros(time.size)
    else:
        pole = draw.uniform(8.0, 14.0) * rate
        servo = Servo(inertia * pole**2, 2.0 * inertia * pole, 4.0 * top)
        played = amplitude * _reference(draw, test, time, rate) * np.minimum(rate * time, 1.0)
        rate_played = np.gradient(played, period)
    count = amplitude * 10.0 ** draw.uniform(-4.4, -3.0)
    instruments = Instruments(period, count, coulomb * 10.0 ** draw.uniform(-2.3, -1.3))
    constant = 10.0 ** draw.uniform(-2.0, 0.0)

    def prior(value: float, low: float, high: float) -> tuple[float, float, float]:
        centre = value * draw.uniform(0.8, 1.25)
        return centre, low * centre, high * centre

    return Machine(
        Physics(inertia, viscous, coulomb, offset, warming_time=DURATION),
        instruments,
        servo,
        test,
        played,
        rate_played,
        constant,
        0.05,
        prior(inertia, 0.4, 2.0),
        prior(viscous, 0.0, 3.0),
        prior(coulomb, 0.2, 2.5),
        speed,
        rate,
        0.0,
    )


def _half_sines(draw: np.random.Generator, time: Vector, rate: float, top: float) -> Vector:
    """Return half sines of effort (n,) [N m] of alternate sign, each followed by a rest."""
    half = math.pi / rate
    number = (time / (1.5 * half)).astype(np.int64)
    within = time - 1.5 * half * number
    levels = top * draw.uniform(0.9, 1.6, int(number[-1]) // 2 + 1)
    sign = 1.0 - 2.0 * (number % 2)
    return np.where(within < half, np.sin(rate * within), 0.0) * levels[number // 2] * sign


def _reference(draw: np.random.Generator, test: str, time: Vector, rate: float) -> Vector:
    """Return a reference position (n,) relative to the amplitude of the test."""
    if test == "sines":
        edges = np.cumsum(np.full(4, time[-1] / 4.0))[:-1]
        part = np.searchsorted(edges, time)
        size = draw.permutation([0.3, 0.55, 0.8, 1.0])[part]
        smooth = np.convolve(size, _bell(time, math.pi / rate), mode="same")
        return np.asarray(smooth * np.sin(rate * time))
    if test == "multisine":
        factors = np.array([0.35, 0.8, 1.4, 2.1]) * draw.uniform(0.9, 1.1, 4)
        sizes = 0.6 / factors
        phases = draw.uniform(0.0, 2.0 * np.pi, 4)
        angles = np.outer(factors * rate, time) + phases[:, None]
        return np.asarray(sizes @ np.sin(angles)) / float(np.sum(sizes))
    return _moves(draw, test == "steps", time, math.pi / rate)


def _moves(draw: np.random.Generator, steps: bool, time: Vector, duration: float) -> Vector:
    """Return moves between positions -1 and 1 (n,), each followed by a rest.

    steps: True for equal moves between 0 and 1, False for random moves.
    """
    out = np.zeros(time.size)
    at, start = 0.1, 0.0
    while at < time[-1]:
        if steps:
            target, length, rest = 1.0 - start, duration, 0.2 * duration
        else:
            target = float(draw.uniform(-1.0, 1.0))
            length, rest = duration * np.array([draw.uniform(1.0, 2.0), draw.uniform(0.1, 1.2)])
        share = np.clip((time[time >= at] - at) / length, 0.0, 1.0)
        out[time >= at] = start + (target - start) * share**3 * (
            10.0 - 15.0 * share + 6.0 * share**2
        )
        at, start = at + length + rest, target
    return out


def _bell(time: Vector, width: float) -> Vector:
    """Return weights of a moving average over `width` s; their sum is 1."""
    size = max(round(width / (time[1] - time[0])), 1)
    return np.full(size, 1.0 / size)
