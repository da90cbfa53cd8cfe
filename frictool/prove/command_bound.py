"""Bound of the controller's command that is valid for every plant and every start.

The output of a controller program (adapters/controller_composition.py) is 0, or a drive that
`drive_limit.limit` has clipped. In every number format, |command| is therefore at most the stored
drive limit, for every sequence of readings. NaN would be an exception, and operations on infinite
numbers can return NaN. The bound is therefore claimed only if every state of the program has a
finite range. In fixed point, the interval of each word is proved (control/fixed_point.py).
"""

from __future__ import annotations

import math

import numpy as np

from frictool.adapters.controller_composition import controller_program
from frictool.control.fixed_point import fixed_program
from frictool.documents.controller import Controller, ProgramNumber


def command_bound(controller: Controller, number: ProgramNumber) -> float:
    """Return a bound of |command| [A | V] for every plant and start; infinity if none is proved."""
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
