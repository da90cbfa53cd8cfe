"""Mean torque or force of the drive until the next sample, for the observer of a controller.

    tau i' = u - i         u: delayed command, i: current after the lag of its loop
    mean of i over the period = u + (i - u) (1 - exp(-T/tau)) tau/T          exact for a constant u

tau is the time constant of the current loop, T the sample period.

The current is not measured. If the real current loop has a longer time constant, or if the supply
voltage drops, the observer treats the difference in torque as a disturbance.
"""

from __future__ import annotations

import math

from frictool.control.program import Program, ProgramNode


def mean_effort(
    program: Program,
    drive: ProgramNode,
    constant: float,
    bound: float,
    delay_samples: int,
    lag: float,
    period: float,
) -> ProgramNode:
    """Return the mean effort [N m | N] from this sample to the next.

    - drive: drive commanded at this sample [A | V]
    - constant: effort per unit of drive
    - bound: largest magnitude of the drive [A | V]
    - delay_samples: delay of the drive [samples]
    - lag: time constant tau of the current loop [s]
    - period: sample period T [s]
    """
    program.block("mean effort until the next sample, from the drive's delay and lag")
    acting = drive
    if delay_samples > 0:
        waiting = [program.state(f"commanded[{k}]", -bound, bound) for k in range(delay_samples)]
        for k, later in enumerate([*waiting[1:], drive]):
            program.update(f"commanded[{k}]", later)
        acting = waiting[0]
    mean = acting
    if lag > 0.0:
        left = math.exp(-period / lag)
        before = program.state("drive_before", -bound, bound)
        apart = program.named("drive_behind", before - acting)
        mean = acting + program.constant((1.0 - left) * lag / period, "drive_mean") * apart
        program.update("drive_before", acting + program.constant(left, "drive_left") * apart)
    return program.named("effort", program.constant(constant, "effort_per_drive") * mean)
