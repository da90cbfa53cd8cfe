"""The velocities that a position shows, through differences over so many samples that a count of the encoder matters little."""

from __future__ import annotations

import numpy as np

from frictool.logs.log import Vector

RESOLVED = 0.01  # one count over the window is at most this share of the top speed seen
LONGEST = 256  # samples
SHARE_OF_LOG = 8  # the window is no longer than one part in so many of the first block


class Speed:
    """Lowest and highest velocity of one position in rad/s | m/s, block after block; `window` is chosen from the first block."""

    def __init__(self, step: float | None) -> None:
        self._step = step or 0.0
        self.window: int | None = None
        self.low, self.high = np.inf, -np.inf
        self._time: Vector = np.empty(0)
        self._position: Vector = np.empty(0)

    def take(self, time: Vector, position: Vector) -> None:
        """Adds samples (n,) that follow those before: s, rad | m."""
        time, position = np.concatenate((self._time, time)), np.concatenate((self._position, position))
        if self.window is None:
            self.window = self._choose(time, position)
        if time.size > self.window:
            velocity = (position[self.window :] - position[: -self.window]) / (time[self.window :] - time[: -self.window])
            self.low, self.high = min(self.low, float(velocity.min())), max(self.high, float(velocity.max()))
        self._time, self._position = time[-self.window :], position[-self.window :]

    def _choose(self, time: Vector, position: Vector) -> int:
        window = 1
        while 2 * window <= min(LONGEST, time.size // SHARE_OF_LOG):
            moved = np.abs(position[window:] - position[:-window])
            if self._step <= RESOLVED * float(moved.max()):
                break
            window *= 2
        return window

    @property
    def range(self) -> tuple[float, float] | None:
        """(lowest, highest), or None where there are too few samples."""
        return (self.low, self.high) if self.low <= self.high else None
