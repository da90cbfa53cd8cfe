"""Friction compensation: the modelled or observed friction, added to the drive.

    model      F = F_c s(v/v_s) + sigma_v v      s: control/saturation_function.py
               v: speed of the filtered reference, or measured speed
    curve      F interpolated linearly over v, for a model with a Stribeck fall, a viscous
               coefficient that depends on v, or direction-dependent friction
    position   F + s(v/v_s) d(x)                 d: Coulomb friction at x minus its mean
    observer   F' = L (K u - J v' - F)           in state form q = F + L J v,  q' = L (K u - F),
                                                 by Euler's method

F is the friction, F_c its Coulomb part, sigma_v the viscous coefficient, and v_s a smoothing speed.
x is the position of the axis or of its reference. u is the drive, K the effort per unit of drive, J
the inertia, and L the observer's bandwidth.

Section 5.1 of the thesis argues against friction compensation. The model needs the sign of v near v
= 0, which a coarse encoder cannot provide. If the model has too much friction, the axis moves
without a command. At rest the observer integrates the effort, so that the axis breaks away,
overshoots and hunts. docs/theory/clutch.md compares this compensation with control laws that use
the friction to stop the axis. L should be below the bandwidth of the measured speed, and v_s above
the speed of one encoder count per sample.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from frictool.control.program import Program, ProgramNode
from frictool.control.saturation_function import saturating

REACH = 64.0  # bound of the observer's state q, relative to the drive's limit


def direction(program: Program, speed: ProgramNode, smoothing: float) -> ProgramNode:
    """Return s(v/v_s), a smooth transition from -1 to 1 in place of the sign of v.

    `smoothing`: speed v_s [rad/s | m/s].
    """
    return saturating(program, program.constant(1.0 / smoothing, "per_smoothing_speed") * speed)


def model_compensation(
    program: Program, speed: ProgramNode, coulomb: float, viscous: float, smoothing: float
) -> ProgramNode:
    """Return the drive [A | V] that balances the modelled friction at a speed.

    - coulomb, viscous: friction coefficients divided by the torque or force constant of the drive
    - smoothing: smoothing speed v_s [rad/s | m/s]
    """
    program.block("friction compensation from the model")
    dry = program.constant(coulomb, "coulomb_drive") * direction(program, speed, smoothing)
    return program.named("compensation", dry + program.constant(viscous, "viscous_drive") * speed)


def curve_compensation(
    program: Program, speed: ProgramNode, speeds: Sequence[float], drives: Sequence[float]
) -> ProgramNode:
    """Return the drive [A | V] that balances the friction at a speed, from a table.

    The curve is a sum of ramps, one for each interval of the table, and is extrapolated linearly
    beyond the table.

    Parameters
    ----------
    speeds : sequence of n floats
        Rising speeds [rad/s | m/s].
    drives : sequence of n floats
        Drive at each speed [A | V].
    """
    program.block("friction compensation from the curve of the model")
    return program.named("compensation", _table(program, speed, speeds, drives, "curve_speed"))


def position_compensation(
    program: Program,
    position: ProgramNode,
    direction: ProgramNode,
    positions: Sequence[float],
    forward: Sequence[float],
    backward: Sequence[float],
) -> ProgramNode:
    """Return the drive [A | V] that balances the change of the Coulomb friction over the position.

    Parameters
    ----------
    direction : ProgramNode
        s(v/v_s), from -1 to 1.
    positions : sequence of n floats
        Rising positions [rad | m]. Outside their range, the value at the nearest end is used.
    forward, backward : sequences of n floats
        Drive [A | V] that balances (Coulomb friction at each position) - (mean Coulomb friction),
        in the positive and in the negative direction.
    """
    program.block("change of the friction compensation over the position")
    first, last = (
        program.constant(positions[k], f"forward_position_{k % len(positions)}") for k in (0, -1)
    )
    inside = program.smaller(program.larger(position, first), last)
    zero = program.constant(0.0)
    if tuple(forward) == tuple(backward):
        change = direction * _table(program, inside, positions, forward, "forward_position")
    else:
        ahead = _table(program, inside, positions, forward, "forward_position")
        back = _table(program, inside, positions, backward, "backward_position")
        change = program.larger(direction, zero) * ahead + program.smaller(direction, zero) * back
    return program.named("compensation_change", change)


def _table(
    program: Program,
    at: ProgramNode,
    points: Sequence[float],
    values: Sequence[float],
    name: str,
) -> ProgramNode:
    curve = name.rsplit("_", 1)[0]
    total = program.constant(values[0], f"{curve}_drive")
    last = len(points) - 2
    for k, (low, high) in enumerate(itertools.pairwise(points)):
        inside = at
        if k < last:
            inside = program.smaller(inside, program.constant(high, f"{name}_{k + 1}"))
        if k > 0:
            inside = program.larger(inside, program.constant(low, f"{name}_{k}"))
        slope = (values[k + 1] - values[k]) / (high - low)
        ramp = inside - program.constant(low, f"{name}_{k}")
        total = total + program.constant(slope, f"{curve}_slope_{k}") * ramp
    return total


def observer_compensation(
    program: Program, speed: ProgramNode, bandwidth: float, inertia: float, gain: float, most: float
) -> tuple[ProgramNode, ProgramNode]:
    """Return the compensating drive [A | V] and the estimated friction [A | V].

    The estimated friction is expressed as a drive: friction/(effort per unit of drive).

    - bandwidth: bandwidth of the observer [rad/s]
    - inertia: drive per unit of acceleration
    - gain: fraction of the estimated friction that is compensated
    - most: bound of the estimated friction [A | V]

    The caller must then call `observe`, which writes the observer's next state.
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
    """Write the friction observer's next state to the program.

    - drive: applied drive [A | V]
    - estimate: estimated friction [A | V]
    - bandwidth: bandwidth of the observer [rad/s]
    - period: sample period [s]
    """
    step = program.constant(bandwidth * period, "observer_step")
    program.update("observed", program.states["observed"] + step * (drive - estimate))
