"""Motion of an axis with a dynamic friction law, such as LuGre, under a constant command.

    J v' = K i(t) - offset - load(x) - F(z, z', v)        x' = v        z' = rate(z, v)

x is the position, v the velocity, z the internal state of the law, F the friction, and J the
inertia. The effort K i(t) of the drive is an exponential of time. The contact deflects under any
effort. Therefore, the axis is exactly at rest only while the effort presses the axis against an end
stop. The motion is integrated by the Rosenbrock method of engine/dynamic_law_motion.py. Impacts at
end stops are located on the dense output of an integration step. Backlash is not supported.

The parameter array contains, in this order:

- the parameters of the axis (plant/axis_friction_laws.py)
- HEAD values: addresses of the law's kernels, and sizes of arrays
- the array `scales` of `dynamic_law_motion.run_dynamic`
- for each parameter of the law, the drift that multiplies the parameter: FRICTION, SLOPE (viscous
  friction) or 0 (none)
- the arrays of `law_extension.PackedExtension`
- the load (plant/position_load.py)

The state array contains the state (7,) of the axis, the length [s] of the next integration step,
and z. An integration begins with the step length that the previous integration stored.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine import drive as dr
from frictool.engine.drive_lag import lagged_drive
from frictool.engine.dynamic_law_motion import (
    AT_REVERSAL,
    FIRST_STEP,
    SHORTEST_STEP,
    DrivenContact,
    LawKernels,
    Linearisation,
    hold_levels,
    law_commit,
    law_field,
    law_kernels,
    linearise,
    step_factor,
    try_law_step,
    virgin_contact,
)
from frictool.engine.rosenbrock import CONTACT, STAGES, between
from frictool.engine.status_codes import (
    LAW_FAILED,
    NOT_FINITE,
    OK,
    STEP_TOO_SMALL,
    TOO_MANY_EVENTS,
)
from frictool.friction.law import DynamicKernels
from frictool.friction.law_extension import regime_table
from frictool.friction.parameter import VISCOUS
from frictool.plant import axis as ax
from frictool.plant import axis_friction_laws as al
from frictool.plant.axis_dynamic_law import TOLERANCE, AxisDynamicLaw
from frictool.plant.position_load import appended, load_start
from frictool.runtime.kernels import inner_kernel, kernel
from frictool.typing import Vector

# the HEAD values; a float represents the three addresses (< 2^53) exactly
RATE, FORCE, COMMIT, MOVING, STATES, PARAMETERS = range(6)
HEAD = 6
STEP = ax.STATE_SIZE  # index in the state; z follows

# a parameter drifts with dry friction or with viscous friction; 0: no drift
FRICTION, SLOPE = 1.0, 2.0
MAX_IMPACTS = 10_000  # largest number of impacts at end stops in a call
SHORTEST_FLIGHT = 1e-6  # s; a rebound with a shorter flight ends at rest at the stop
BISECTIONS = 60


def with_dynamic_law(axis: Vector, dynamic: AxisDynamicLaw) -> Vector:
    """Return the parameter array of an axis with a dynamic friction law.

    Raises ValueError if the law does not support the friction extension in `dynamic`.
    """
    law, p, speed_scale, length_scale, extension = dynamic
    kernels = law.kernels
    assert isinstance(kernels, DynamicKernels)
    packed = extension.pack(law, p)
    table = np.zeros(0) if extension.plain else packed.table
    z, moving, sizes = virgin_contact(kernels, p, speed_scale, length_scale)
    drifts = np.zeros(p.size)
    for index, parameter in enumerate(law.parameters):
        if parameter.name == VISCOUS.name:
            drifts[index] = SLOPE
        elif parameter.linear_unit.startswith("N"):
            drifts[index] = FRICTION
    head = [*law_kernels(kernels), moving, z.size, p.size, TOLERANCE, speed_scale, 0.0]
    values = np.concatenate([head, sizes, drifts, packed.forward, packed.backward, table])
    out: Vector = appended(axis, values)
    out[al.DYNAMIC_SIZE] = values.size
    return out


def with_contact(state: Vector, dynamic: AxisDynamicLaw) -> Vector:
    """Return the state of an axis with a dynamic law whose contact is undeflected.

    The returned array contains the state of the axis (7,), the step length 0 s, and the internal
    state z.
    """
    kernels = dynamic.law.kernels
    assert isinstance(kernels, DynamicKernels)
    return np.concatenate([state, [0.0], kernels.reset(dynamic.p)])


@inner_kernel
def has_dynamic_law(p: Vector) -> bool:
    """Return True if the parameters p contain a dynamic friction law; p must contain `AxisLaws`."""
    return bool(p[al.DYNAMIC_SIZE] > 0.0)


@inner_kernel
def _levels_start(p: Vector) -> int:
    return al.EXTENDED_SIZE + HEAD + CONTACT + int(p[al.EXTENDED_SIZE + STATES])


@kernel
def impose_on_law(axis: Vector, p: Vector, friction: float, viscous: float) -> None:
    """Set the law's parameters in `p` to the parameters in `axis`, multiplied by two factors.

    `viscous` multiplies the parameters of viscous friction. `friction` multiplies the parameters of
    dry friction, and the stiffness and the damping of the contact; the largest deflection of the
    contact therefore stays constant.
    """
    if not has_dynamic_law(p):
        return
    count = int(p[al.EXTENDED_SIZE + PARAMETERS])
    drifts = _levels_start(p)
    for i in range(count):
        drift = p[drifts + i]
        factor = friction if drift == FRICTION else viscous if drift == SLOPE else 1.0
        for row in (drifts + count + i, drifts + 2 * count + i):
            p[row] = factor * axis[row]
    table = drifts + 3 * count
    end = load_start(p)
    if table < end:
        first = end - regime_table(p[table:end]).shape[0]
        for knee in range(first, end, 2):
            p[knee + 1] = viscous * axis[knee + 1]


@inner_kernel
def _drive(state: Vector, command: float, p: Vector) -> Vector:
    drive = np.zeros(dr.DECAY_RATE + 1)
    drive[dr.OFFSET] = p[ax.CONSTANT] * command - p[ax.OFFSET]
    if p[ax.LAG] > 0.0:
        drive[dr.DECAYING] = p[ax.CONSTANT] * (state[ax.DRIVE] - command)
        drive[dr.DECAY_RATE] = 1.0 / p[ax.LAG]
    return drive


@inner_kernel
def _wall(x: float, p: Vector) -> float:
    return 1.0 if x >= p[al.STOP_PAIR + 1] else -1.0 if x <= p[al.STOP_PAIR] else 0.0


@kernel
def _released(driven: DrivenContact, t: float, wall: float, outwards: float) -> float:
    drive = driven.drive
    fading = wall * drive[dr.DECAYING] * math.exp(-drive[dr.DECAY_RATE] * t) / driven.mass
    settled = outwards - fading
    if settled >= 0.0 or drive[dr.DECAY_RATE] == 0.0:
        return math.inf
    return t + float(math.log(fading / -settled) / drive[dr.DECAY_RATE])


@kernel
def _meet_stop(
    y: Vector, after: Vector, stages: Vector, rows: int, wall: float, place: float, at: Vector
) -> float:
    """Set y to the state at the impact on the stop at `place`; return the fraction of the step.

    The fraction is the time from the start of the step to the impact, divided by the step length.
    `after` is the state at the end of the step, beyond the stop. An axis that is already at the
    stop stays there for the whole step.
    """
    if y[0] == place:
        y[:rows] = after[:rows]
        y[0], y[1] = place, 0.0
        return 1.0
    low = 0.0
    high = 1.0
    for _ in range(BISECTIONS):
        share = 0.5 * (low + high)
        between(y, after, stages, share, rows, at)
        if wall * (at[0] - place) < 0.0:
            low = share
        else:
            high = share
    y[:rows] = at[:rows]
    y[0] = place
    return high


@kernel
def move_under_law(state: Vector, command: float, p: Vector, duration: float) -> int:
    """Advance the state of an axis with a dynamic law, in place, by `duration` [s].

    `axis_motion.advance` describes the arguments; `command` must be within the drive's limits.
    Returns a status of engine/status_codes.py.
    """
    head = p[al.EXTENDED_SIZE : al.EXTENDED_SIZE + HEAD]
    count = int(head[PARAMETERS])
    first = _levels_start(p)
    scales = p[al.EXTENDED_SIZE + HEAD : first]
    forward = p[first + count : first + 2 * count]
    backward = p[first + 2 * count : first + 3 * count]
    table = p[first + 3 * count : load_start(p)]
    kernels = LawKernels(int(head[RATE]), int(head[FORCE]), int(head[COMMIT]))
    laws = (forward, backward, table, forward.copy())
    drive = _drive(state, command, p)
    driven = DrivenContact(kernels, laws, p[ax.INERTIA], drive, p[load_start(p) :])
    moving = int(head[MOVING])
    rows = CONTACT + moving
    y = np.zeros(CONTACT + int(head[STATES]))
    y[0], y[1] = state[ax.POSITION], state[ax.VELOCITY]
    y[CONTACT:] = state[STEP + 1 :]
    slope = np.zeros_like(y)
    after = y.copy()
    at = y.copy()
    stages = np.zeros((STAGES, y.shape[0]))
    linear = Linearisation(np.zeros(3), np.zeros((3, moving)), np.zeros(CONTACT))
    t = 0.0
    h = state[STEP] if state[STEP] > 0.0 else FIRST_STEP * duration
    impacts = 0
    fresh = True
    while t < duration:
        if fresh:
            wall = _wall(y[0], p)
            if wall * y[1] > 0.0:
                impacts += 1
                y[1] *= -p[al.RESTITUTION]
            if impacts > MAX_IMPACTS:
                return TOO_MANY_EVENTS
            failed = law_field(driven, t, y, slope)
            outwards = wall * slope[1]
            if outwards > 0.0 and 2.0 * abs(y[1]) <= outwards * SHORTEST_FLIGHT:
                y[1] = 0.0
                failed += law_field(driven, t, y, slope)
                free = _released(driven, t, wall, wall * slope[1])
                if wall * slope[1] > 0.0 and free > t:
                    t = min(free, duration)
                    continue
            if failed + linearise(driven, t, y, slope, scales, linear) != OK:
                return LAW_FAILED
        step = min(h, duration - t)
        error = try_law_step(driven, linear, t, step, y, slope, scales, stages, after)
        fresh = error <= 1.0
        if not fresh:
            if step <= SHORTEST_STEP * duration:
                return STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
            h = step * step_factor(error)
            continue
        if y[1] * after[1] < 0.0 and min(abs(y[1]), abs(after[1])) > AT_REVERSAL * scales[1]:
            h = step * y[1] / (y[1] - after[1])
            fresh = False
            continue
        h = max(h if step < h else 0.0, step * step_factor(error))
        last = step >= duration - t
        passed = (
            1.0 if after[0] > p[al.STOP_PAIR + 1] else -1.0 if after[0] < p[al.STOP_PAIR] else 0.0
        )
        if passed != 0.0:
            place = p[al.STOP_PAIR + 1] if passed > 0.0 else p[al.STOP_PAIR]
            share = _meet_stop(y, after, stages, rows, passed, place, at)
            last = last and share == 1.0
            step *= share
        else:
            y[:rows] = after[:rows]
        t = duration if last else t + step
        hold_levels(laws, y)
        if law_commit(kernels.commit, y[CONTACT:], y[1], laws[3]) != OK:
            return LAW_FAILED
        after[rows:] = y[rows:]
        at[rows:] = y[rows:]
    state[ax.LOAD_POSITION] += y[0] - state[ax.POSITION]
    state[ax.POSITION], state[ax.VELOCITY] = y[0], y[1]
    state[ax.DRIVE] = lagged_drive(state[ax.DRIVE], command, p[ax.LAG], duration)
    state[ax.MODE] = ax.SLIPPING * float(np.sign(y[1]))
    state[STEP] = h
    state[STEP + 1 :] = y[CONTACT:]
    return OK
