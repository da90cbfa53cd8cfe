"""Report of a reduction's step: changes, neglected effects, predicted and measured error."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple


class StepFigure(NamedTuple):
    """Number that a step of the reduction computed, in the SI unit `unit`."""

    name: str
    value: float
    unit: str


class MeasuredError(NamedTuple):
    """Difference between the positions of two mechanisms in the test runs.

    distance: largest difference of the positions at the sensor in the worst run [rad | m].
    travelled: distance that the axis travels in this run [rad | m].
    where: name of the worst run, the run with the largest quotient of `distance` and `travelled`.
    whole: largest difference from the whole mechanism in any run [rad | m].
    """

    distance: float
    travelled: float
    where: str
    whole: float

    @property
    def share(self) -> float:
        """Return `distance` divided by `travelled`."""
        return self.distance / self.travelled if self.travelled > 0.0 else 0.0


@dataclass(frozen=True)
class StepReport:
    """Report of one step.

    did: text on what the step changed.
    neglects: text on what the step neglects.
    predicted: relative error of the quantity `of`, computed in closed form; 0 if the step is exact.
    measured: difference from the mechanism before the step; None before the simulation.
    covered: quantity of the model whose interval includes the predicted error, so that only the
        measured error is checked; None if there is no such quantity.
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
