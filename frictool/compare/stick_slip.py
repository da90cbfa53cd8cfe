"""Stick-slip (3.7.2): how often the mass sticks, how far it jumps, and whether it does so as the event-exact reference does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.compare.trajectory import Trajectory

STICKS_NEEDED = 8
PERIOD_TOLERANCE = 0.02


@dataclass(frozen=True)
class StickSlip:
    """`sticks`: phases of stick that end in a breakaway. Period and jump are means; None where there are fewer than two.

    `stuck_share`: of the time, below the Stribeck velocity.
    """

    sticks: int
    first_breakaway_s: float | None
    period_s: float | None
    jump: float | None
    stuck_share: float
    top_speed: float

    def verdict(self, reference_period: float | None) -> str:
        """`+`: at least 8 sticks, and the period within 2 % of the event-exact one; `-` otherwise."""
        if self.sticks < STICKS_NEEDED or self.period_s is None or reference_period is None:
            return "-"
        return "+" if abs(self.period_s / reference_period - 1.0) <= PERIOD_TOLERANCE else "-"


def measure(run: Trajectory, slow: float) -> StickSlip:
    """The figures of a pulled mass that starts at rest; `slow`: the Stribeck velocity [m/s | rad/s]."""
    end = float(run.time[-1])
    complete = [phase for phase in run.sticks if phase[1] < end]
    breakaways = np.array([phase[1] for phase in complete])
    rests = np.array([run.at(0.5 * (begin + stop)) for begin, stop in run.sticks])
    repeats = breakaways.size >= 2
    return StickSlip(
        sticks=len(complete),
        first_breakaway_s=float(breakaways[0]) if breakaways.size else None,
        period_s=float(np.diff(breakaways).mean()) if repeats else None,
        jump=float(np.diff(rests).mean()) if repeats else None,
        stuck_share=float(np.mean(np.abs(run.velocity) < slow)),
        top_speed=float(np.abs(run.velocity).max()),
    )
