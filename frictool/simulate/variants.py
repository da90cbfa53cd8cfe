"""The plants that a scenario is played to: the model itself, and each vertex at which the controller was verified."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.errors import FrictoolError
from frictool.logs.log import MAIN_TOPIC
from frictool.plant.axis import AxisParameters
from frictool.plant.axis_model import axis_of


@dataclass(frozen=True)
class Variant:
    """One plant, `name` empty for the nominal one; `topic` is that of its stream."""

    name: str
    axis: AxisParameters

    @property
    def topic(self) -> str:
        """`/axis`, or `/axis/NAME`."""
        return f"{MAIN_TOPIC}/{self.name}" if self.name else MAIN_TOPIC


def variants_of(model: Model, controller: Controller, scenario: Scenario, owner: str = "model") -> list[Variant]:
    """The nominal plant, then the controller's vertices where the scenario asks for them.

    At a vertex inertia, viscous, coulomb and constant are the vertex's; the breakaway keeps its ratio to the Coulomb friction.
    `owner` is what messages call the model. Raises FrictoolError where a plant's parameters are out of range.
    """
    found = [Variant("", _axis(owner, model))]
    if scenario.variants == "vertices":
        for vertex in controller.verified.vertices:
            values = {key: getattr(vertex, key) for key in ("inertia", "viscous", "coulomb", "constant")}
            found.append(Variant(vertex.name, _axis(f"{owner} at vertex {vertex.name}", model, **values)))
    return found


def _axis(owner: str, model: Model, **values: float) -> AxisParameters:
    try:
        return axis_of(model, **values)
    except ValueError as error:
        raise FrictoolError(f"{owner}: {error}") from None
