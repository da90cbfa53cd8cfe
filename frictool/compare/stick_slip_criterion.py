"""Stick-slip (thesis 3.7.2): number of sticks and their period, compared with Stribeck's law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.compare.trajectory import LawTrajectory

STICKS_MISSING = 1  # largest number of missing stick phases; the exact law has 9 with table 3.1
PERIOD_TOLERANCE = 0.02  # largest relative difference of the periods


@dataclass(frozen=True)
class StickSlipResult:
    """Measures of stick-slip.

    - sticks: number of stick phases that end in a breakaway
    - first_breakaway_s: time of the first breakaway; None without a breakaway
    - period_s, jump: mean time and mean distance from one stick to the next; None for fewer than
      two sticks
    - stuck_share: fraction of the time in which the speed is below the Stribeck velocity
    - top_speed: largest speed, m/s | rad/s
    """

    sticks: int
    first_breakaway_s: float | None
    period_s: float | None
    jump: float | None
    stuck_share: float
    top_speed: float

    def verdict(self, reference: StickSlipResult) -> str:
        """Return `+` or `-` by comparison with the Stribeck law, simulated event by event.

        The symbol is `+` in two cases:

        - the two periods differ by at most 2 %, and this law has at most one stick less
        - both laws have at most one stick
        """
        if self.period_s is None or reference.period_s is None:
            return "+" if self.period_s == reference.period_s else "-"
        close = abs(self.period_s / reference.period_s - 1.0) <= PERIOD_TOLERANCE
        return "+" if close and self.sticks >= reference.sticks - STICKS_MISSING else "-"


def measure(run: LawTrajectory, slow: float) -> StickSlipResult:
    """Return the stick-slip measures of a mass that is pulled from rest.

    `slow`: Stribeck velocity [m/s | rad/s].
    """
    end = float(run.time[-1])
    complete = [phase for phase in run.sticks if phase[1] < end]
    breakaways = np.array([phase[1] for phase in complete])
    rests = np.array([run.at(0.5 * (begin + stop)) for begin, stop in run.sticks])
    repeats = breakaways.size >= 2
    return StickSlipResult(
        sticks=len(complete),
        first_breakaway_s=float(breakaways[0]) if breakaways.size else None,
        period_s=float(np.diff(breakaways).mean()) if repeats else None,
        jump=float(np.diff(rests).mean()) if repeats else None,
        stuck_share=float(np.mean(np.abs(run.velocity) < slow)),
        top_speed=float(np.abs(run.velocity).max()),
    )
