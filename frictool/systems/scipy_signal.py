"""Systems for scipy."""

from __future__ import annotations

from typing import Any

from scipy import signal

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.plant.lti import Lti
from frictool.systems.document_systems import as_linear_system


def to_scipy(system: Lti | Model | Controller) -> Any:
    """A `scipy.signal.StateSpace`, with `dt` where it is sampled: of a controller what runs, of a
    model its axis, as in `to_control`.

    Raises FrictoolError where it is none of these.
    """
    found = as_linear_system(system)
    matrices = (found.a, found.b, found.c, found.d)
    return (
        signal.StateSpace(*matrices, dt=found.period)
        if found.period
        else signal.StateSpace(*matrices)
    )
