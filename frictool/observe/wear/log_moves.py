"""Moves of a log, each stored as the Gram matrix of its weak-form rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.adapters.temperature_factors import temperature_factors
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear import weak_form_rows
from frictool.observe.wear.weak_form_layout import WeakFormLayout
from frictool.typing import Matrix, Vector


@dataclass(frozen=True)
class Move:
    """Motion from one rest or reversal to the next.

    - gram: sum of row' row over the weak-form rows of the move, (p + 1, p + 1). The first p columns
      of a row are `WeakFormLayout.names`, the last column is the effort [N m | N].
    - rows: number of rows
    - time: time [s] of the last sample of the last row
    - direction: 1 or -1
    - speed: mean speed over the rows [rad/s | m/s]
    - excess: temperature at `time` minus the reference temperature of the model [K]; 0 if unknown
    """

    gram: Vector
    rows: int
    time: float
    direction: int
    speed: float
    excess: float = 0.0


class MoveCollector:
    """Collector of moves along a log; a few windows of samples and a Gram matrix are in memory."""

    def __init__(self, layout: WeakFormLayout) -> None:
        self.layout = layout
        self._columns = len(layout.names) + 1
        self._numbers = np.array(
            [
                layout.period,
                layout.slowest,
                layout.fastest,
                layout.gap,
                *layout.stops,
                layout.offset,
                0.5 * layout.count,  # an encoder reports the lower limit of the true position
            ]
        )
        self._state = np.zeros(weak_form_rows.STATE_SIZE)
        self._ring = np.zeros(
            (layout.knees.size + layout.falls.size + layout.zones, 2 * layout.window)
        )
        self._gram = np.zeros((self._columns, self._columns))
        self._move = np.zeros(weak_form_rows.MOVE_SIZE)
        self._time, self._position, self._effort, self._excess = (np.empty(0) for _ in range(4))
        self._warm = np.empty((2, 0))
        self._next = 0
        self._last = 0.0
        self._last_excess = 0.0
        weak_form_rows.forget(self._state, layout.gap)

    def take(self, piece: MotionBlock) -> list[Move]:
        """Process a block; return the moves that ended in the block, or at a gap before it."""
        ended: list[Move] = []
        if not piece.follows:
            ended = self.end()
        layout = self.layout
        excess, warm = _warmth(layout, piece)
        self._time, self._position, self._effort, self._excess = (
            np.concatenate([buffer, new])
            for buffer, new in (
                (self._time, piece.time),
                (self._position, piece.position),
                (self._effort, piece.effort),
                (self._excess, excess),
            )
        )
        self._warm = np.concatenate([self._warm, warm], axis=1)
        size = self._position.size
        behind = layout.window + layout.reach
        self._next = max(self._next, behind)
        while self._next < size - layout.reach:
            seen = self._move[weak_form_rows.LAST]
            start = self._next
            counted = self._state[weak_form_rows.SEEN]
            self._next = weak_form_rows.walk(
                self._position,
                self._effort,
                start,
                layout.every,
                layout.reach,
                self._state,
                self._ring,
                self._gram,
                self._move,
                layout.phi,
                layout.second,
                layout.effort,
                layout.knees,
                layout.falls,
                layout.edges,
                layout.axis,
                layout.load,
                self._numbers,
                self._warm,
            )
            if self._move[weak_form_rows.LAST] != seen:
                last = start + int(self._move[weak_form_rows.LAST] - counted) - 1
                self._last = float(self._time[last])
                self._last_excess = float(self._excess[last])
            if self._move[weak_form_rows.ENDED] > 0.0:
                ended += self._closed()
        kept = max(0, self._next - behind)
        self._time, self._position, self._effort, self._excess = (
            self._time[kept:],
            self._position[kept:],
            self._effort[kept:],
            self._excess[kept:],
        )
        self._warm = np.ascontiguousarray(self._warm[:, kept:])
        self._next -= kept
        return ended

    @property
    def sample_count(self) -> int:
        """Return the number of samples in memory."""
        return self._position.size

    def end(self) -> list[Move]:
        """End the current move; return [move], or [] if the move has no rows.

        A move ends at a gap and at the end of the log.
        """
        ended = self._closed()
        self._time, self._position, self._effort, self._excess = (np.empty(0) for _ in range(4))
        self._warm = np.empty((2, 0))
        self._next = 0
        weak_form_rows.forget(self._state, self.layout.gap)
        return ended

    def _closed(self) -> list[Move]:
        """End the current move and start the next; return [ended move], or [] if it has no rows."""
        count = int(self._move[weak_form_rows.ROWS])
        lower = self._gram
        gram = lower + np.tril(lower, -1).T
        move = Move(
            gram,
            count,
            self._last,
            int(self._move[weak_form_rows.SIDE]),
            float(self._move[weak_form_rows.SPEEDS]) / max(count, 1),
            self._last_excess,
        )
        self._gram = np.zeros((self._columns, self._columns))
        self._move = np.zeros(weak_form_rows.MOVE_SIZE)
        return [move] if count > 0 else []


def _warmth(layout: WeakFormLayout, piece: MotionBlock) -> tuple[Vector, Matrix]:
    """Return excess temperatures (n,) [K], and their factors (2, n) on viscous and dry friction."""
    law = layout.temperature
    if law is None or piece.temperature is None:
        return np.zeros(piece.time.size), np.ones((2, piece.time.size))
    factors = np.stack(temperature_factors(law, piece.temperature))
    return piece.temperature - law.reference.value, factors
