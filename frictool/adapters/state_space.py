"""Conversion between the state space of a controller document and a linear system."""

from __future__ import annotations

import numpy as np

from frictool.documents.controller import StateSpace
from frictool.plant.lti import Lti


def read_state_space(document: StateSpace, period: float) -> Lti:
    """Return a state space of a document, with one input and one output, as a linear system.

    `period`: sample period [s]; 0 for continuous time.
    """
    n = len(document.a)
    a, b, c, d = (
        np.array(rows, dtype=np.float64)
        for rows in (document.a, document.b, document.c, document.d)
    )
    return Lti(a.reshape(n, n), b.reshape(n, 1), c.reshape(1, n), d, period)


def stored_state_space(system: Lti) -> StateSpace:
    """Return the matrices of a linear system as a document stores them."""
    a, b, c, d = (
        tuple(tuple(float(value) for value in row) for row in matrix)
        for matrix in (system.a, system.b, system.c, system.d)
    )
    return StateSpace(a, b, c, d)
