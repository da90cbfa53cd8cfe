"""Wear estimated along simulated logs of the clutch (thesis 6.3.2, second test)."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.observe.wear_estimate import WearEstimate
from studies.rigs.clutch_fleet import Loop, Unit, believed, clutch, run, spread, steps, targets

WEARS = (1.0, 1.2, 1.5)
LOOPS: tuple[Loop, ...] = ("speed", "linear")
SOON, WITHIN = 8, 3.0  # moves before the first judgement; allowed error of the wear [%]
PHASE_STREAM = 104  # second seed of the random start phase


def reference(seed: int, random: bool = False) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the steps of 6.3.2, or random steps [rad], with a random start within a count."""
    phase = (
        float(np.random.Generator(np.random.PCG64([seed, PHASE_STREAM])).random())
        * clutch().bench.encoder.resolution
    )
    return (targets(seed) if random else steps()) + phase


def estimates(unit: Unit, seed: int, loop: Loop, random: bool = False) -> list[WearEstimate]:
    """Return the estimate after each move of a log."""
    estimator, found = WearEstimator(believed()), []
    for piece in run(unit, reference(seed, random), seed, loop).pieces:
        found += estimator.take(piece)
    return [*found, *estimator.finish()]


def drawn(seed: int) -> Unit:
    """Return a random plant with one of WEARS."""
    return spread(seed, wear=WEARS[seed % len(WEARS)])


class Runs:
    """Errors [%] of runs, and coverage of the intervals."""

    def __init__(self) -> None:
        self.last: list[float] = []
        self.soon: list[float] = []
        self.held: list[bool] = []
        self.held_soon: list[bool] = []
        self.moves: list[int] = []
        self.halves: list[float] = []

    def take(self, found: list[WearEstimate], wear: float) -> None:
        """Add the estimates of a run with the true `wear`."""
        last, soon = found[-1].wear, found[min(SOON, len(found)) - 1].wear
        self.last.append(100.0 * (last.value / wear - 1.0))
        self.soon.append(100.0 * (soon.value / wear - 1.0))
        self.held.append(last.low <= wear <= last.high)
        self.held_soon.append(soon.low <= wear <= soon.high)
        self.moves.append(found[-1].moves)
        self.halves.append(50.0 * (last.high - last.low) / wear)

    @property
    def figures(self) -> dict[str, float]:
        """Return the values for the table."""
        return {
            "bias_percent": float(np.mean(self.last)),
            "deviation_percent": float(np.std(self.last)),
            "largest_percent": float(np.max(np.abs(self.last))),
            "covered": float(np.mean(self.held)),
            f"covered_after_{SOON}": float(np.mean(self.held_soon)),
            f"within_{WITHIN:g}_after_{SOON}": float(np.mean(np.abs(self.soon) <= WITHIN)),
            f"largest_after_{SOON}_percent": float(np.max(np.abs(self.soon))),
            "half_percent": float(np.median(self.halves)),
            "moves": float(np.mean(self.moves)),
        }
