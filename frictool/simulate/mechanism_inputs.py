"""Inputs of a scenario to a mechanism: signals of sources without controller, efforts on blocks.

    |- sample k ------------|- sample k+1 ---
    |-- part --|-- part ----|-- part --------

A sample is divided into parts wherever a signal or the slope of a signal jumps. In each part, a
signal is replaced by its mean. Steps are therefore exact, and so is the impulse of any signal. For
a sine or a ramp, the error of the computed motion is of second order in the length of the part.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from frictool.documents.conditions import Disturbance, Signal
from frictool.engine.mechanism.closed_loop import MechanismInputs
from frictool.typing import IntVector, Vector

SAME_INSTANT = 1e-9  # largest difference of two instants that are treated as equal, in samples


def inputs_of(
    signals: Mapping[int, Sequence[Signal]],
    disturbances: Sequence[tuple[int, Disturbance]],
    sources: int,
    samples: int,
    period: float,
) -> MechanismInputs:
    """Return source signals and block efforts, for `samples` samples with the period `period` [s].

    - signals: signals of each source, by source index
    - disturbances: pairs (block index, disturbance)
    - sources: number of sources
    """
    courses = [course for of in signals.values() for course in of] + [
        one for _, one in disturbances
    ]
    edges, first = _cut(courses, samples, period)
    blocks = sorted({block for block, _ in disturbances})
    drives = np.zeros((edges.size - 1 if signals else 0, sources))
    for index, of in signals.items():
        for signal in of:
            drives[:, index] += mean_over(signal, signal.level.value, edges * period)
    efforts = np.zeros((edges.size - 1 if blocks else 0, len(blocks)))
    for block, disturbance in disturbances:
        efforts[:, blocks.index(block)] += mean_over(
            disturbance, disturbance.effort.value, edges * period
        )
    return MechanismInputs(
        first, np.diff(edges) * period, drives, np.array(blocks, dtype=np.int64), efforts
    )


def _cut(
    courses: Iterable[Signal | Disturbance], samples: int, period: float
) -> tuple[Vector, IntVector]:
    instants = {
        instant / period
        for course in courses
        for instant in (course.at_s, _end(course))
        if instant / period < samples
    }
    inside = np.array([one for one in sorted(instants) if abs(one - round(one)) > SAME_INSTANT])
    edges = np.sort(np.concatenate([np.arange(samples + 1, dtype=np.float64), inside]))
    return edges, np.searchsorted(edges, np.arange(samples + 1, dtype=np.float64)).astype(np.int64)


def _end(course: Signal | Disturbance) -> float:
    return math.inf if course.duration_s is None else course.at_s + course.duration_s


def mean_over(course: Signal | Disturbance, level: float, edges: Vector) -> Vector:
    """Return the mean (m,) of a signal over each interval between the times `edges` (m + 1,) [s].

    - course: shape of the signal, which must not jump inside an interval
    - level: final value of a ramp, amplitude of a sine, or value of a step
    """
    begin, end = edges[:-1], edges[1:]
    middle = 0.5 * (begin + end)
    slack = SAME_INSTANT * float(np.max(end - begin, initial=0.0))
    since = middle - course.at_s
    active = (since > -slack) & (middle < _end(course))
    mean: Vector
    if course.kind == "ramp":
        assert course.duration_s is not None
        mean = level * np.clip(since / course.duration_s, 0.0, 1.0)
        return mean
    if course.frequency_hz is None:
        return np.where(active, level, 0.0)
    angle = 2.0 * math.pi * course.frequency_hz * since + math.radians(course.phase_deg)
    mean = np.where(
        active, level * np.sin(angle) * np.sinc(course.frequency_hz * (end - begin)), 0.0
    )
    return mean


def mean_efforts(inputs: MechanismInputs) -> dict[int, Vector]:
    """Return the mean effort over each sample (n,) [N m | N] by index of the disturbed block."""
    period = np.add.reduceat(inputs.durations, inputs.first[:-1])
    pushed = (
        np.add.reduceat(inputs.efforts * inputs.durations[:, None], inputs.first[:-1], axis=0)
        if inputs.blocks.size
        else inputs.efforts
    )
    return {block: pushed[:, index] / period for index, block in enumerate(inputs.blocks.tolist())}
