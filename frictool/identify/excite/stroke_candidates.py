"""Candidate strokes of an optimal test: distances and speeds within the bench's limits.

Each candidate is one stroke forward and one backward. The information matrix and the drive signal
of a candidate are computed for the worst axis within the a-priori intervals:

- Inertia and viscous friction are at their upper ends. The noise has the covariance noise^2 I +
  step^2/12 T T' with T = inertia D2 + viscous D1 (cramer_rao.py explains the symbols). The
  covariance grows with inertia and viscous friction, so that every other axis gives more
  information.
- The noise of the effort is computed with the largest drive constant, the drive signal with the
  smallest constant.
- A spring and a delay have unknown sizes, since `identify` allows for both effects in its
  intervals. Only a mix of strokes can separate the two effects from inertia and friction.
- The backlash is at its upper end. Two kinds of samples are excluded: samples inside the backlash,
  and samples slower than 2 % of the stroke's top speed, where the axis may stick.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import BenchLimits, axis_known, limits_of, sensing_of
from frictool.identify.excite.cramer_rao import (
    DELAY,
    PlannedStroke,
    PriorAxis,
    SensorPrecision,
    information,
)
from frictool.identify.excite.half_sines import reachable_speed
from frictool.identify.excite.sine import SHORTEST_COUNTS, longest_distance
from frictool.identify.excite.sines import SPREAD
from frictool.identify.excite.stroke_profile import unit_profile
from frictool.identify.rows.load_terms import SPRING
from frictool.typing import Matrix

EFFECTS = (DELAY, SPRING)  # effects that a mix of strokes separates from inertia and friction
DISTANCES = 6
SHORTEST_SHARE = 0.04  # shortest stroke relative to the longest one
SPEEDS = (1.0, 0.7, 0.5, 0.35, 0.2, 0.1)  # top speeds relative to the reachable speed
FEWEST_SAMPLES = 100  # least number of samples of a stroke
MOST_SAMPLES = 20_000  # largest number of samples of a stroke
DRIVE_POINTS = 400  # number of points of a stroke at which the drive is computed


@dataclass(frozen=True)
class StrokeCandidate:
    """Stroke that a test may repeat, forward and backward.

    - stroke: mean stroke; the reversal positions vary by the fraction SPREAD of `reach`
    - reach: largest distance between two successive reversals, rad | m
    - information: information matrix of both directions, (p, p); the last rows and columns belong
      to the effects
    - mean_square: mean square of the ratio of drive signal to drive limit, on the worst axis
    """

    stroke: PlannedStroke
    reach: float
    information: Matrix
    mean_square: float

    @property
    def duration(self) -> float:
        """Return the duration of both directions together, s."""
        return 2.0 * self.stroke.duration


def worst_axis(bench: Bench, effects: tuple[str, ...] = ()) -> PriorAxis:
    """Return the axis with the upper ends of the a-priori inertia and viscous friction.

    An effect in `effects` that the bench declares as a load is left out.
    """
    known = bench.mechanics
    axis = axis_known(bench)
    declared = {term for term, _ in axis.loads.terms}
    return replace(
        axis,
        inertia=known.inertia.interval[1],
        viscous=known.viscous.interval[1],
        effects=tuple(name for name in effects if name not in declared),
    )


def worst_sensing(bench: Bench, noise: float | None) -> SensorPrecision:
    """Return sample period, encoder step, and noise of the effort for the largest drive constant.

    `noise` is the standard deviation of the noise on the measured drive, A | V; the default is
    0.2 % of the drive's limit.
    """
    constant = bench.actuator.constant
    sensing = sensing_of(bench, noise)
    return replace(sensing, noise=sensing.noise * constant.interval[1] / constant.value)


def stroke_candidates(
    bench: Bench, noise: float | None, effects: tuple[str, ...] = EFFECTS
) -> list[StrokeCandidate]:
    """Return the candidate strokes for a bench.

    Parameters
    ----------
    bench
        Bench whose limits every stroke respects.
    noise
        Standard deviation of the noise on the measured drive, A | V; None for 0.2 % of the drive's
        limit.
    effects
        Effects that the strokes must separate from inertia and friction.

    Raises
    ------
    NoSolutionError
        If random reversal positions make strokes over the whole travel shorter than the backlash
        plus SHORTEST_COUNTS encoder counts, or if every stroke has too few or too many samples.
    """
    limits = limits_of(bench)
    axis, sensing = worst_axis(bench, effects), worst_sensing(bench, noise)
    longest = longest_distance(limits)
    least = axis.backlash + SHORTEST_COUNTS * sensing.step
    if (1.0 - 2.0 * SPREAD) * longest < least:
        raise NoSolutionError(
            "travel: strokes between random reversal positions can be as short as "
            f"{(1.0 - 2.0 * SPREAD) * longest:.4g} {limits.unit}; needed: {least:.4g} (backlash "
            f"and {SHORTEST_COUNTS:g} counts); use a finer encoder or more travel"
        )
    shortest = max(SHORTEST_SHARE * longest, least / (1.0 - 2.0 * SPREAD))
    candidates = [
        StrokeCandidate(
            stroke, reach, information([stroke], axis, sensing), mean_square(stroke, limits)
        )
        for reach in np.geomspace(longest, min(longest, shortest), DISTANCES).tolist()
        for share in SPEEDS
        for stroke in [_stroke(limits, reach, share)]
        if FEWEST_SAMPLES <= stroke.duration / sensing.period <= MOST_SAMPLES
    ]
    if not candidates:
        raise NoSolutionError(
            f"time: no stroke on this bench has {FEWEST_SAMPLES} to {MOST_SAMPLES} samples; use "
            "another sample period or travel"
        )
    return candidates


def _stroke(limits: BenchLimits, reach: float, share: float) -> PlannedStroke:
    top = reachable_speed(limits, (1.0 - 2.0 * SPREAD) * reach)
    return PlannedStroke(share * top, (1.0 - SPREAD) * reach)


def mean_square(stroke: PlannedStroke, limits: BenchLimits) -> float:
    """Return the mean square of the ratio of drive signal to drive limit, on the worst axis."""
    share = (np.arange(DRIVE_POINTS) + 0.5) / DRIVE_POINTS
    _, speed, acceleration = unit_profile(share)
    effort = (
        limits.inertia * stroke.distance / stroke.duration**2 * acceleration
        + limits.viscous * stroke.distance / stroke.duration * speed
        + limits.steady
    )
    return float(np.mean(effort**2)) / limits.effort**2
