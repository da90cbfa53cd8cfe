"""Position laws of the cascade: the speed reference omega_c from the position error e.

    square root    omega_c = k sqrt(|e|) sign(e)   outside the band   thesis (5.19), (5.71)
                           = k e/sqrt(band)        inside, its linear continuation
                   with k = sqrt(2 F_c/J)
    proportional   omega_c = k e

F_c is the Coulomb friction, J the inertia, and `band` the half-width of a band around the target.
Friction alone decelerates the axis by F_c/J. An axis that follows the square root therefore arrives
at e = 0 with speed 0 (5.5). With virtual friction k = sqrt(2 (F_c + F_cv)/J) (5.42): the axis is
faster, and the drive has to brake with F_cv. In the thesis omega_c is 0 inside the band (5.19).
Here omega_c also follows the law inside the band, until the prefilter has settled and the band
releases the drive (control/target_band.py). The law is linear inside the band, because the infinite
slope of the root at e = 0 would turn each encoder count into a jump of omega_c.

Property (proposition 5.2.2): with an infinitely fast speed loop the error decreases outside the
band and ends within the band. With a finite bandwidth only simulation can show this; the slope
k/sqrt(band) must stay well below the bandwidth of the speed loop. k should be computed from the
lowest friction on the travel, and `band` should be some encoder steps.
"""

from __future__ import annotations

import math

from frictool.control.program import Program, ProgramNode


def square_root_law(
    program: Program, error: ProgramNode, gain: float, band: ProgramNode
) -> ProgramNode:
    """Return the speed reference omega_c [rad/s | m/s] for a position error e [rad | m].

    omega_c = gain sqrt(|e|) sign(e) outside the band |e| <= band [rad | m]. Inside, omega_c is
    linear in e, so that the law is odd and continuous.
    """
    program.block(
        "square-root law (5.19): the speed from which friction alone stops the axis at its "
        "target; linear inside the band"
    )
    k = program.constant(gain, "law_gain")
    size = program.named("error_size", abs(error))
    root = program.named("root", k * program.sqrt(size))
    inside = program.constant(gain / math.sqrt(band.value), "law_slope") * error
    outside = program.select(error < program.constant(0.0), -root, root)
    return program.named("wanted_speed", program.select(size > band, outside, inside))


def proportional_law(program: Program, error: ProgramNode, gain: float) -> ProgramNode:
    """Return the speed reference gain e [rad/s | m/s] for a position error e [rad | m]."""
    program.block("proportional position law")
    return program.named("wanted_speed", program.constant(gain, "law_gain") * error)
