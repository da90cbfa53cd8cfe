"""Conversion to scipy.signal."""

from __future__ import annotations

from typing import Any

from scipy import signal

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.plant.lti import Lti
from frictool.systems.document_systems import as_linear_system


def to_scipy(system: Lti | Model | Controller) -> Any:
    """Return a `scipy.signal.StateSpace` of a controller, a model or a system.

    Parameters
    ----------
    system : Lti, Model or Controller
        A controller gives its sampled linear controller, a model its axis in continuous time, as in
        `to_control`.

    Returns
    -------
    scipy.signal.StateSpace
        The system, with `dt` [s] if it is sampled.

    Raises
    ------
    FrictoolError
        If `system` has another type.
    """
    found = as_linear_system(system)
    matrices = (found.a, found.b, found.c, found.d)
    return (
        signal.StateSpace(*matrices, dt=found.period)
        if found.period
        else signal.StateSpace(*matrices)
    )
