"""The switched observers once more, in plain Python, read beside (6.4) and (6.22): slow, and equal
to the program bit by bit."""

from __future__ import annotations

import numpy as np

from frictool.documents.observer import Mode, Observer
from frictool.typing import Vector


class PlainObserver:
    """X-hat = (theta, omega, alpha) from rest at a position."""

    def __init__(self, observer: Observer, position: float) -> None:
        self.document = observer
        assert observer.switched is not None
        self.own = observer.switched
        self.theta, self.omega = position, 0.0
        self.alpha = 1.0 if self.own.wear == "multiplicative" else 0.0
        self.alphas = self.bounds()

    def bounds(self) -> tuple[float, float]:
        """alpha in [0, 3], or f + alpha from 0 to 3 f of the largest f."""
        if self.own.wear == "multiplicative":
            return 0.0, 3.0
        known = self.document.friction
        grid = np.linspace(known.over.low, known.over.high, 257)
        largest = max(
            float(np.max(np.polynomial.Polynomial(curve)(grid)))
            for curve in (known.forward, known.backward)
        )
        return -largest, 2.0 * largest

    def mode(self) -> Mode:
        """Mode 0 below Sigma, else the cell of the direction; the outermost cells hold beyond the
        travel too."""
        if abs(self.omega) < self.own.switch_speed.value:
            return next(mode for mode in self.own.modes if mode.direction == 0)
        direction = 1 if self.omega > 0.0 else -1
        cells = sorted(
            (mode for mode in self.own.modes if mode.direction == direction),
            key=lambda mode: mode.over or (0.0, 0.0),
        )
        inside = [
            mode for mode in cells[:-1] if mode.over is not None and self.theta < mode.over[1]
        ]
        return inside[0] if inside else cells[-1]

    def friction(self, mode: Mode) -> float:
        """alpha f_m(i), or f-hat + alpha; of omega's sign."""
        if mode.direction == 0:
            return 0.0
        if self.own.wear == "multiplicative":
            size = self.alpha * mode.friction
        else:
            known, x = self.document.friction, self.theta
            x = min(max(x, known.over.low), known.over.high)
            size = 0.0
            for coefficient in reversed(known.forward if mode.direction > 0 else known.backward):
                size = size * x + coefficient
            size = size + self.alpha
        return size if mode.direction > 0 else -size

    def step(self, position: float, effort: float) -> tuple[float, float, float, float]:
        """Return theta, omega, F and alpha at this sample; compute the next X-hat."""
        mode, period, known = self.mode(), self.document.sample_period_s, self.document.friction
        friction, error = self.friction(mode), position - self.theta
        found = self.theta, self.omega, friction, self.alpha
        gains = [row[0] for row in mode.gains]
        theta = self.theta + period * self.omega + gains[0] * error
        if mode.direction == 0:
            self.omega = self.own.stuck_speed * self.omega + gains[1] * error
        else:
            push = effort - friction
            push = push - known.viscous * self.omega if known.viscous else push
            push = push - known.offset if known.offset else push
            self.omega = self.omega + period / self.document.inertia.value * push + gains[1] * error
            self.alpha = min(max(self.alpha + gains[2] * error, self.alphas[0]), self.alphas[1])
        self.theta = theta
        return found

    def run(self, positions: Vector, efforts: Vector) -> Vector:
        """(n, 4) of positions and efforts (n,)."""
        return np.array(
            [self.step(float(y), float(u)) for y, u in zip(positions, efforts, strict=True)]
        )
