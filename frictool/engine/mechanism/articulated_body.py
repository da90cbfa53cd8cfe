"""Rates of a mechanism with known modes by the articulated-body recursion, in O(n).

Each block has one coordinate, and joints have no degree of freedom. Sources of the recursion:
Vereshchagin (Engineering Cybernetics 12(6), 1974, 65-70), Featherstone (International Journal of
Robotics Research 2(1), 1983, 13-30). A moving block with acceleration x needs the force INERTIA x +
NEED (workspace_rows.py) from the joint to its parent; at the root this force is 0. A block at rest
needs a force in [NEED, NEED_HIGH]. A tree stays at rest as long as the interval of its root
contains 0. A contact at rest stays closed as long as its interval contains a pressing force.

A mode is, for example, the rest of a block or the contact of two flanks of a backlash. Each mode
has a guard: the distance of a force, a speed or a position from the value at which the mode ends,
in units of the tolerance. The mode continues while its guard is above -1. The array `guard` has the
sections of the modes (motion, contact, branch, flank, stop). For an open flank or stop, the guard
is the distance to contact. For a moving tree, the guard is the speed of the root in the direction
of motion.

Stages within a step need fewer results: if the argument `whole` is False, the guards of speeds and
positions and the scale GROSS of rounding errors are not computed.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import address_calls as ac
from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism import workspace_rows as rows
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.efforts import efforts
from frictool.engine.mechanism.fixed_step_laws import seen_speeds, timed_frictions
from frictool.engine.mechanism.guard_tolerances import SLACK, SPEED_SLACK, place_guards, slack_at
from frictool.engine.mechanism.joint_losses import (
    is_lossy,
    is_self_locking,
    kink_of,
    range_at_driver,
    range_at_load,
    slope_of,
)
from frictool.engine.mechanism.state import EVALUATION, FREE, OPEN, RIGID, STUCK, RateEvaluation
from frictool.engine.mechanism.static_forces import force_at_rest
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import IntVector, Vector


@bare_kernel
def _begin(k: IntVector, p: Vector, modes: IntVector, w: Vector) -> None:
    n = k[ly.BLOCKS]
    stops = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]
    for i in range(n):
        w[rows.NEED, i], w[rows.NEED_HIGH, i] = -w[rows.FORCE, i], -w[rows.FORCE, i]
        w[rows.INERTIA, i] = ly.mass_of(k, p, i)
        if modes[i] == STUCK:
            w[rows.NEED, i] += w[rows.HOLD_LOW, i]
            w[rows.NEED_HIGH, i] += w[rows.HOLD_HIGH, i]
    for s in range(k[ly.STOPS]):
        block = ly.stop_block(k, s)
        if modes[stops + s] < 0:
            w[rows.NEED, block] = -math.inf
        elif modes[stops + s] > 0:
            w[rows.NEED_HIGH, block] = math.inf


@bare_kernel
def _hand_over_rest(
    k: IntVector, p: Vector, i: int, contact: int, w: Vector, guard: Vector, whole: bool
) -> None:
    n = k[ly.BLOCKS]
    joint = ly.joint_of(k, i)
    parent = ly.parent_of(k, i)
    row = ly.joint_row(k, joint)
    slack = slack_at(k, p, w, i)
    ratio = ly.ratio(p, row)
    low = w[rows.NEED, i]
    high = w[rows.NEED_HIGH, i]
    if ly.outward(k, i) == 1:
        if whole:
            w[rows.GROSS, parent] += abs(ratio) * w[rows.GROSS, i]
        if contact == -1:
            guard[n + joint] = high / slack
            low, high = max(0.0, low), max(0.0, high)
        elif contact == 1:
            guard[n + joint] = -low / slack
            low, high = min(0.0, low), min(0.0, high)
        kink = kink_of(p, row, w[rows.DRIVEN, parent])
        low, high = range_at_driver(p, row, kink, low, high)
    else:
        if whole:
            w[rows.GROSS, parent] += w[rows.GROSS, i] / abs(ratio)
        kink = kink_of(p, row, w[rows.DRIVEN, i])
        low, high = range_at_load(p, row, kink, -high, -low)
        if contact == -1:
            guard[n + joint] = high / slack * abs(ratio)
            low, high = max(0.0, low), max(0.0, high)
        elif contact == 1:
            guard[n + joint] = -low / slack * abs(ratio)
            low, high = min(0.0, low), min(0.0, high)
        low, high = -high, -low
    w[rows.NEED, parent] += low
    w[rows.NEED_HIGH, parent] += high


@bare_kernel
def _guard_load(
    k: IntVector, p: Vector, i: int, modes: IntVector, w: Vector, guard: Vector
) -> None:
    joint = ly.joint_of(k, i)
    row = ly.joint_row(k, joint)
    at = k[ly.BLOCKS] + k[ly.JOINTS] + joint
    if modes[at] == 0 or not is_self_locking(p, row):
        return
    low, high, slack = force_at_rest(k, p, i, w)
    kink = kink_of(p, row, w[rows.DRIVEN, ly.parent_of(k, i) if ly.outward(k, i) == 1 else i])
    guard[at] = (high - kink if modes[at] > 0 else kink - low) / slack


@bare_kernel
def direction_of(modes: IntVector, y: Vector, n: int, block: int) -> float:
    """Return the direction of motion of a block: +1, -1, or 0 at rest."""
    if modes[block] == FREE:
        return math.copysign(1.0, y[n + block])
    return float(modes[block])


@bare_kernel
def _hand_over(
    k: IntVector, p: Vector, i: int, y: Vector, modes: IntVector, w: Vector, whole: bool
) -> None:
    n = k[ly.BLOCKS]
    joint = ly.joint_of(k, i)
    parent = ly.parent_of(k, i)
    row = ly.joint_row(k, joint)
    ratio = slope = ly.ratio(p, row)
    kink = 0.0
    outward = ly.outward(k, i) == 1
    if is_lossy(p, row):
        a = parent if outward else i
        slope = slope_of(p, row, direction_of(modes, y, n, a), modes[n + k[ly.JOINTS] + joint] > 0)
        kink = kink_of(p, row, w[rows.DRIVEN, a])
    if outward:
        if whole:
            w[rows.GROSS, parent] += abs(ratio) * w[rows.GROSS, i]
        w[rows.INERTIA, parent] += slope * ratio * w[rows.INERTIA, i]
        w[rows.NEED, parent] += ratio * kink + (w[rows.NEED, i] - kink) * slope
    else:
        if whole:
            w[rows.GROSS, parent] += w[rows.GROSS, i] / abs(ratio)
        w[rows.INERTIA, parent] += w[rows.INERTIA, i] / (slope * ratio)
        w[rows.NEED, parent] += (w[rows.NEED, i] + ratio * kink) / slope - kink


@bare_kernel
def _gather(
    k: IntVector, p: Vector, y: Vector, modes: IntVector, w: Vector, guard: Vector, whole: bool
) -> bool:
    n = k[ly.BLOCKS]
    sound = True
    for index in range(n - 1, -1, -1):
        i = ly.block_at(k, index)
        joint = ly.joint_of(k, i)
        if joint >= 0 and modes[n + joint] != OPEN:
            if modes[i] == STUCK:
                _guard_load(k, p, i, modes, w, guard)
                _hand_over_rest(k, p, i, modes[n + joint], w, guard, whole)
            else:
                _hand_over(k, p, i, y, modes, w, whole)
        elif modes[i] == STUCK:
            guard[i] = min(w[rows.NEED_HIGH, i], -w[rows.NEED, i]) / slack_at(k, p, w, i)
            w[rows.ACCELERATION, i] = 0.0
        else:
            if whole and modes[i] != FREE:
                guard[i] = modes[i] * y[n + i] / (SPEED_SLACK * ly.speed_scale(k, p, i))
            if w[rows.INERTIA, i] <= 0.0:
                sound = False
            w[rows.ACCELERATION, i] = -w[rows.NEED, i] / w[rows.INERTIA, i]
    return sound


@bare_kernel
def _hand_out(
    k: IntVector, p: Vector, y: Vector, modes: IntVector, w: Vector, guard: Vector, power: Vector
) -> None:
    n, j = k[ly.BLOCKS], k[ly.JOINTS]
    losses = k[ly.SOURCES] + n
    for joint in range(j):
        power[losses + joint] = 0.0
        w[rows.LAMBDA, joint] = 0.0
    if j == 0:
        return
    for index in range(n):
        i = ly.block_at(k, index)
        joint = ly.joint_of(k, i)
        if joint < 0 or modes[n + joint] == OPEN:
            continue
        if modes[i] == STUCK:
            w[rows.ACCELERATION, i] = 0.0
            continue
        parent, row = ly.parent_of(k, i), ly.joint_row(k, joint)
        outward = ly.outward(k, i) == 1
        ratio = ly.ratio(p, row)
        w[rows.ACCELERATION, i] = w[rows.ACCELERATION, parent] * (ratio if outward else 1.0 / ratio)
        inertial = w[rows.INERTIA, i] * w[rows.ACCELERATION, i]
        force = inertial + w[rows.NEED, i]
        slack = slack_at(k, p, w, i) + SLACK * abs(inertial)
        if is_lossy(p, row):
            a = parent if outward else i
            kink = kink_of(p, row, w[rows.DRIVEN, a])
            slope = slope_of(p, row, direction_of(modes, y, n, a), modes[n + j + joint] > 0)
            if outward:
                effort = ratio * kink + (force - kink) * slope
            else:
                effort = -force
                force = kink + (effort - ratio * kink) / slope
                slack /= abs(ratio)
            power[losses + joint] = (effort - ratio * force) * y[n + a]
            guard[n + j + joint] = modes[n + j + joint] * (force - kink) / slack
        elif not outward:
            force = -force / ratio
            slack /= abs(ratio)
        w[rows.LAMBDA, joint] = force
        if modes[n + joint] != RIGID:
            guard[n + joint] = -modes[n + joint] * force / slack


@bare_kernel
def _rates(
    machine: CompiledMechanism,
    t: float,
    y: Vector,
    modes: IntVector,
    inputs: Vector,
    out: RateEvaluation,
    whole: bool,
) -> int:
    k, p, _ = machine
    rates, w, guard, power = out
    n = k[ly.BLOCKS]
    if whole:
        for index in range(guard.shape[0]):
            guard[index] = math.inf
    status = efforts(machine, t, y, modes, inputs, out, whole)
    if whole:
        place_guards(k, p, y, modes, guard)
    _begin(k, p, modes, w)
    sound = _gather(k, p, y, modes, w, guard, whole)
    if k[ly.TIMED] > 0:
        status += timed_frictions(machine, y, modes, out, whole)
        _begin(k, p, modes, w)
        sound = _gather(k, p, y, modes, w, guard, False)
    _hand_out(k, p, y, modes, w, guard, power)
    for i in range(n):
        rates[i] = y[n + i]
        rates[n + i] = w[rows.ACCELERATION, i] if sound else math.nan
    if k[ly.TIMED] > 0:
        seen_speeds(machine, y, modes, rates)
    return status


@kernel
def rates_of_state(
    machine: CompiledMechanism,
    t: float,
    y: Vector,
    modes: IntVector,
    inputs: Vector,
    out: RateEvaluation,
) -> int:
    """Fill rates, guards and powers as `field` does, with the same arguments."""
    return _rates(machine, t, y, modes, inputs, out, True)


@bare_kernel
def field_within(
    machine: CompiledMechanism,
    t: float,
    y: Vector,
    modes: IntVector,
    inputs: Vector,
    out: RateEvaluation,
) -> int:
    """Fill the results of `field` except the sums GROSS and the guards of speeds and positions."""
    return _rates(machine, t, y, modes, inputs, out, False)


RATES_OF_STATE = ac.function_type(
    ac.INTEGER, ly.MACHINE, ac.FLOAT, ac.VECTOR, ac.INDICES, ac.VECTOR, EVALUATION
)
_rates_of_state = ac.call_by_address(RATES_OF_STATE)


@bare_kernel
def field(
    machine: CompiledMechanism,
    t: float,
    y: Vector,
    modes: IntVector,
    inputs: Vector,
    out: RateEvaluation,
) -> int:
    """Fill the rates y' of the state, the modes' guards and the elements' powers; return a status.

    A guard measures how far a mode is from its end. t [s]: time since the last command. The
    accelerations are NaN if a tree's effective inertia is <= 0.
    """
    address = machine.laws[machine.laws.shape[0] - 1, ly.FIELD]
    status: int = _rates_of_state(address, machine, t, y, modes, inputs, out)
    return status
