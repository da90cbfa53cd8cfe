"""Observer for a coarse encoder, corrected only if the estimate leaves a dead zone.

    m    = y - x with a dead zone of +-cell/2        y: measured position, lower edge of a count
                                                     x: estimated position minus half a count
    x^   = x + L1 m        v^ = v + L2 m        d^ = d + L3 m while the axis moves
    v+   = v^ + T/J (e - offset - viscous v^ - dry friction + d^)
           0 if this effort cannot move the axis: Coulomb friction by an implicit step
    x+   = x^ + T (v^ + v+)/2

The mark ^ denotes a corrected estimate, + the prediction for the next sample. T is the sample
period, J the inertia, e the drive's effort, and `cell` the width of the dead zone. Within the dead
zone nothing is corrected: between two counts the model determines the speed, which is 0 at rest.
The dry friction is the value of the friction map at the estimated position, half a count above x^;
while the backlash is open, it is the friction of the motor alone. The backlash follows thesis
(4.45). The disturbance d [N m | N] is the effort that the model lacks, added to the drive. At rest,
d is limited. If the drive's effort exceeds the breakaway friction by g (g < 0 in the negative
direction), d is between 0 and -g; otherwise d is 0.

Property: in slip, while m is not 0, the estimation error is linear with three poles at exp(-w T)
(observe/design/tracking.py), where w is the observer's bandwidth. With cell = 0 the observer is
linear. A cell of one encoder step is too wide, since the estimate then stays at an edge of the dead
zone (docs/theory/velocity.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictool.control.observer_output import ObserverNodes
from frictool.control.program import Program, ProgramNode

STATES = ("tracked_position", "tracked_velocity", "disturbance", "tracked_gap")
# speed [counts per sample] below which the axis counts as at rest, because rounding errors remain
# when a correction has decayed
LEAST_SPEED = 1e-6
# smallest distance to the end of the gap that counts as contact, relative to the backlash
LEAST_EDGE = 1e-3


@dataclass(frozen=True)
class TrackingParameters:
    """Parameters of the tracking observer, in SI.

    - gains: correction gains L1 [1], L2 [1/s], L3 [N m/rad | N/m]
    - cell, step: width of the innovation's dead zone, and width of an encoder step [rad | m]
    - forward, backward: friction [N m | N] as polynomials of the position [rad | m], coefficients
      in rising powers
    - travel: (low, high) position, beyond which the friction is constant
    - breakaway: ratio of friction at rest to friction in slip
    - knees: (speed, increase of the viscous coefficient above that speed) for each change of the
      viscous coefficient
    - backlash: width of the gap [rad | m]
    - loose: friction of the motor alone [N m | N], which acts while the gap is open
    - top_speed, most_effort: bounds of the estimated speed and of the disturbance d
    """

    period: float
    inertia: float
    gains: tuple[float, float, float]
    cell: float
    step: float
    forward: tuple[float, ...]
    backward: tuple[float, ...]
    travel: tuple[float, float]
    breakaway: float
    viscous: float
    knees: tuple[tuple[float, float], ...]
    offset: float
    backlash: float
    loose: float
    top_speed: float
    most_effort: float


@dataclass(frozen=True)
class TrackingNodes:
    """Nodes of the corrected estimates at a sample.

    - position: estimated position minus half a count [rad | m]
    - gap: position of the motor in the backlash [rad | m]; None if the model has no backlash
    - friction: dry friction (forward, backward) [N m | N]
    - still: node that is true while the axis is estimated to be at rest
    """

    position: ProgramNode
    velocity: ProgramNode
    disturbance: ProgramNode
    gap: ProgramNode | None
    friction: tuple[ProgramNode, ProgramNode]
    still: ProgramNode


def write_prediction(
    program: Program, position: ProgramNode, facts: TrackingParameters
) -> tuple[ObserverNodes, TrackingNodes]:
    """Write the states, and correct them by the measured position; return the corrected estimates.

    The observer starts at the measured position, at rest, in the middle of the backlash.
    """
    program.block("tracking observer: distance of the measured position from the encoder's cell")
    zero = program.constant(0.0)
    top = facts.top_speed
    most = facts.most_effort
    x = program.state(STATES[0], position.low, position.high, start="position")
    v = program.state(STATES[1], -top, top)
    d = program.state(STATES[2], -most, most)
    miss = program.named(
        "miss", _beyond(program, position - x, program.constant(0.5 * facts.cell, "half_cell"))
    )
    one, two, three = (
        program.constant(gain, f"tracking_gain[{row}]") for row, gain in enumerate(facts.gains)
    )
    moves = program.named("moves", (v > zero) | (v < zero))
    shift = one * miss
    estimated_x = program.named("found_position", x + shift)
    seen_v = _bounded(program, v + two * miss, top)
    least = program.constant(LEAST_SPEED * facts.step / facts.period, "least_speed")
    estimated_v = program.named("found_velocity", program.select(abs(seen_v) < least, zero, seen_v))
    estimated_d = program.named(
        "found_disturbance",
        _within(
            program,
            program.select(moves, d + three * miss, d),
            program.constant(most, "most_disturbance"),
        ),
    )
    true_x = program.named(
        "position_found", estimated_x + program.constant(0.5 * facts.step, "half_step")
    )
    gap, friction = _friction(program, true_x, shift, facts)
    forth = estimated_v > zero
    back = estimated_v < zero
    dry = program.select(forth, friction[0], program.select(back, -friction[1], zero))
    seen = program.named("friction_seen", program.select(forth | back, dry - estimated_d, zero))
    tracked = TrackingNodes(
        estimated_x,
        estimated_v,
        estimated_d,
        gap,
        friction,
        program.named("still", ~(forth | back)),
    )
    return ObserverNodes(true_x, estimated_v, seen, None), tracked


def write_update(
    program: Program, effort: ProgramNode, tracked: TrackingNodes, facts: TrackingParameters
) -> None:
    """Write the prediction of the states for the next sample.

    effort: drive effort from this sample to the next [N m | N].
    """
    program.block("tracking observer: prediction by the model for the next sample")
    zero = program.constant(0.0)
    v = tracked.velocity
    rate = program.constant(facts.period / facts.inertia, "period_per_inertia")
    drive = (
        effort - program.constant(facts.offset, "observer_offset")
        if facts.offset != 0.0
        else effort
    )
    push = drive + tracked.disturbance
    if facts.viscous != 0.0:
        push = push - program.constant(facts.viscous, "observer_viscous") * v
    for number, (speed, slope) in enumerate(facts.knees):
        faster = _beyond(program, v, program.constant(speed, f"knee[{number}]"))
        push = push - program.constant(slope, f"knee_viscous[{number}]") * faster
    free = program.named("velocity_free", v + rate * push)
    ratio = program.constant(facts.breakaway, "breakaway_ratio")
    up, down = (
        program.named(f"friction_{side}", one)
        for side, one in zip(("forward", "backward"), tracked.friction, strict=True)
    )
    hold_up, hold_down = (program.select(tracked.still, ratio * one, one) for one in (up, down))
    stays = program.named("stays", (free <= rate * hold_up) & (-(rate * hold_down) <= free))
    slips = free - rate * program.select(free > zero, up, -down)
    after = program.named(
        "velocity_after", program.select(stays, zero, _bounded(program, slips, facts.top_speed))
    )
    distance = program.named(
        "way", program.constant(0.5 * facts.period, "half_period") * (v + after)
    )
    excess = drive - program.smaller(program.larger(drive, -hold_down), hold_up)
    holding = program.smaller(
        program.larger(tracked.disturbance, program.smaller(zero, -excess)),
        program.larger(zero, -excess),
    )
    program.update(STATES[0], tracked.position + distance)
    program.update(STATES[1], after)
    program.update(STATES[2], program.select(stays, holding, tracked.disturbance))
    if tracked.gap is not None:
        program.update(
            STATES[3],
            _within(
                program, tracked.gap + distance, program.constant(0.5 * facts.backlash, "half_gap")
            ),
        )


def _friction(
    program: Program, x: ProgramNode, shift: ProgramNode, facts: TrackingParameters
) -> tuple[ProgramNode | None, tuple[ProgramNode, ProgramNode]]:
    """Return the position in the backlash [rad | m] and the slip friction [N m | N] at position x.

    The position is None if the model has no backlash. The friction is a pair: forward and backward.
    """
    zero, (low, high) = program.constant(0.0), facts.travel
    mapped = x
    if max(len(facts.forward), len(facts.backward)) > 1:
        mapped = program.smaller(
            program.larger(x, program.constant(low, "map_low")), program.constant(high, "map_high")
        )
    sides = [
        program.larger(program.polynomial(mapped, coefficients), zero)
        for coefficients in (
            [program.constant(c, f"{name}_map[{power}]") for power, c in enumerate(curve)]
            for curve, name in ((facts.forward, "forward"), (facts.backward, "backward"))
        )
    ]
    if facts.backlash == 0.0:
        return None, (sides[0], sides[1])
    half = program.constant(0.5 * facts.backlash, "half_gap")
    before = program.state(STATES[3], -0.5 * facts.backlash, 0.5 * facts.backlash)
    gap = program.named("gap_found", _within(program, before + shift, half))
    near = max(LEAST_EDGE * facts.backlash, min(facts.step, 0.25 * facts.backlash))
    edge = program.constant(0.5 * facts.backlash - near, "edge")
    loose = program.constant(facts.loose, "loose_friction")
    carried = gap >= edge, gap <= -edge
    forward, backward = (
        program.select(carries, side, program.smaller(side, loose))
        for carries, side in zip(carried, sides, strict=True)
    )
    return gap, (forward, backward)


def _bounded(program: Program, speed: ProgramNode, top: float) -> ProgramNode:
    return (
        _within(program, speed, program.constant(top, "most_speed"))
        if math.isfinite(top)
        else speed
    )


def _within(program: Program, value: ProgramNode, most: ProgramNode) -> ProgramNode:
    return program.smaller(program.larger(value, -most), most)


def _beyond(program: Program, value: ProgramNode, most: ProgramNode) -> ProgramNode:
    return value - _within(program, value, most)
