"""Holds (phases of constant reference), and the steps with which they begin.

A *hold* is a sequence of at least 20 samples with the same reference. A hold begins with a *step*
if at most three samples, which resampling can add, separate this hold from the previous hold. The
step starts at the first sample at which the reference has left the previous hold.

The first hold begins with a step from the initial position if the axis moves at least half of the
distance to the reference. A distance of at most one sensor step is not a step: a reference replayed
from an encoder contains such jumps during slow motion, and the position of a resting axis is known
to within one sensor step. A smooth reference has neither holds nor steps.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictool.typing import Vector

MIN_SAMPLES = 20  # shortest hold
TRANSITION_SAMPLES = 3  # largest number of samples between the holds before and after a step
ConstantRun = tuple[int, int, float]  # start, stop, reference [rad or m]


@dataclass(frozen=True)
class Hold:
    """Samples start <= k < stop, in which the reference is constant at `target` [rad or m].

    origin: reference before the step [rad or m]; None if the hold does not begin with a step. The
    samples between two holds at a step (at most three) belong to the second hold.
    """

    start: int
    stop: int
    target: float
    origin: float | None

    def of(self, signal: Vector) -> Vector:
        """Return the samples of `signal` (n,) in this phase of constant reference."""
        return signal[self.start : self.stop]


def find_holds(reference: Vector, position: Vector, resolution: float = 0.0) -> tuple[Hold, ...]:
    """Return the holds of `reference` (n,), its phases of constant reference, in order of time.

    `position` (n,) shows whether the first hold begins with a step. `resolution` is the sensor's
    step [rad or m], 0 if unknown.
    """
    return holds_of(constant_runs(reference), position, resolution)


def constant_runs(reference: Vector) -> tuple[ConstantRun, ...]:
    """Return (start, stop, value) of each phase of at least 20 equal samples of `reference`."""
    if reference.size < MIN_SAMPLES:
        return ()
    changes = np.flatnonzero(np.abs(np.diff(reference)) > 1e-9 * float(np.ptp(reference))) + 1
    bounds = [0, *changes.tolist(), reference.size]
    return tuple(
        (start, stop, float(reference[stop - 1]))
        for start, stop in itertools.pairwise(bounds)
        if stop - start >= MIN_SAMPLES
    )


def holds_of(
    runs: Sequence[ConstantRun], position: Vector, resolution: float = 0.0
) -> tuple[Hold, ...]:
    """Return the same holds as `find_holds`, but from the result `runs` of `constant_runs`."""
    holds: list[Hold] = []
    for start, stop, target in runs:
        before = holds[-1] if holds else None
        if (
            before is not None
            and start - before.stop <= TRANSITION_SAMPLES
            and _is_step(target - before.target, resolution)
        ):
            holds.append(Hold(before.stop, stop, target, before.target))
        else:
            holds.append(
                Hold(
                    start,
                    stop,
                    target,
                    _initial_origin(position[:stop], target, resolution) if start == 0 else None,
                )
            )
    return tuple(holds)


def _is_step(distance: float, resolution: float) -> bool:
    return abs(distance) > (1.0 + 1e-6) * resolution


def _initial_origin(position: Vector, target: float, resolution: float) -> float | None:
    distance = target - float(position[0])
    moves = float(np.ptp(position)) >= 0.5 * abs(distance)
    return float(position[0]) if moves and _is_step(distance, resolution) else None
