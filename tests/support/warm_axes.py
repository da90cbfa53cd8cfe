"""Axes whose friction depends on the temperature, simulated without the engine of the product.

Moreau's time stepping: the dry friction of a step takes away velocity, at most all of it. All logs
of a call are simulated at the same time, one column each.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.motion_record import (
    MotionRecord,
    TemperatureSignal,
    make_record,
    reference_temperature,
)
from frictool.runtime.kernels import kernel
from frictool.typing import Matrix, Vector
from tests.support.loaded_axis import COUNT, NOISE, rotary_bench

PERIOD, SAMPLES, STEPS = 1e-3, 20_000, 4  # s; of a log; time steps of a sample
SENSOR = 0.1  # K, resolution of the temperature sensor
COLD, HOT = 30.0, 80.0  # degC; the viscous friction halves between them
# draws the temperature (n,) of each log of an axis, degC
Histories = Callable[[np.random.Generator], list[Vector]]


@dataclass(frozen=True)
class WarmTruth:
    """True axis: friction levels at COLD, relative fall of Coulomb friction per kelvin.

    wear: factor of the Coulomb friction. curved: True if viscous friction falls by the same ratio
    per kelvin (Reynolds); False for a straight line.
    """

    inertia: float
    viscous_cold: float
    coulomb_cold: float
    offset: float
    fall: float
    curved: bool
    wear: float = 1.0

    def viscous(self, temperature: Vector | float) -> Vector:
        """Return the viscous friction (n,) at temperatures (n,)."""
        share = (np.asarray(temperature) - COLD) / (HOT - COLD)
        return self.viscous_cold * (0.5**share if self.curved else 1.0 - 0.5 * share)

    def coulomb(self, temperature: Vector | float) -> Vector:
        """Return the Coulomb friction (n,) at temperatures (n,)."""
        return self.wear * self.coulomb_cold * (1.0 - self.fall * (np.asarray(temperature) - COLD))


@dataclass(frozen=True)
class WarmAxis:
    """True axis, its logs and its bench."""

    truth: WarmTruth
    records: list[MotionRecord]
    bench: Bench


def warming_up(draw: np.random.Generator) -> list[Vector]:
    """Return the temperature of one log, which approaches a final value exponentially."""
    share = 1.0 - np.exp(-np.arange(SAMPLES) / SAMPLES * draw.uniform(1.5, 3.0))
    first = draw.uniform(28.0, 35.0)
    last = draw.uniform(70.0, 82.0)
    return [first + (last - first) * share / share[-1]]


def cold_and_hot(draw: np.random.Generator) -> list[Vector]:
    """Return the temperatures of two logs that hardly change."""
    drift = np.linspace(0.0, 1.0, SAMPLES)
    return [draw.uniform(25.0, 35.0) + drift, draw.uniform(70.0, 80.0) + drift]


def changing(draw: np.random.Generator) -> list[Vector]:
    """Return the temperature of one log, between any two temperatures of COLD to HOT."""
    share = 1.0 - np.exp(-np.arange(SAMPLES) / SAMPLES * draw.uniform(1.0, 3.0))
    first, last = draw.uniform(COLD, HOT, 2)
    return [first + (last - first) * share / share[-1]]


def simulated(truths: Sequence[WarmTruth], warm: Matrix, effort: Matrix) -> Matrix:
    """Return the positions (n, k) of k axes at temperatures (n, k) under efforts (n, k)."""
    step = PERIOD / STEPS / np.array([one.inertia for one in truths])
    offset = np.array([one.offset for one in truths])
    viscous, coulomb = (
        np.column_stack([getattr(one, name)(warm[:, k]) for k, one in enumerate(truths)])
        for name in ("viscous", "coulomb")
    )
    out = np.empty(effort.shape)
    _play(step, effort - offset, viscous, coulomb, out)
    return out


@kernel
def _play(step: Vector, effort: Matrix, viscous: Matrix, coulomb: Matrix, out: Matrix) -> None:
    """Fill the positions (n, k); step: time step per inertia (k,)."""
    for axis in range(effort.shape[1]):
        x, v = 0.0, 0.0
        for k in range(effort.shape[0]):
            out[k, axis] = x
            for _ in range(STEPS):
                free = v + step[axis] * (effort[k, axis] - 0.5 * viscous[k, axis] * v)
                slowed = math.copysign(max(abs(free) - step[axis] * coulomb[k, axis], 0.0), free)
                after = slowed / (1.0 + 0.5 * step[axis] * viscous[k, axis])  # trapezoidal rule
                x += 0.5 * (PERIOD / STEPS) * (v + after)
                v = after


def warm_axes(
    seeds: Sequence[int],
    curved: bool,
    histories: Histories,
    wears: Sequence[float] = (1.0,),
) -> list[WarmAxis]:
    """Return the axis of each seed, with a log for each of its temperatures.

    The axes have the wears in turn.
    """
    time = np.arange(SAMPLES) * PERIOD
    draws = [np.random.default_rng([seed, 41]) for seed in seeds]
    truths = [
        WarmTruth(
            5.0 * draw.uniform(0.8, 1.2),
            12.0 * draw.uniform(0.8, 1.2),
            8.0 * draw.uniform(0.8, 1.2),
            draw.uniform(-1.0, 1.0),
            draw.uniform(0.0, 0.003),
            curved,
            wears[k % len(wears)],
        )
        for k, draw in enumerate(draws)
    ]
    logs = [(k, warm) for k, draw in enumerate(draws) for warm in histories(draw)]
    efforts = [
        sum(
            a * np.sin(2.0 * np.pi * f * time + draws[k].uniform(0.0, 6.0))
            for a, f in ((25.0, 0.9), (18.0, 0.37), (11.0, 0.23))
        )
        for k, _ in logs
    ]
    warm = np.column_stack([one for _, one in logs])
    x = simulated([truths[k] for k, _ in logs], warm, np.column_stack(efforts))
    records: list[list[MotionRecord]] = [[] for _ in seeds]
    for column, (k, _) in enumerate(logs):
        noisy = efforts[column] + NOISE * draws[k].standard_normal(SAMPLES)
        read = np.floor(x[:, column] / COUNT) * COUNT
        record = make_record(f"warm_{column}", time, read, noisy, COUNT, 0.0)
        sensed = np.rint(warm[:, column] / SENSOR) * SENSOR
        signal = TemperatureSignal(sensed, reference_temperature([sensed]))
        records[k].append(replace(record, temperature=signal))
    return [
        WarmAxis(truth, own, rotary_bench(None)) for truth, own in zip(truths, records, strict=True)
    ]
