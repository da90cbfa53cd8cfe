"""Feedforward: the drive that moves the modelled axis along its reference, added before the limit.

    u = J a + sigma_v v + F_c sign(v)        in units of the drive, within its limit

    sign(v)   +1 or -1 from |v| > on; kept until |v| < off or v has turned; 0 there

The two speeds are a hysteresis around zero: a reference that creeps or rests asks for no Coulomb
friction, and its noise does not switch the drive to and fro.

v and a are means over the sample in which the drive acts. A prefilter or a profile with the
position f and the speed v at each sample moves by T/2 (v[k-1] + v[k]) between f[k-1] and f[k]; the
acceleration is (v[k] - v[k-1])/T. The drive computed from it acts after the delay of the target, so
that the loop compares the position with f, 1 + delay samples before (`delayed`). Property: without
friction that differs from the model, the feedback sees no error.

Feedforward and profile are outside the feedback loop: no margin depends on them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictool.control.program import Program, ProgramNode


class FeedforwardGains(NamedTuple):
    """Drive per unit of acceleration and of speed, and the drive of the Coulomb friction.

    `on`, `off`: speeds [per s] at which the Coulomb friction is switched; off < on.
    """

    inertia: float
    viscous: float
    coulomb: float
    on: float
    off: float


def sample_motion(
    program: Program, speed: ProgramNode, period: float
) -> tuple[ProgramNode, ProgramNode]:
    """Return mean speed and acceleration over the sample that ends with `speed`.

    `speed` is that of a prefilter or a profile, whose state is `filtered_speed_before`.
    """
    program.block("motion of the filtered reference over one sample")
    before = program.states["filtered_speed_before"]
    mean = program.constant(0.5) * (speed + before)
    return mean, program.constant(1.0 / period, "per_period") * (speed - before)


def delayed(program: Program, samples: float) -> ProgramNode:
    """Return the filtered reference as it was `samples` >= 1 samples ago, between two if needed."""
    program.block("filtered reference at the time at which the feedforward has moved the axis")
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
    """Return the drive [A | V] for a mean speed and acceleration, at most `most`."""
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
