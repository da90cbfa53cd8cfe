"""Systems for python-control, which frictool does not need by itself and imports here only."""

from __future__ import annotations

from typing import Any

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.plant.lti import Lti
from frictool.systems.views import DRIVE, ETA, POSITION, controller_system, plant_system


def to_control(system: Lti | Model | Controller) -> Any:
    """A `control.StateSpace`: of a controller what runs (sampled, eta to drive), of a model its axis (continuous, drive to position).

    Raises ImportError that says how to install python-control where it is missing.
    """
    try:
        import control
    except ImportError as error:
        raise ImportError("to_control needs python-control: pip install control") from error
    names: dict[str, Any] = {}
    if isinstance(system, Controller):
        found, names = controller_system(system), {"inputs": [ETA], "outputs": [DRIVE], "name": system.name}
    elif isinstance(system, Model):
        found, names = plant_system(system), {"inputs": [DRIVE], "outputs": [POSITION], "name": system.name}
    else:
        found = system
    return control.ss(found.a, found.b, found.c, found.d, found.period, **names)
