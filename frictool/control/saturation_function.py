"""The saturating function that stands for tanh in (5.41): odd, smooth, monotone, made of products
and sums only.

    s(x) = t - 4/27 t^3,   t = x within +-3/2        slope 1 at 0, 1 and slope 0 from 3/2 on

It is one function in the simulation and on the target, where a library's tanh would be another in
its last bits. It lies above tanh by at most 0.113 of the final value (test), which is within what
v_r is known to.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode

CORNER = 1.5
CUBIC = 4.0 / 27.0


def saturating(program: Program, x: ProgramNode) -> ProgramNode:
    """s(x), in [-1, 1]."""
    corner = program.constant(CORNER, "saturating_corner")
    t = program.named("inside_corner", program.smaller(program.larger(x, -corner), corner))
    return t - program.constant(CUBIC, "saturating_cubic") * (t * (t * t))
