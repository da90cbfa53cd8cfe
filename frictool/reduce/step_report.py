"""What a step of a reduction tells of itself: what it did, what it neglects, the error that follows
and the one that was measured."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple


class StepFigure(NamedTuple):
    """A number that a step found, in SI."""

    name: str
    value: float
    unit: str


class MeasuredError(NamedTuple):
    """Two mechanisms under the same efforts: the worst distance between their positions at the
    sensor [SI], and the way that was made.

    where: which of the runs it was. whole: the same distance to the whole mechanism.
    """

    distance: float
    way: float
    where: str
    whole: float

    @property
    def share(self) -> float:
        """Of the way."""
        return self.distance / self.way if self.way > 0.0 else 0.0


@dataclass(frozen=True)
class StepReport:
    """One step. predicted: its error in closed form, relative to `of`; 0 where nothing is
    neglected. covered: what of the model holds that error, which then refuses nothing by itself:
    the measured one decides."""

    step: str
    did: str
    neglects: str
    predicted: float = 0.0
    of: str = "the way"
    figures: tuple[StepFigure, ...] = ()
    notes: tuple[str, ...] = ()
    measured: MeasuredError | None = field(default=None)
    covered: str | None = None
