"""Check of a controller against a model: are the model's intervals inside the certificate's, and is the loop good at their corners?"""

from __future__ import annotations

from dataclasses import dataclass

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.plant.polytope import PlantPoint, corner_points, intervals
from frictool.ties import smallest
from frictool.verify.certified_box import parameters_outside
from frictool.verify.plant_margins import PlantMargins


@dataclass(frozen=True)
class ModelCheck:
    """Result of the check of a controller at the corners of a model.

    beyond: a phrase for each parameter outside the controller's intervals. margin: the smallest modulus margin, at `plant`.
    """

    beyond: tuple[str, ...]
    margin: float
    specified: float
    plant: PlantPoint
    plants: int

    @property
    def holds(self) -> bool:
        """Return whether the model lies within the controller's intervals, and its corners have the specified margin."""
        return not self.beyond and self.margin >= self.specified


def check_model(controller: Controller, model: Model) -> ModelCheck:
    """Compute the margins at the model's corners, from the hull of its intervals and of its bench's ranges.

    Raises
    ------
    FrictoolError
        If the model's bench has another axis, drive, period, delay or time constant than the controller's.
    """
    ours, theirs = controller.bench, model.bench
    pairs = {
        "axis": (ours.axis, theirs.axis),
        "drive": (ours.actuator.drive, theirs.actuator.drive),
        "sample_period_s": (ours.sample_period_s, theirs.sample_period_s),
        "delay_samples": (ours.delay_samples, theirs.delay_samples),
        "loop_time_constant_s": (ours.actuator.loop_time_constant_s, theirs.actuator.loop_time_constant_s),
    }
    for name, (own, other) in pairs.items():
        if own != other:
            raise FrictoolError(f"the model {model.name} has {name} {other}, the controller {controller.name} {own}; synthesise it anew")
    ranges, margins = intervals(model), PlantMargins(controller)
    points = corner_points(ranges)
    margin, index = smallest(margins.at(point) for point in points)
    specified = controller.verified.modulus_margin_specified
    return ModelCheck(parameters_outside(controller, ranges), margin, specified, points[index], len(points))
