"""Everything that is estimated along a log, sample by sample: velocity, friction, wear, each with its interval.

    Piece ──wear/──▶ Estimate after each move ─┐
          ──velocity.py──▶ velocity ───────────┴─friction.py──▶ friction

What stands at a sample was known at that sample: wear changes when a move has ended, and before the first move it is the prior.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.logs.canonical.mcap_layout import NS, Head
from frictool.logs.flow import Samples
from frictool.logs.log import MAIN_TOPIC
from frictool.observe.along import Along
from frictool.observe.beside import Beside
from frictool.observe.estimate import Estimate
from frictool.observe.friction import UNBOUNDED, FrictionAlong, placed
from frictool.observe.samples import Piece, Vector

Matrix = NDArray[np.float64]
ESTIMATED = ("velocity", "friction", "wear")
FIELDS = ("position", *(name + end for name in ESTIMATED for end in ("", "_low", "_high")))


class Wear(Protocol):
    """What estimates the wear (wear/). estimate: what is known now."""

    @property
    def estimate(self) -> Estimate: ...

    def take(self, piece: Piece) -> list[Estimate]:
        """What is known after each move that ended in the piece."""
        ...

    def finish(self) -> list[Estimate]:
        """The log ends here."""
        ...


class Velocity(Protocol):
    """What estimates the velocity (velocity.py)."""

    def take(self, piece: Piece) -> Matrix:
        """(3, n): value, low, high [rad/s | m/s]."""
        ...

    def figures(self) -> dict[str, Any]:
        """How well it did so far, by name, SI; `velocity_rms` among them."""
        ...


@dataclass(frozen=True)
class Part:
    """What is known at the samples of a piece: velocity, friction and wear (3, n), each value, low, high; beside: by another observer."""

    piece: Piece
    velocity: Matrix
    friction: Matrix
    wear: Matrix
    beside: Along | None = None

    def samples(self) -> Samples:
        """As they stand in the log, by FIELDS."""
        time = np.rint(self.piece.time * NS).astype(np.int64)
        return Samples(time, (self.piece.position, *self.velocity, *self.friction, *self.wear))


def head(model: Model) -> Head:
    """The stream that `Part.samples` makes."""
    dimension = {"velocity": "velocity", "friction": "effort"}
    units = {name: si_unit(of, model.axis) for name, of in dimension.items()} | {"wear": "1"}
    return Head(MAIN_TOPIC, FIELDS, (si_unit("position", model.axis), *(units[name] for name in ESTIMATED for _ in range(3))))


def along(
    pieces: Iterable[Piece], model: Model, wear: Wear, velocity: Velocity, confidence: float, beside: Beside | None = None
) -> Iterator[Part]:
    """What is known along the pieces, one after another."""
    friction = FrictionAlong(model, confidence)
    for piece in pieces:
        before = wear.estimate
        known = placed(piece, before, wear.take(piece))
        speeds = velocity.take(piece)
        other = None if beside is None else beside.take(piece)
        yield Part(piece, speeds, friction.take(piece, speeds, known), _wear(piece.time, known), other)


def _wear(time: Vector, known: list[tuple[int, Estimate]]) -> Matrix:
    """Value, low, high at each sample (3, n)."""
    counts = np.diff([*(start for start, _ in known), time.size])
    values = np.array([[one.wear.value, one.wear.low, min(one.wear.high, UNBOUNDED)] for _, one in known])
    return np.repeat(values, counts, axis=0).T
