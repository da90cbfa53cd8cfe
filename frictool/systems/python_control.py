"""Conversion to python-control, an optional dependency that is imported only here."""

from __future__ import annotations

from typing import Any

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.plant.lti import Lti
from frictool.systems.document_systems import DRIVE, ETA, POSITION, as_linear_system


def to_control(system: Lti | Model | Controller) -> Any:
    """Return a `control.StateSpace` of a controller, a model or a system.

    Parameters
    ----------
    system : Lti, Model or Controller
        A controller gives its sampled linear controller (eta to drive [A | V]), a model its axis in
        continuous time (drive [A | V] to position [rad | m]).

    Returns
    -------
    control.StateSpace
        The system; inputs and outputs of a document are named.

    Raises
    ------
    FrictoolError
        If `system` has another type.
    ImportError
        If python-control is not installed; the message says how to install it.
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
