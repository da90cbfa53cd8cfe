"""Systems for python-control, which frictool does not need by itself and imports here only."""

from __future__ import annotations

from typing import Any

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.plant.lti import Lti
from frictool.systems.document_systems import DRIVE, ETA, POSITION, as_linear_system


def to_control(system: Lti | Model | Controller) -> Any:
    """A `control.StateSpace`: of a controller what runs (sampled, eta to drive), of a model its
    axis (continuous, drive to position).

    Raises FrictoolError where it is none of these, ImportError that says how to install
    python-control where it is missing.
    """
    try:
        import control
    except ImportError as error:
        raise ImportError(
            "to_control needs python-control: pip install 'frictool[control]'"
        ) from error
    found, names = as_linear_system(system), dict[str, Any]()
    if isinstance(system, Controller):
        names = {"inputs": [ETA], "outputs": [DRIVE], "name": system.name}
    elif isinstance(system, Model):
        names = {"inputs": [DRIVE], "outputs": [POSITION], "name": system.name}
    return control.ss(found.a, found.b, found.c, found.d, found.period, **names)
