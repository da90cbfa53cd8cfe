"""Check of a controller with a model: intervals, bench, and margins at the model's corners."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.adapters.parameter_intervals import intervals
from frictool.documents.controller import Controller
from frictool.documents.missing_effects import refuse_sensor_lag, undeclared_ringing
from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.plant.polytope import PlantPoint, corner_points
from frictool.presentation.tie_rule import smallest
from frictool.verify.certified_intervals import model_differences
from frictool.verify.feedback_loops import feedbacks_of
from frictool.verify.resonant_loop import ResonantCheck, resonant_check
from frictool.verify.ringing_loop import RingingCheck, ringing_check
from frictool.verify.spring_loop import SpringCheck, spring_check


@dataclass(frozen=True)
class ModelCheck:
    """Result of the check of a controller with a model.

    - beyond: a phrase for each parameter or property of the bench that contradicts the verification
      of the controller (verify/certified_intervals.py)
    - plants: number of plants checked
    - margin, plant: the smallest modulus margin, and the plant with this margin
    - specified: specified modulus margin
    - resonant: margin with the model's resonances; None if the model has no resonances
    - sprung: margin with the model's spring; None if the model has no spring
    - ringing: margin on plants of two inertias; None if the model has no `ringing` or has
      resonances
    - outside_margins: names of the model's nonlinear effects, which no margin takes into account
    """

    beyond: tuple[str, ...]
    margin: float
    specified: float
    plant: PlantPoint
    plants: int
    resonant: ResonantCheck | None
    sprung: SpringCheck | None
    ringing: RingingCheck | None
    outside_margins: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Return True if `beyond` is empty and all margins are at least the required margin."""
        parts = [part.modulus_margin for part in (self.resonant, self.sprung) if part is not None]
        shown = self.ringing is None or self.ringing.shown
        return shown and not self.beyond and min([self.margin, *parts]) >= self.specified


def check_model(controller: Controller, model: Model) -> ModelCheck:
    """Return the margins of the controller's loops at the corners of the model's intervals.

    Each interval contains the parameter's range in the model's bench, and its interval in the model
    for all directions, speed regimes and positions (adapters/parameter_intervals.py). Raises
    FrictoolError if axis, drive, period, delay or time constant differ between the model's bench
    and the controller.
    """
    ours, theirs = controller.bench, model.bench
    refuse_sensor_lag(theirs, "margins and certificates are valid")
    pairs = {
        "axis": (ours.axis, theirs.axis),
        "drive": (ours.actuator.drive, theirs.actuator.drive),
        "sample_period_s": (ours.sample_period_s, theirs.sample_period_s),
        "delay_samples": (ours.delay_samples, theirs.delay_samples),
        "loop_time_constant_s": (
            ours.actuator.loop_time_constant_s,
            theirs.actuator.loop_time_constant_s,
        ),
    }
    for name, (expected, other) in pairs.items():
        if expected != other:
            raise FrictoolError(
                f"{name} is {other} in the model {model.name}, but {expected} in the controller "
                f"{controller.name}; run frictool synth again"
            )
    from frictool.verify.plant_margins import PlantMargins  # loads numba

    ranges = intervals(model)
    margins = PlantMargins(controller)
    points = corner_points(ranges)
    margin, index = smallest(margins.at(point) for point in points)
    specified = controller.verified.modulus_margin_specified
    resonant = None
    lag = ours.actuator.loop_time_constant_s
    if model.resonances is not None:
        resonant = resonant_check(
            feedbacks_of(controller), points, lag, controller.delay_samples, model.resonances
        )
    load = None if model.laws is None else model.laws.load
    sprung = None
    if load is not None and load.stiffness is not None:
        axis = lag, controller.delay_samples
        loops = feedbacks_of(controller)
        sprung = spring_check(loops, points, axis, load.stiffness, model.resonances)
    oscillation = undeclared_ringing(model)
    return ModelCheck(
        model_differences(controller, model),
        margin,
        specified,
        points[index],
        len(points),
        resonant,
        sprung,
        None if oscillation is None else ringing_check(controller, points, oscillation),
        outside_margins(model),
    )


def outside_margins(model: Model) -> tuple[str, ...]:
    """Return the names of a model's nonlinear effects, which no margin takes into account.

    The command `simulate` includes these effects.
    """
    mechanics = model.bench.mechanics
    laws = model.laws
    load = None if laws is None else laws.load
    parts = {
        "backlash": mechanics.backlash is not None and mechanics.backlash.value > 0.0,
        "end stops": mechanics.travel is not None,
        "winding": model.bench.actuator.winding is not None,
        "Stribeck curve": model.parameters.stribeck_velocity is not None,
        "friction over position": laws is not None and laws.position is not None,
        "dwell": laws is not None and laws.dwell is not None,
        "gravity": load is not None and load.gravity is not None,
        "ripple": load is not None and bool(load.ripples),
    }
    return ("dry friction", "drive limit", *(name for name, present in parts.items() if present))
