"""Estimates of velocity, friction and wear along a log, each with an interval at every sample.

    MotionBlock ──wear/──▶ WearEstimate after each move ─┐
                ──velocity.py──▶ velocity ───────────────┴─friction_tracker.py──▶ friction

The estimates are causal. A move is the motion from one rest or reversal to the next. The wear
estimate changes only at the end of a move; before the end of the first move, the estimate is the
prior.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.log import MAIN_TOPIC
from frictool.logs.stream_source import SampleBlock
from frictool.observe.friction_tracker import UNBOUNDED, FrictionTracker, estimate_starts
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import ObserverOutput
from frictool.observe.second_observer import SecondObserver
from frictool.observe.wear_estimate import WearEstimate
from frictool.typing import Matrix, Vector

ESTIMATED = ("velocity", "friction", "wear")
FIELDS = ("position", *(name + end for name in ESTIMATED for end in ("", "_low", "_high")))


class WearEstimation(Protocol):
    """Interface of a wear estimator (wear/)."""

    @property
    def estimate(self) -> WearEstimate:
        """Return the estimate of the wear after the samples that have been processed."""
        ...

    def take(self, piece: MotionBlock) -> list[WearEstimate]:
        """Process a block of samples; return an estimate for each move that ended in the block."""
        ...

    def finish(self) -> list[WearEstimate]:
        """End the last move; return a list with its estimate, or [] if no move is unfinished."""
        ...


class VelocityEstimation(Protocol):
    """Interface of a velocity estimator (velocity.py)."""

    def take(self, piece: MotionBlock) -> Matrix:
        """Process a block; return the velocity (3, n) [rad/s | m/s]: value, lower, upper bound."""
        ...

    def figures(self) -> dict[str, Any]:
        """Return the velocity errors (SI) up to now, by name, including `velocity_rms`."""
        ...


@dataclass(frozen=True)
class EstimateBlock:
    """Estimates at the samples of a block.

    - piece: block of samples of the log
    - velocity [rad/s | m/s], friction [N m | N], wear [1]: (3, n), with the rows value, lower and
      upper bound
    - second: output of an additional observer; None if there is no such observer
    """

    piece: MotionBlock
    velocity: Matrix
    friction: Matrix
    wear: Matrix
    second: ObserverOutput | None = None

    def samples(self) -> SampleBlock:
        """Return samples and estimates as columns with the names FIELDS."""
        time = np.rint(self.piece.time * NS).astype(np.int64)
        return SampleBlock(time, (self.piece.position, *self.velocity, *self.friction, *self.wear))


def head(model: Model) -> StreamHeader:
    """Return the names and units of the columns of `EstimateBlock.samples`."""
    dimension = {"velocity": "velocity", "friction": "effort"}
    units = {name: si_unit(of, model.axis) for name, of in dimension.items()} | {"wear": "1"}
    return StreamHeader(
        MAIN_TOPIC,
        FIELDS,
        (si_unit("position", model.axis), *(units[name] for name in ESTIMATED for _ in range(3))),
    )


def estimate_along(
    pieces: Iterable[MotionBlock],
    model: Model,
    wear: WearEstimation,
    velocity: VelocityEstimation,
    confidence: float,
    second: SecondObserver | None = None,
) -> Iterator[EstimateBlock]:
    """Yield the estimates of friction, velocity and wear for each block of samples.

    `second` is an additional observer, whose output is part of the blocks.
    """
    friction = FrictionTracker(model, confidence)
    for piece in pieces:
        before = wear.estimate
        known = estimate_starts(piece, before, wear.take(piece))
        speeds = velocity.take(piece)
        other = None if second is None else second.take(piece)
        yield EstimateBlock(
            piece, speeds, friction.take(piece, speeds, known), _wear(piece.time, known), other
        )


def _wear(time: Vector, known: list[tuple[int, WearEstimate]]) -> Matrix:
    """Return value, lower and upper bound (3, n) of the wear at each sample of a block.

    `known` contains pairs (index of a sample, wear estimate that applies from this sample).
    """
    counts = np.diff([*(start for start, _ in known), time.size])
    values = np.array(
        [[one.wear.value, one.wear.low, min(one.wear.high, UNBOUNDED)] for _, one in known]
    )
    return np.repeat(values, counts, axis=0).T
