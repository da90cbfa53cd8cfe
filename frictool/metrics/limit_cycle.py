"""Limit cycle: an oscillation that is kept up while the reference is held (5.2.1).

Friction that sticks lets the integral wait for seconds before the axis jumps, so that a hold of a
second shows none where there is one. What is watched is the hold behind its first third, where the
answer to the step has died out. A turn counts where the way back is more than one sensor step,
between two of which a resting axis may flicker, and more than the position's noise reaches from
peak to peak.

    kept up        at least two turns; the last swings are at least 0.8 of the first; the time since
                   the last turn is at most twice
                   the longest between two
    stands still   no motion beyond that threshold, or turns that have ended: the last third is
                   still, for more than twice as long as
                   the longest time between two turns
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.reversals import turning_points
from frictool.metrics.sample_durations import sample_durations
from frictool.metrics.white_noise import noise_floor

LEAST_HOLD = 15.0  # s, before a limit cycle is told absent
LEAST_TURNS = 2
MANY_TURNS = 6  # three periods: told present in a hold of any length
KEPT_UP = 0.8  # of the first swings
OVERDUE = 2.0  # times the longest time between two turns


@dataclass(frozen=True)
class LimitCycle:
    """amplitude: half the peak to peak over the last period [rad or m], 0 where there is no cycle,
    None where the hold cannot tell.

    period: mean time between turns of one side [s]. reason: why it cannot be told.
    """

    amplitude: float | None
    period: float | None = None
    reason: str = ""


def limit_cycle(
    time: NDArray[np.float64], position: NDArray[np.float64], resolution: float = 0.0
) -> LimitCycle:
    """The limit cycle of a hold: `time` [s] and `position` (n,) [rad or m], with the sensor's
    step."""
    held = float(np.sum(sample_durations(time)))
    least = (
        LEAST_HOLD - 0.5 * held / time.size
    )  # a hold of 15 s, whatever the rounding of its times
    first = int(np.searchsorted(time, time[0] + held / 3.0))
    t, x = time[first:], position[first:]
    threshold = max(resolution * (1.0 + 1e-6), 2.0 * noise_floor(x))
    turns = turning_points(x, threshold)
    if len(turns) >= (LEAST_TURNS if held > least else MANY_TURNS) and _kept_up(t, x, turns):
        return LimitCycle(0.5 * float(np.ptp(x[turns[-min(3, len(turns))] :])), _period(t[turns]))
    if held <= least:
        return LimitCycle(
            None,
            reason=f"held for {held:.3g} s only; a limit cycle is told absent behind {LEAST_HOLD:g} s",
        )
    if float(np.ptp(x)) <= threshold or _has_ended(t, x, turns, threshold):
        return LimitCycle(0.0)
    still = "turns less and less" if len(turns) >= LEAST_TURNS else "does not turn twice"
    moved = f"moves by {float(np.ptp(x)):.3g} behind the first {held / 3.0:.3g} s of the hold and {still}"
    return LimitCycle(None, reason=f"{moved}; a longer hold tells whether it cycles")


def _kept_up(time: NDArray[np.float64], position: NDArray[np.float64], turns: list[int]) -> bool:
    last = position[turns[-1] :]
    furthest = float(last[np.argmax(np.abs(last - last[0]))])
    swings = np.abs(np.diff([*position[turns], furthest]))
    between = float(np.max(np.diff(time[turns])))
    return (
        bool(np.max(swings[-2:]) >= KEPT_UP * np.max(swings[:2]))
        and float(time[-1] - time[turns[-1]]) <= OVERDUE * between
    )


def _has_ended(
    time: NDArray[np.float64], position: NDArray[np.float64], turns: list[int], threshold: float
) -> bool:
    if len(turns) < LEAST_TURNS:
        return False
    half = int(np.searchsorted(time, 0.5 * (time[0] + time[-1])))
    waited = float(time[-1] - max(time[turns[-1]], time[half]))
    return float(np.ptp(position[half:])) <= threshold and waited > OVERDUE * float(
        np.max(np.diff(time[turns]))
    )


def _period(times: NDArray[np.float64]) -> float:
    """Mean time between turns of one side; twice the time between two turns where there are no
    more."""
    if times.size == 2:
        return 2.0 * float(times[1] - times[0])
    return float(np.mean(times[2:] - times[:-2]))
