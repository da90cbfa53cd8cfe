"""Random actuators of any size and speed, which are feasible by construction.

A seed text and a number determine an actuator. Times are drawn in sample periods, distances in
counts, and efforts relative to the drive. The drive's limit follows from the bang-bang motion of
the worst plant, which needs 25 to 60 % of the requested response time.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from studies.actuators.bang_bang import bang_bang_distance

PLANTS = 56
PHASES = 2  # the corners are simulated with this many phases of the encoder
COUNTS = 80.0, 20_000.0  # least and largest step of the reference, in encoder counts
TURNS = 0.05, 60.0  # least and largest step of a rotary axis, in turns
VARIED = ("inertia", "viscous", "coulomb", "constant")
CORNERS = PHASES * 2 ** len(VARIED)


class Interval(NamedTuple):
    """Value of a parameter, and the ends of its interval."""

    value: float
    low: float
    high: float


class Plant(NamedTuple):
    """One plant: parameters in SI, and start position within an encoder count (0 to 1)."""

    inertia: float
    viscous: float
    coulomb: float
    constant: float
    phase: float


@dataclass(frozen=True)
class Actuator:
    """Actuator and its requirements, in SI (rotary or linear)."""

    name: str
    axis: str  # rotary | linear
    drive: str  # current | voltage
    period: float  # s
    delay: int  # samples
    lag: float  # s
    encoder_step: float  # rad | m
    counts_per_turn: int | None  # of a rotary axis
    inertia: Interval  # kg m^2 | kg
    viscous: Interval  # N m s/rad | N s/m
    coulomb: Interval  # N m | N
    constant: Interval  # N m/A | N/A | N m/V | N/V
    limit: float  # A | V
    breakaway_ratio: float  # breakaway divided by Coulomb friction
    backlash: float  # rad | m, full width
    backlash_coulomb: float  # N m | N, of the nominal plant
    amplitude: float  # rad | m, the largest step of the reference
    response: float  # s
    overshoot: float  # %
    static_error: float  # rad | m
    oscillations: int
    margin: float
    bang_bang: float  # s, of the worst plant

    @property
    def start(self) -> float:
        """Return the position from which the step starts; the travel is 1.25 times the step."""
        return 0.125 * self.amplitude

    @property
    def travel(self) -> float:
        """Return the upper end of the travel, which begins at 0."""
        return 1.25 * self.amplitude

    @property
    def short_hold(self) -> float:
        """Return the duration of the first step [s]."""
        return 5.0 * self.response

    @property
    def rest_after(self) -> float:
        """Return the time after which the axis must be at rest with the drive at 0 [s]."""
        return 10.0 * self.response

    @property
    def long_hold(self) -> float:
        """Return the duration of the last step, in which rest is judged [s]."""
        return 15.0 * self.response


def draw(seed: str, number: int) -> Actuator:
    """Return actuator `number` of a seed, which does not depend on other drawn actuators."""
    rng = _generator(seed, number)
    period = _significant(_decades(rng, 1e-4, 1e-2), 3)
    samples = round(_decades(rng, 60.0, 1000.0))
    response = samples * period
    duration = rng.uniform(0.25, 0.6) * response
    delay = int(rng.integers(0, 3))
    lag = 0.0 if rng.random() < 0.15 else _significant(rng.uniform(0.0, 5.0) * period, 3)
    rotary = rng.random() < 0.8
    drive = "voltage" if rng.random() < 0.25 else "current"

    counts_per_turn = round(_decades(rng, 24.0, 20_000.0)) if rotary else None
    if counts_per_turn:
        least, most = (turns * counts_per_turn for turns in TURNS)
        step = 2.0 * math.pi / counts_per_turn
        inertia = _decades(rng, 1e-7, 1e-1)
    else:
        least, most = COUNTS
        step = _significant(_decades(rng, 1e-7, 1e-4), 2)
        inertia = _decades(rng, 1e-2, 1e2)
    counts = round(_decades(rng, max(least, COUNTS[0]), min(most, COUNTS[1])))
    amplitude = counts * step

    spread = rng.uniform(0.05, 0.2)
    inertias = _around(inertia, spread)
    strength = rng.uniform(0.01, 0.05)
    ratio = _decades(rng, 1.3, 10.0)
    dry = rng.uniform(0.05, 0.6)  # largest Coulomb friction divided by the nominal effort
    breakaway = _significant(rng.uniform(1.0, 1.15), 3)
    damping = (
        0.0 if rng.random() < 0.2 else _decades(rng, 0.05, 3.0)
    )  # largest value, times the duration
    distance = bang_bang_distance(
        dry / (1.0 - strength),
        breakaway * dry / (1.0 - strength),
        lag / duration,
        damping,
        delay * period / duration,
    )
    if distance <= 0.0:  # the lag and the delay leave no time: draw another one
        return draw(f"{seed}'", number)

    effort = amplitude / (distance * duration**2) * inertias.high / (1.0 - strength)
    limit = _decades(rng, 0.5, 100.0)
    torque = rng.random() < 0.2 and drive == "current"  # a drive that is commanded by its effort
    constant = 1.0 if torque else _significant(effort / limit, 3)
    coulomb = _between(dry * effort / ratio, dry * effort)
    largest_viscous = damping * inertias.high / duration
    viscous = _between(rng.uniform(0.0, 0.8) * largest_viscous, largest_viscous)
    loose = 0.0 if rng.random() < 0.3 else rng.uniform(0.0, 3.0)
    return Actuator(
        name=f"actuator {number}",
        axis="rotary" if rotary else "linear",
        drive=drive,
        period=period,
        delay=delay,
        lag=lag,
        encoder_step=step,
        counts_per_turn=counts_per_turn,
        inertia=inertias,
        viscous=viscous,
        coulomb=coulomb,
        constant=_around(constant, strength),
        limit=_significant(effort / constant, 5),
        breakaway_ratio=breakaway,
        backlash=_significant(loose * step, 4),
        backlash_coulomb=_significant(rng.uniform(0.2, 0.8) * coulomb.value, 4),
        amplitude=amplitude,
        response=_significant(response, 6),
        overshoot=_significant(_decades(rng, 2.0, 10.0), 2),
        static_error=_significant(max(_decades(rng, 0.006, 0.04) * amplitude, 2.0 * step), 4),
        oscillations=1,
        margin=_significant(rng.uniform(0.4, 0.5), 2),
        bang_bang=duration,
    )


def draw_plants(actuator: Actuator, seed: str) -> tuple[Plant, ...]:
    """Return the plants on which a controller is judged; the first one is nominal.

    Each corner of the parameter intervals occurs with PHASES start positions within an encoder
    count. The other plants and their start positions are uniformly distributed.
    """
    rng = _generator(f"{seed}: plants of {actuator.name}", 0)
    intervals: list[Interval] = [getattr(actuator, name) for name in VARIED]
    plants = [_plant([interval.value for interval in intervals], 0.5)]
    for ends in product(*((interval.low, interval.high) for interval in intervals)):
        plants += [_plant(ends, float(rng.random())) for _ in range(PHASES)]
    while len(plants) < PLANTS:
        inside = [float(rng.uniform(interval.low, interval.high)) for interval in intervals]
        plants.append(_plant(inside, float(rng.random())))
    return tuple(plants)


def _plant(values: Sequence[float], phase: float) -> Plant:
    return Plant(**dict(zip(VARIED, values, strict=True)), phase=phase)


def _generator(seed: str, number: int) -> np.random.Generator:
    digest = hashlib.sha256(f"{seed}: {number}".encode()).digest()
    return np.random.default_rng(int.from_bytes(digest, "big"))


def _decades(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number whose logarithm is uniform."""
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def _around(value: float, share: float) -> Interval:
    return Interval(
        *(_significant(value * factor, 5) for factor in (1.0, 1.0 - share, 1.0 + share))
    )


def _between(low: float, high: float) -> Interval:
    return Interval(*(_significant(value, 5) for value in (0.5 * (low + high), low, high)))


def _significant(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
