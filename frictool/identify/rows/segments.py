"""Segments of records and their initial states; each segment is simulated without a restart."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from frictool.identify.motion_record import MotionRecord
from frictool.plant.axis import VELOCITY, rest
from frictool.typing import Vector

T = TypeVar("T")

FEWEST_SAMPLES = 50
COUNTS_OF_A_START = 10.0  # least distance from which the initial speed is computed, in counts
LONGEST_START = 50  # largest number of samples from which the initial speed is computed
START_SHARE = 0.1  # share of the top speed; a slower axis starts from rest


@dataclass(frozen=True)
class RecordSegment:
    """Samples [first, last) of a record, with no gap between them."""

    record: MotionRecord
    first: int
    last: int

    @property
    def position(self) -> Vector:
        """Return the measured position (n,), rad | m."""
        return self.record.position[self.first : self.last]

    @property
    def effort(self) -> Vector:
        """Return the measured effort (n,), N m | N."""
        return self.record.effort[self.first : self.last]

    @property
    def reference(self) -> Vector | None:
        """Return the reference of the controller (n,), rad | m, or None if it was not logged."""
        return (
            None if self.record.reference is None else self.record.reference[self.first : self.last]
        )

    def start(self) -> Vector:
        """Return the initial state (7,) of the axis (plant/axis.py).

        The axis starts in motion if the encoder shows a sufficient speed, else at rest.
        """
        position = self.position
        period = self.record.period
        state = np.asarray(rest(float(position[0])))
        passed = np.flatnonzero(
            np.abs(position[: LONGEST_START + 1] - position[0])
            >= COUNTS_OF_A_START * self.record.resolution
        )
        if passed.size:
            within = int(passed[0])
            velocity = float(position[within] - position[0]) / (within * period)
            top = float(np.max(np.abs(position[within:] - position[:-within]))) / (within * period)
            state[VELOCITY] = velocity if abs(velocity) > START_SHARE * top else 0.0
        return state


def gap_free_segments(records: Sequence[MotionRecord]) -> list[RecordSegment]:
    """Return every gap-free part of the records with at least FEWEST_SAMPLES samples."""
    segments = []
    for record in records:
        edges = np.concatenate(
            ([0], np.flatnonzero(np.diff(record.piece)) + 1, [record.position.size])
        )
        segments += [
            RecordSegment(record, int(a), int(b))
            for a, b in itertools.pairwise(edges)
            if b - a >= FEWEST_SAMPLES
        ]
    return segments


def thinned(segments: Sequence[RecordSegment], most: int) -> list[RecordSegment]:
    """Return evenly spaced, shortened segments with at most `most` samples in total.

    If all segments together have at most `most` samples, they are returned unchanged.
    """
    if sum(one.last - one.first for one in segments) <= most:
        return list(segments)
    wanted = float(np.mean([one.last - one.first for one in segments]))
    count = min(max(1, int(most / wanted)), len(segments))
    chosen = [segments[(2 * k + 1) * len(segments) // (2 * count)] for k in range(count)]
    return [replace(one, last=min(one.last, one.first + most // count)) for one in chosen]


def of_each_record(segments: Sequence[RecordSegment], what: Callable[[MotionRecord], T]) -> list[T]:
    """Return `what(record)` for the record of each segment; `what` is called once per record."""
    results: dict[int, T] = {}
    for segment in segments:
        if id(segment.record) not in results:
            results[id(segment.record)] = what(segment.record)
    return [results[id(segment.record)] for segment in segments]
