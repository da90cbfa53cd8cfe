"""Where the reference is held, and which holds begin with a step.

A *hold* is a run of at least 20 samples of constant reference. A *step* is a hold that follows
another at once, or with at most three samples between (a reference that was resampled); it starts
at the first sample at which the reference has left the hold before. The record's first hold is a
step from the initial position where the axis then moves at least half of the way to the reference:
a test that begins with its step. A jump of no more than the sensor's step is no step: it is what a
replayed encoder makes of a slow motion, and no sensor could tell how the axis answers to it. A
smooth reference has neither holds nor steps.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MIN_SAMPLES = 20
TRANSITION_SAMPLES = 3


@dataclass(frozen=True)
class Hold:
    """Samples start <= k < stop, held at `target`; `origin` is what the step left [rad or m], None
    where no step led here."""

    start: int
    stop: int
    target: float
    origin: float | None

    def of(self, signal: NDArray[np.float64]) -> NDArray[np.float64]:
        """The samples of `signal` (n,) that belong to this hold."""
        return signal[self.start : self.stop]


def find_holds(
    reference: NDArray[np.float64], position: NDArray[np.float64], resolution: float = 0.0
) -> tuple[Hold, ...]:
    """The holds of `reference` (n,), with `position` (n,) for the first one, in the order of time.

    `resolution` is the sensor's step [rad or m], 0 where it is not known.
    """
    if reference.size < MIN_SAMPLES:
        return ()
    changes = np.flatnonzero(np.abs(np.diff(reference)) > 1e-9 * float(np.ptp(reference))) + 1
    bounds = [0, *changes.tolist(), reference.size]
    runs = [(a, b) for a, b in itertools.pairwise(bounds) if b - a >= MIN_SAMPLES]
    holds: list[Hold] = []
    for start, stop in runs:
        target = float(reference[stop - 1])
        before = holds[-1] if holds else None
        if (
            before is not None
            and start - before.stop <= TRANSITION_SAMPLES
            and abs(target - before.target) > (1.0 + 1e-6) * resolution
        ):
            holds.append(Hold(before.stop, stop, target, before.target))
        else:
            holds.append(
                Hold(
                    start,
                    stop,
                    target,
                    _initial_origin(position[:stop], target) if start == 0 else None,
                )
            )
    return tuple(holds)


def _initial_origin(position: NDArray[np.float64], target: float) -> float | None:
    """The initial position, where the record begins with a step that the axis follows at least half
    of the way."""
    distance = abs(target - float(position[0]))
    moves = distance > 0.0 and float(np.ptp(position)) >= 0.5 * distance
    return float(position[0]) if moves else None
