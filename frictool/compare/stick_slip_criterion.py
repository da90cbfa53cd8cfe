"""Stick-slip (3.7.2): how often the mass sticks, how far it jumps, and whether it does so as the
event-exact reference does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.compare.trajectory import LawTrajectory

STICKS_MISSING = 1  # of 9 with table 3.1: at least 8
PERIOD_TOLERANCE = 0.02


@dataclass(frozen=True)
class StickSlipResult:
    """`sticks`: phases of stick that end in a breakaway. Period and jump are means; None where
    there are fewer than two.

    `stuck_share`: of the time, below the Stribeck velocity.
    """

    sticks: int
    first_breakaway_s: float | None
    period_s: float | None
    jump: float | None
    stuck_share: float
    top_speed: float

    def verdict(self, reference: StickSlipResult) -> str:
        """`+`: sticks as often as the event-exact law, but for one, and with its period within 2 %;
        or neither sticks again. Else `-`."""
        if self.period_s is None or reference.period_s is None:
            return "+" if self.period_s == reference.period_s else "-"
        close = abs(self.period_s / reference.period_s - 1.0) <= PERIOD_TOLERANCE
        return "+" if close and self.sticks >= reference.sticks - STICKS_MISSING else "-"


def measure(run: LawTrajectory, slow: float) -> StickSlipResult:
    """The figures of a pulled mass that starts at rest; `slow`: the Stribeck velocity [m/s |
    rad/s]."""
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
