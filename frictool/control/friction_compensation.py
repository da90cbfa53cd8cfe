"""Friction compensation, the baseline that 5.1 argues against: the friction's effort, modelled or
observed, added to the drive.

    model      F = F_c s(v/v_s) + sigma_v v      s: control/saturation_function.py; v the filtered
               reference's speed or the measured one
    observer   F' = L (K u - J v' - F)           in state form q = F + L J v,  q' = L (K u - F), by
               Euler's step

Known of it: it needs the sign of v near v = 0, which a coarse encoder cannot give. Modelled too
large it drives the axis by itself; an observer's is an integrator of the effort at rest, so that
the axis breaks away, overshoots and hunts (5.1). Its figures beside those of the laws that use
friction are in docs/theory/control.md. Rule: L below the bandwidth of the measured speed, v_s above
the speed of one count.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode
from frictool.control.saturation_function import saturating

REACH = 64.0  # of the observer's state, in limits of the drive: what the speed carries there


def model_compensation(
    program: Program, speed: ProgramNode, coulomb: float, viscous: float, smoothing: float
) -> ProgramNode:
    """Drive [A | V] of the friction at a speed; `coulomb`, `viscous` in drive units."""
    program.block("friction compensation from the model")
    dry = program.constant(coulomb, "coulomb_drive") * saturating(
        program, program.constant(1.0 / smoothing, "per_smoothing_speed") * speed
    )
    return program.named("compensation", dry + program.constant(viscous, "viscous_drive") * speed)


def observer_compensation(
    program: Program, speed: ProgramNode, bandwidth: float, inertia: float, gain: float, most: float
) -> tuple[ProgramNode, ProgramNode]:
    """The drive [A | V] that is added, and the friction that is found, in the same unit.

    inertia: in drive units per acceleration. most: what the friction is at most.
    The state moves by `observe`, once the drive is known.
    """
    program.block("friction compensation from a disturbance observer")
    carried = program.constant(bandwidth * inertia, "observer_inertia") * speed
    before = program.state("observed", -REACH * most, REACH * most)
    high = program.constant(most, "observer_limit")
    found = program.named(
        "friction_found", program.smaller(program.larger(before - carried, -high), high)
    )
    return program.named("compensation", program.constant(gain, "compensation_gain") * found), found


def observe(
    program: Program, drive: ProgramNode, found: ProgramNode, bandwidth: float, period: float
) -> None:
    """The observer's state at the next sample, from the drive that is applied and the friction
    found."""
    step = program.constant(bandwidth * period, "observer_step")
    program.update("observed", program.states["observed"] + step * (drive - found))
