"""Feedforward: the drive that moves the model of the axis along its reference.

    u = J a + sigma_v v + F_c sign(v)        in units of the drive, within its limit

    sign(v)   becomes +1 or -1 if |v| > on; becomes 0 if |v| < off or v changes its sign

v and a are the speed and the acceleration of the reference, J the inertia, sigma_v the viscous
coefficient, and F_c the Coulomb friction. `on` and `off` form a hysteresis around zero: a reference
that creeps or rests causes no Coulomb term, and noise of the reference does not switch the Coulomb
term on and off. The feedforward is added to the drive before the limit.

Both v and a are means over the sample period T in which the drive acts. A prefilter or a profile
has the position f and the speed v at each sample, with f[k] - f[k-1] = T/2 (v[k-1] + v[k]); the
mean acceleration is (v[k] - v[k-1])/T. The drive computed from these means acts after the
computational delay. The loop therefore compares the measured position with f[k - 1 - delay samples]
(`delayed`). Property: if the axis equals the model, the position error is 0.

Feedforward and profile are outside the feedback loop: no margin depends on them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictool.control.program import Program, ProgramNode


class FeedforwardGains(NamedTuple):
    """Gains of the feedforward, in units of the drive [A | V].

    - inertia: drive per unit of acceleration [rad/s^2 | m/s^2]
    - viscous: drive per unit of speed [rad/s | m/s]
    - coulomb: drive that balances the Coulomb friction
    - on: speed [rad/s | m/s] above which the Coulomb term is switched on
    - off: speed [rad/s | m/s] below which the Coulomb term is switched off; smaller than `on`
    """

    inertia: float
    viscous: float
    coulomb: float
    on: float
    off: float


def sample_motion(
    program: Program, speed: ProgramNode, period: float
) -> tuple[ProgramNode, ProgramNode]:
    """Return the mean speed and mean acceleration of the reference over the last sample period.

    - speed: speed of the prefilter or profile at this sample
    - period: sample period [s]

    The state `filtered_speed_before` contains the speed one sample ago.
    """
    program.block("motion of the filtered reference over one sample")
    before = program.states["filtered_speed_before"]
    mean = program.constant(0.5) * (speed + before)
    return mean, program.constant(1.0 / period, "per_period") * (speed - before)


def delayed(program: Program, samples: float) -> ProgramNode:
    """Return the filtered reference delayed by `samples` >= 1, interpolated between samples."""
    program.block("filtered reference, delayed until the feedforward has moved the axis")
    whole = math.floor(samples)
    part = samples - whole
    first = program.states["filtered_before"]
    line = [first]
    for k in range(whole - 1 + (part > 0.0)):
        name = f"filtered_line[{k}]"
        line.append(program.state(name, first.low, first.high, start="position"))
        program.update(name, line[k])
    tracked = line[whole - 1]
    if part > 0.0:
        tracked = tracked + program.constant(part, "tracked_part") * (line[whole] - tracked)
    return program.named("tracked", tracked)


def feedforward(
    program: Program,
    speed: ProgramNode,
    acceleration: ProgramNode,
    gains: FeedforwardGains,
    most: float,
) -> ProgramNode:
    """Return the feedforward drive [A | V] for the reference's mean speed and acceleration.

    most: bound of the feedforward's magnitude [A | V].
    """
    program.block("feedforward of inertia and friction; the Coulomb friction with hysteresis")
    zero, one = program.constant(0.0), program.constant(1.0)
    on, off = program.constant(gains.on, "switch_on_speed"), gains.off
    before = program.state("friction_direction", -1.0, 1.0)
    moves_on = (abs(speed) >= program.constant(off, "switch_off_speed")) & (before * speed > zero)
    kept = program.select(moves_on, before, zero)
    direction = program.named(
        "friction_direction_now",
        program.select(speed > on, one, program.select(speed < -on, -one, kept)),
    )
    program.update("friction_direction", direction)
    drive = program.dot(
        [
            program.constant(value, name)
            for name, value in (
                ("feedforward_inertia", gains.inertia),
                ("feedforward_viscous", gains.viscous),
                ("feedforward_coulomb", gains.coulomb),
            )
        ],
        [acceleration, speed, direction],
    )
    high = program.constant(most, "drive_limit")
    return program.named("feedforward", program.smaller(program.larger(drive, -high), high))
