"""Velocity range of a position, from differences that are large compared with one count."""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector

WINDOWS = (1, 2, 4, 8, 16, 32, 64, 128, 256)  # samples over which the position is differenced
RESOLVED = 0.01  # largest size of a count, relative to the longest distance over the window
SHARE_OF_LOG = 8  # the window is at most 1/SHARE_OF_LOG of the log


class VelocityRange:
    """Lowest and highest velocity of one position in rad/s or m/s, for each window length.

    step: encoder step in rad or m; None if the position is not quantised.
    """

    def __init__(self, step: float | None) -> None:
        self._step = step or 0.0
        self._samples = 0
        self._ways = dict.fromkeys(WINDOWS, 0.0)
        self._ranges = dict.fromkeys(WINDOWS, (np.inf, -np.inf))
        self._time: Vector = np.empty(0)
        self._position: Vector = np.empty(0)

    def take(self, time: Vector, position: Vector) -> None:
        """Add the next samples (n,): time in s, position in rad or m."""
        before = self._time.size
        self._samples += time.size
        time = np.concatenate((self._time, time))
        position = np.concatenate((self._position, position))
        for window in WINDOWS:
            first = max(before - window, 0)
            distance = position[first + window :] - position[first:-window]
            if distance.size:
                velocity = distance / (time[first + window :] - time[first:-window])
                low, high = self._ranges[window]
                self._ranges[window] = (
                    min(low, float(velocity.min())),
                    max(high, float(velocity.max())),
                )
                self._ways[window] = max(self._ways[window], float(np.abs(distance).max()))
        self._time, self._position = time[-WINDOWS[-1] :], position[-WINDOWS[-1] :]

    @property
    def window(self) -> int:
        """Return the length, in samples, of the shortest window that resolves the motion.

        If no window resolves the motion, return the longest window that the length of the log
        allows.
        """
        longest = max(1, self._samples // SHARE_OF_LOG)
        allowed: list[int] = [window for window in WINDOWS if window <= longest]
        return next(
            (window for window in allowed if self._step <= RESOLVED * self._ways[window]),
            allowed[-1],
        )

    @property
    def range(self) -> tuple[float, float] | None:
        """Return (lowest, highest) velocity over `window` samples; None for too few samples."""
        low, high = self._ranges[self.window]
        return (low, high) if low <= high else None
