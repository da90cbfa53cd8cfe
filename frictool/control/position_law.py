"""Position laws of the cascade: the speed reference from the position error.

    square root    omega_c = k sqrt(|e|) sign(e)   outside the band   (5.19), (5.71), annex (5); k =
                   sqrt(2 F_c/J)
                           = k e/sqrt(band)        inside, its linear continuation
    proportional   omega_c = k e

Braked by friction alone, J omega' = -F_c, the axis that follows the square root arrives with speed
0 at e = 0 (5.5). With virtual friction k = sqrt(2 (F_c + F_cv)/J) (5.42): faster, and the drive has
to brake with F_cv. The text has 0 inside the band (5.19); here the law is followed there too until
the prefilter has settled and the band acts, linearly, since the root's infinite slope at zero would
turn each encoder count into a jump of the speed reference.

Known of it (proposition 5.2.2): for a speed loop that is infinitely faster the error decreases
outside the band and ends within it. With the loop's finite bandwidth the simulation has to tell;
the slope k/sqrt(band) of the linear continuation must stay well below it. Rule: k from the friction
that is surely there (the lower end of the map); the band at least some encoder steps.
"""

from __future__ import annotations

import math

from frictool.control.program import Program, ProgramNode


def square_root_law(
    program: Program, error: ProgramNode, gain: float, band: ProgramNode
) -> ProgramNode:
    """omega_c [per s] for a position error [rad | m]; odd, continuous."""
    program.block(
        "square-root law (5.19): the speed from which friction alone stops the axis at its target; linear inside the band"
    )
    k = program.constant(gain, "law_gain")
    size = program.named("error_size", abs(error))
    root = program.named("root", k * program.sqrt(size))
    inside = program.constant(gain / math.sqrt(band.value), "law_slope") * error
    outside = program.select(error < program.constant(0.0), -root, root)
    return program.named("wanted_speed", program.select(size > band, outside, inside))


def proportional_law(program: Program, error: ProgramNode, gain: float) -> ProgramNode:
    """omega_c [per s] for a position error [rad | m]."""
    program.block("proportional position law")
    return program.named("wanted_speed", program.constant(gain, "law_gain") * error)
