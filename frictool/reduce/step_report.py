"""Report of a reduction's step: changes, neglected effects, predicted and measured error."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple


class StepFigure(NamedTuple):
    """Number that a step computed, in SI."""

    name: str
    value: float
    unit: str


class MeasuredError(NamedTuple):
    """Error of a mechanism relative to another one under the same commands.

    distance: largest difference of the two positions at the sensor [rad | m]. way: distance
    travelled in the run [rad | m]. where: name of the run. whole: largest difference from the whole
    mechanism [rad | m].
    """

    distance: float
    way: float
    where: str
    whole: float

    @property
    def share(self) -> float:
        """Return the error relative to the travelled distance."""
        return self.distance / self.way if self.way > 0.0 else 0.0


@dataclass(frozen=True)
class StepReport:
    """Report of one step.

    did, neglects: what the step changed and what it neglects, as text. predicted: error in closed
    form relative to the quantity `of`; 0 if nothing is neglected. covered: part of the model that
    includes this error, if any; then only the measured error is checked.
    """

    step: str
    did: str
    neglects: str
    predicted: float = 0.0
    of: str = "the distance"
    figures: tuple[StepFigure, ...] = ()
    notes: tuple[str, ...] = ()
    measured: MeasuredError | None = field(default=None)
    covered: str | None = None
