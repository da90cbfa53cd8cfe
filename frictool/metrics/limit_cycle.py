"""Limit cycle: an oscillation that continues while the reference is held (thesis 5.2.1).

With dry friction the axis may rest for seconds until the integrator's output reaches the breakaway.
A hold (phase of constant reference) of one second may therefore show no motion although there is a
limit cycle. The first third of the hold is ignored, since it contains the response to the step. A
turn is a change of direction after which the axis moves back by more than the larger of one sensor
step and the peak-to-peak noise. A swing is the distance from a turn to the next.

    sustained      at least two turns (six turns in a hold of at most 15 s); the longer of the last
                   two swings is at least 0.8 times as long as the longer of the first two swings;
                   the time since the last turn is at most twice the longest time between two turns
    at rest        in a hold of more than 15 s: no motion beyond the noise; or no motion in the last
                   third of the hold, and this third is longer than twice the longest time between
                   two turns
    undecided      any other hold
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.metrics.drive_noise import noise_floor
from frictool.metrics.reversals import turning_points
from frictool.metrics.sample_durations import sample_durations
from frictool.typing import Vector

LEAST_HOLD = 15.0  # s, shortest hold in which a limit cycle can be ruled out
LEAST_TURNS = 2
MANY_TURNS = 6  # turns (three periods) that show a limit cycle in a hold of any length
SUSTAINED = 0.8  # least ratio of the last swings to the first swings
OVERDUE = 2.0  # largest time since the last turn, relative to the longest time between two turns


@dataclass(frozen=True)
class LimitCycle:
    """Result of the limit-cycle test of one hold (phase of constant reference).

    - amplitude: half the peak-to-peak position over the last period [rad or m]; 0 if there is no
      limit cycle; None if the test cannot decide, for example because the hold is too short
    - period: mean duration of one oscillation [s]; None if no limit cycle was detected
    - reason: why the test cannot decide, else empty
    """

    amplitude: float | None
    period: float | None = None
    reason: str = ""


def limit_cycle(time: Vector, position: Vector, resolution: float = 0.0) -> LimitCycle:
    """Return the result of the limit-cycle test of a hold (phase of constant reference).

    `time` [s] and `position` [rad or m] have shape (n,); `resolution` is the sensor's step.
    """
    duration = float(np.sum(sample_durations(time)))
    # half a sample of tolerance for the rounding of the times
    least = LEAST_HOLD - 0.5 * duration / time.size
    first = int(np.searchsorted(time, time[0] + duration / 3.0))
    t, x = time[first:], position[first:]
    threshold = max(resolution * (1.0 + 1e-6), 2.0 * noise_floor(x))
    turns = turning_points(x, threshold)
    if len(turns) >= (LEAST_TURNS if duration > least else MANY_TURNS) and _is_sustained(
        t, x, turns
    ):
        return LimitCycle(0.5 * float(np.ptp(x[turns[-min(3, len(turns))] :])), _period(t[turns]))
    if duration <= least:
        return LimitCycle(
            None,
            reason=f"the reference is held for {duration:.3g} s only; a limit cycle can be "
            f"excluded after {LEAST_HOLD:g} s",
        )
    if float(np.ptp(x)) <= threshold or _has_ended(t, x, turns, threshold):
        return LimitCycle(0.0)
    still = "swings less and less" if len(turns) >= LEAST_TURNS else "reverses at most once"
    moved = (
        f"moves by {float(np.ptp(x)):.3g} after the first {duration / 3.0:.3g} s of the hold and "
        f"{still}"
    )
    return LimitCycle(None, reason=f"{moved}; a longer hold shows whether this is a limit cycle")


def limit_cycle_amplitude(cycle: LimitCycle) -> float | str:
    """Return the amplitude [rad or m], 0 without a limit cycle, or the reason why it is unknown."""
    return cycle.reason if cycle.amplitude is None else cycle.amplitude


def limit_cycle_period(cycle: LimitCycle) -> float | str:
    """Return the period [s], or the reason why there is no period."""
    return (cycle.reason or "there is no limit cycle") if cycle.period is None else cycle.period


def _is_sustained(time: Vector, position: Vector, turns: list[int]) -> bool:
    last = position[turns[-1] :]
    furthest = float(last[np.argmax(np.abs(last - last[0]))])
    swings = np.abs(np.diff([*position[turns], furthest]))
    between = float(np.max(np.diff(time[turns])))
    return (
        bool(np.max(swings[-2:]) >= SUSTAINED * np.max(swings[:2]))
        and float(time[-1] - time[turns[-1]]) <= OVERDUE * between
    )


def _has_ended(time: Vector, position: Vector, turns: list[int], threshold: float) -> bool:
    if len(turns) < LEAST_TURNS:
        return False
    half = int(np.searchsorted(time, 0.5 * (time[0] + time[-1])))
    waited = float(time[-1] - max(time[turns[-1]], time[half]))
    return float(np.ptp(position[half:])) <= threshold and waited > OVERDUE * float(
        np.max(np.diff(time[turns]))
    )


def _period(times: Vector) -> float:
    if times.size == 2:
        return 2.0 * float(times[1] - times[0])
    return float(np.mean(times[2:] - times[:-2]))
