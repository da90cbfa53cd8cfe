"""Friction compensation: the modelled or observed friction, added to the drive.

    model      F = F_c s(v/v_s) + sigma_v v      s: control/saturation_function.py
               v: speed of the filtered reference, or measured speed
    observer   F' = L (K u - J v' - F)           in state form q = F + L J v,  q' = L (K u - F),
                                                 by Euler's method

This is the baseline that 5.1 argues against. It needs the sign of v near v = 0, which a coarse
encoder cannot provide. If the model has too much friction, the axis moves without a command. At
rest the observer integrates the effort, so that the axis breaks away, overshoots and hunts (5.1).
docs/theory/control.md compares its figures with those of the laws that use friction. Rule: L below
the bandwidth of the measured speed, v_s above the speed of one count per sample.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode
from frictool.control.saturation_function import saturating

REACH = 64.0  # bound of the observer's state in drive limits; includes the term L J v


def model_compensation(
    program: Program, speed: ProgramNode, coulomb: float, viscous: float, smoothing: float
) -> ProgramNode:
    """Return the drive [A | V] for the friction at a speed; `coulomb`, `viscous` in drive units."""
    program.block("friction compensation from the model")
    dry = program.constant(coulomb, "coulomb_drive") * saturating(
        program, program.constant(1.0 / smoothing, "per_smoothing_speed") * speed
    )
    return program.named("compensation", dry + program.constant(viscous, "viscous_drive") * speed)


def observer_compensation(
    program: Program, speed: ProgramNode, bandwidth: float, inertia: float, gain: float, most: float
) -> tuple[ProgramNode, ProgramNode]:
    """Return the drive [A | V] that is added, and the estimated friction in the same unit.

    inertia: drive per unit of acceleration. gain: part of the estimated friction that is added.
    most: largest friction, as a drive. `observe` updates the state once the drive is known.
    """
    program.block("friction compensation from a disturbance observer")
    carried = program.constant(bandwidth * inertia, "observer_inertia") * speed
    before = program.state("observed", -REACH * most, REACH * most)
    high = program.constant(most, "observer_limit")
    friction = program.named(
        "friction_found", program.smaller(program.larger(before - carried, -high), high)
    )
    return program.named(
        "compensation", program.constant(gain, "compensation_gain") * friction
    ), friction


def observe(
    program: Program, drive: ProgramNode, estimate: ProgramNode, bandwidth: float, period: float
) -> None:
    """Write the observer's update from the applied drive and the estimated friction `estimate`."""
    step = program.constant(bandwidth * period, "observer_step")
    program.update("observed", program.states["observed"] + step * (drive - estimate))
