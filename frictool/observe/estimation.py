"""Everything that is estimated along a log, sample by sample: velocity, friction, wear, each with
its interval.

    Piece ──wear/──▶ Estimate after each move ─┐
          ──velocity.py──▶ velocity ───────────┴─friction.py──▶ friction

What stands at a sample was known at that sample: wear changes when a move has ended, and before the
first move it is the prior.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.log import MAIN_TOPIC
from frictool.logs.stream_source import SampleBlock
from frictool.observe.estimate import WearEstimate
from frictool.observe.friction_tracker import UNBOUNDED, FrictionTracker, estimate_starts
from frictool.observe.motion_block import MotionBlock, Vector
from frictool.observe.observer_run import ObserverOutput
from frictool.observe.second_observer import SecondObserver

Matrix = NDArray[np.float64]
ESTIMATED = ("velocity", "friction", "wear")
FIELDS = ("position", *(name + end for name in ESTIMATED for end in ("", "_low", "_high")))


class WearEstimation(Protocol):
    """What estimates the wear (wear/). estimate: what is known now."""

    @property
    def estimate(self) -> WearEstimate: ...

    def take(self, piece: MotionBlock) -> list[WearEstimate]:
        """What is known after each move that ended in the piece."""
        ...

    def finish(self) -> list[WearEstimate]:
        """The log ends here."""
        ...


class VelocityEstimation(Protocol):
    """What estimates the velocity (velocity.py)."""

    def take(self, piece: MotionBlock) -> Matrix:
        """(3, n): value, low, high [rad/s | m/s]."""
        ...

    def figures(self) -> dict[str, Any]:
        """How well it did so far, by name, SI; `velocity_rms` among them."""
        ...


@dataclass(frozen=True)
class EstimateBlock:
    """What is known at the samples of a piece: velocity, friction and wear (3, n), each value, low,
    high; beside: by another observer."""

    piece: MotionBlock
    velocity: Matrix
    friction: Matrix
    wear: Matrix
    beside: ObserverOutput | None = None

    def samples(self) -> SampleBlock:
        """As they stand in the log, by FIELDS."""
        time = np.rint(self.piece.time * NS).astype(np.int64)
        return SampleBlock(time, (self.piece.position, *self.velocity, *self.friction, *self.wear))


def head(model: Model) -> StreamHeader:
    """The stream that `Part.samples` makes."""
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
    beside: SecondObserver | None = None,
) -> Iterator[EstimateBlock]:
    """What is known along the pieces, one after another."""
    friction = FrictionTracker(model, confidence)
    for piece in pieces:
        before = wear.estimate
        known = estimate_starts(piece, before, wear.take(piece))
        speeds = velocity.take(piece)
        other = None if beside is None else beside.take(piece)
        yield EstimateBlock(
            piece, speeds, friction.take(piece, speeds, known), _wear(piece.time, known), other
        )


def _wear(time: Vector, known: list[tuple[int, WearEstimate]]) -> Matrix:
    """Value, low, high at each sample (3, n)."""
    counts = np.diff([*(start for start, _ in known), time.size])
    values = np.array(
        [[one.wear.value, one.wear.low, min(one.wear.high, UNBOUNDED)] for _, one in known]
    )
    return np.repeat(values, counts, axis=0).T
