"""Bound of the command that is valid for every plant.

The output of a controller program (adapters/controller_composition.py) is 0, or a drive that
`drive_limit.limit` has clipped. In every number format, |command| is therefore at most the stored
drive limit, for every sequence of readings. An operation on infinite numbers could still return
NaN. It cannot occur if every state has a finite bound: the states of the linear controller are then
bounded, and the other states change by a finite value at each sample. In fixed point, the interval
of each word is proved (control/fixed_point.py).
"""

from __future__ import annotations

import math

import numpy as np

from frictool.adapters.controller_composition import controller_program
from frictool.control.fixed_point import fixed_program
from frictool.documents.controller import Controller, ProgramNumber


def command_bound(controller: Controller, number: ProgramNumber) -> float:
    """Return a bound of |command| [A | V] for every plant and start; infinity if there is none."""
    program = controller_program(controller)
    assert program.output is not None
    if any(math.isinf(one.low) or math.isinf(one.high) for one in program.states.values()):
        return math.inf
    if number == "double":
        return controller.drive_limit
    if number == "float":
        return float(np.float32(controller.drive_limit))
    scaled, output = fixed_program(program), program.output.index
    return math.ldexp(max(map(abs, scaled.words[output])), -scaled.fractions[output])
