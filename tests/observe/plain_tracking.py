"""The tracking observer once more, in plain Python with branches, read beside
control/tracking_observer.py: slow."""

from __future__ import annotations

import math

import numpy as np

from frictool.control.tracking_observer import LEAST_EDGE, LEAST_SPEED, TrackingParameters
from frictool.typing import Vector


class PlainTracking:
    """From rest at a measured position, in the middle of the backlash."""

    def __init__(self, facts: TrackingParameters, position: float) -> None:
        self.facts, self.x, self.v, self.d, self.gap = facts, position, 0.0, 0.0, 0.0
        self.branches: set[str] = set()

    def step(self, position: float, effort: float) -> tuple[float, float, float]:
        """Return position, velocity and friction at this sample; compute the next state."""
        f = self.facts
        miss = position - self.x
        half = 0.5 * f.cell
        miss = miss - half if miss > half else miss + half if miss < -half else 0.0
        x, v, d = self.x + f.gains[0] * miss, self.v + f.gains[1] * miss, self.d
        if self.v != 0.0:
            d = d + f.gains[2] * miss
        v, d = _within(v, f.top_speed), _within(d, f.most_effort)
        if abs(v) < LEAST_SPEED * f.step / f.period:
            v = 0.0
        gap = _within(self.gap + f.gains[0] * miss, 0.5 * f.backlash)
        shown = x + 0.5 * f.step
        up, down = self.friction(shown, gap)
        seen = 0.0 if v == 0.0 else (up if v > 0.0 else -down) - d
        self.move(x, v, d, gap, up, down, effort)
        return shown, v, seen

    def friction(self, x: float, gap: float) -> tuple[float, float]:
        """Forward and backward, loose inside the backlash."""
        f = self.facts
        place = (
            min(max(x, f.travel[0]), f.travel[1]) if max(len(f.forward), len(f.backward)) > 1 else x
        )
        up, down = max(_polynomial(f.forward, place), 0.0), max(_polynomial(f.backward, place), 0.0)
        if f.backlash == 0.0:
            return up, down
        edge = 0.5 * f.backlash - max(LEAST_EDGE * f.backlash, min(f.step, 0.25 * f.backlash))
        self.branches.add("carried" if abs(gap) >= edge else "loose")
        return (up if gap >= edge else min(up, f.loose)), (
            down if gap <= -edge else min(down, f.loose)
        )

    def move(
        self, x: float, v: float, d: float, gap: float, up: float, down: float, effort: float
    ) -> None:
        """Move the state by the model to the next sample."""
        f, rate = self.facts, self.facts.period / self.facts.inertia
        drive = effort - f.offset if f.offset != 0.0 else effort
        push = drive + d
        if f.viscous != 0.0:
            push = push - f.viscous * v
        for speed, slope in f.knees:
            push = push - slope * (v - _within(v, speed))
        free, ratio = v + rate * push, f.breakaway if v == 0.0 else 1.0
        hold_up, hold_down = ratio * up, ratio * down
        if -(rate * hold_down) <= free <= rate * hold_up:
            self.branches.add("stays" if v == 0.0 else "stops")
            after = 0.0
            excess = drive - min(max(drive, -hold_down), hold_up)
            d = min(max(d, min(0.0, -excess)), max(0.0, -excess))
        else:
            self.branches.add("breaks away" if v == 0.0 else "slips")
            after = _within(free - rate * up if free > 0.0 else free - rate * -down, f.top_speed)
        way = 0.5 * f.period * (v + after)
        self.x, self.v, self.d, self.gap = x + way, after, d, _within(gap + way, 0.5 * f.backlash)

    def run(self, positions: Vector, efforts: Vector) -> Vector:
        """(n, 3)."""
        return np.array(
            [self.step(float(y), float(e)) for y, e in zip(positions, efforts, strict=True)]
        )


def _polynomial(powers: tuple[float, ...], x: float) -> float:
    total = powers[-1]
    for power in reversed(powers[:-1]):
        total = total * x + power
    return total


def _within(value: float, most: float) -> float:
    return value if math.isinf(most) else min(max(value, -most), most)
