"""Comparison of a mechanism with its one-inertia model, with the same controller and reference.

The allowed difference of the positions during a hold is the backlash plus d. d is the larger of one
encoder step and `tolerance` times the reference step at the start of the hold. The allowed
difference of the response times is the larger of `tolerance` times the response time of the whole
mechanism, and one sample period.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from frictool.logs.log import Stream
from frictool.metrics.response_time import response_time_95
from frictool.typing import Vector


@dataclass(frozen=True)
class LoopStep:
    """Comparison during one phase of constant reference (hold).

    time: start of the hold [s].
    origin, target: reference before and during the hold [rad | m].
    distance: largest position difference of mechanism and model during the hold [rad | m].
    at_the_end: position difference of mechanism and model at the end of the hold [rad | m].
    whole_s, reduced_s: response times [s] of the whole mechanism and of the one-inertia model.
    allowed: largest allowed difference of the positions [rad | m].
    """

    time: float
    origin: float
    target: float
    distance: float
    at_the_end: float
    whole_s: float
    reduced_s: float
    allowed: float


@dataclass(frozen=True)
class LoopComparison:
    """Comparison of the whole mechanism with its one-inertia model in all holds of a run.

    steps: comparison during each hold (phase of constant reference).
    refused: message on the first difference that is too large; None if all differences are allowed.
    """

    steps: tuple[LoopStep, ...]
    refused: str | None


def in_loop(
    whole: Stream, reduced: Stream, resolution: float, play: float, tolerance: float
) -> LoopComparison:
    """Compare the logs of the whole mechanism and of the one-inertia model in one scenario.

    resolution: encoder step [rad | m].
    play: width of the backlash [rad | m].
    """
    reference = whole.signals["reference"]
    time = whole.time
    one, other = whole.signals["position_true"], reduced.signals["position_true"]
    period = float(time[1] - time[0])
    steps = []
    refused = None
    for first, last in _holds(reference):
        origin = float(reference[first - 1]) if first else float(one[0])
        target = float(reference[first])
        hold = slice(first, last)
        apart = np.abs(one[hold] - other[hold])
        allowed = play + max(tolerance * abs(target - origin), resolution)
        times = [
            response_time_95(time[hold], each[hold], origin, target, resolution)
            for each in (one, other)
        ]
        step = LoopStep(
            float(time[first]),
            origin,
            target,
            float(np.max(apart)),
            float(apart[-1]),
            times[0],
            times[1],
            allowed,
        )
        steps.append(step)
        refused = refused or _refused(step, tolerance, period, resolution)
    return LoopComparison(tuple(steps), refused)


def _refused(step: LoopStep, tolerance: float, period: float, resolution: float) -> str | None:
    where = f"step at {step.time:g} s"
    if step.distance > step.allowed:
        return (
            f"{where}: positions differ by {step.distance:.3g}; allowed: at most {step.allowed:.3g}"
        )
    # a step of a few counts has no meaningful response time
    if abs(step.target - step.origin) < 4.0 * resolution:
        return None
    if math.isfinite(step.whole_s) != math.isfinite(step.reduced_s):
        return (
            f"{where}: "
            f"only {'the one-inertia model' if math.isfinite(step.reduced_s) else 'the mechanism'} "
            "settles; both or neither must settle"
        )
    if math.isfinite(step.whole_s) and abs(step.reduced_s - step.whole_s) > max(
        tolerance * step.whole_s, period
    ):
        return (
            f"{where}: response time {step.reduced_s:.4g} s of the one-inertia model, "
            f"{step.whole_s:.4g} s of the whole mechanism; they may differ by {100 * tolerance:g} %"
        )
    return None


def _holds(reference: Vector) -> list[tuple[int, int]]:
    changes = np.flatnonzero(np.diff(reference) != 0.0) + 1
    ends = [0, *changes.tolist(), reference.size]
    return [(first, last) for first, last in itertools.pairwise(ends) if last - first > 20]
