"""The saturating function that replaces tanh in thesis (5.41): odd, smooth and monotone.

    s(x) = t - 4/27 t^3,   t = x limited to +-3/2        slope 1 at 0; s = 1 and slope 0 from 3/2 on

Unlike tanh, s gives exactly the same result in simulation and on the target hardware. s exceeds
tanh by at most 0.113.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode

CORNER = 1.5
CUBIC = 4.0 / 27.0


def saturating(program: Program, x: ProgramNode) -> ProgramNode:
    """Return the node of the smooth saturation s(x), which lies in [-1, 1]."""
    corner = program.constant(CORNER, "saturating_corner")
    t = program.named("inside_corner", program.smaller(program.larger(x, -corner), corner))
    return t - program.constant(CUBIC, "saturating_cubic") * (t * (t * t))
