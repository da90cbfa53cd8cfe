"""Limit cycles in a position loop with integral action (thesis 3.7.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.compare.trajectory import LawTrajectory
from frictool.typing import Vector

LASTING_NEEDED = 0.9  # least ratio of the amplitudes in the last and the second quarter of the run
PERIOD_TOLERANCE = 0.05  # largest relative difference of the periods


@dataclass(frozen=True)
class LimitCycleResult:
    """Measures of a limit cycle.

    - amplitude: half the peak-to-peak value of the position in the last quarter of the run
    - lasting: amplitude in the last quarter divided by the amplitude in the second quarter
    - period_s: mean time between upward crossings of the middle of the position's range, in the
      second half of the run; None if the cycle dies out
    """

    amplitude: float
    lasting: float
    period_s: float | None

    def verdict(self, reference: LimitCycleResult) -> str:
        """Return `+` or `-` by comparison with the Stribeck law, simulated event by event.

        The symbol is `+` in two cases:

        - the cycle lasts with both laws, and the two periods differ by at most 5 %
        - the cycle dies out with both laws
        """
        if self.period_s is None or reference.period_s is None:
            return "+" if self.period_s == reference.period_s else "-"
        return "+" if abs(self.period_s / reference.period_s - 1.0) <= PERIOD_TOLERANCE else "-"


def measure(run: LawTrajectory, still: float) -> LimitCycleResult:
    """Return the measures of a limit-cycle test.

    A motion with an amplitude below `still` [m | rad] is presliding, not a cycle.
    """
    end = float(run.time[-1])
    first = _half_range(run.position[run.between(0.25 * end, 0.5 * end)])
    last = _half_range(run.position[run.between(0.75 * end, end)])
    lasting = last / first if first > still else 0.0
    half = run.between(0.5 * end, end)
    cycles = (
        _period(run.time[half], run.position[half])
        if lasting > LASTING_NEEDED and last > still
        else None
    )
    return LimitCycleResult(last, lasting, cycles)


def _half_range(position: Vector) -> float:
    return 0.5 * float(position.max() - position.min())


def _period(time: Vector, position: Vector) -> float | None:
    """Return the mean time between upward crossings of the middle of the range of `position`.

    The result is None if there are fewer than two crossings.
    """
    offset = position - 0.5 * (position.max() + position.min())
    before = np.flatnonzero((offset[:-1] < 0.0) & (offset[1:] >= 0.0))
    if before.size < 2:
        return None
    share = offset[before] / (offset[before] - offset[before + 1])
    crossings = time[before] + share * (time[before + 1] - time[before])
    return float(np.diff(crossings).mean())
