"""One sample of an axis with dry friction on affine forms (affine_forms.py).

After division by the inertia, the motion depends on four ratios only, constant during a run:

    v' = ratio i - friction - viscous v - offset,    ratio = K/J, friction = F/J, viscous = sigma/J

The drive i approaches the command with the drive's lag. Inside the backlash, the friction is
`gap_share` times the friction of the axis, without viscous friction.

**Known direction.** If the sign of the speed and the contact with the load are certain, the
friction is known. The new forms then follow from the solution of the linear differential equation.

**Unknown direction.** Let T be the sample period, e the mean acceleration by drive and load during
the sample, and r = v(T) - s (v(0) + T e) with a factor 0 < s <= 1. With the mean friction
acceleration f of the sample, v(T) = v(0) + T (e + f), and therefore

    r / s = kappa v(T) + T f,    kappa = (1 - s) / s >= 0

Friction opposes the motion and is bounded: f >= -P and f <= Q. If v(T) > 0, let t0 be the last time
with v <= 0. Then v(T) <= (E - F1)(T - t0), where E is the largest acceleration and F1 the least
friction, and T f <= t0 Q - (T - t0) F1. Both bounds are linear in t0. Hence r / s <= T Q if kappa b
<= T (Q + F1) for a bound b of the speed, and similarly r / s >= -T P. The largest kappa that
satisfies this condition is used. The result is the enclosure of a dead zone: friction multiplies
v(0) + T e by the factor s, with an error of half of s T (P + Q).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.prove.affine_forms import (
    GROWTH,
    ROUND,
    Forms,
    clip_row,
    combine,
    copy_row,
    highest,
    lowest,
    multiply,
    radius,
    release,
)
from frictool.runtime.kernels import kernel, part_kernel
from frictool.typing import Vector

# rows of the axis, behind the rows of the controller
(
    Y,
    V,
    DRIVE,
    ACTING,
    PENDING,
    READ,
    RATIO,
    FRICTION,
    VISCOUS,
    OFFSET,
    V_V,
    Y_V,
    V_ACTING,
    V_DRIVE,
    Y_ACTING,
    Y_DRIVE,
    Y_FORCE,
    LAG,
    EFFORT,
    NEXT,
    SPEED,
    MOVE,
    WORK,
) = range(23)
ROWS = 23
# columns of the generators of parameters, initial position and its reading
(
    RATIO_COLUMN,
    FRICTION_COLUMN,
    VISCOUS_COLUMN,
    OFFSET_COLUMN,
    POSITION_COLUMN,
    READING_COLUMN,
) = range(6)
FIXED = 6
NEGLIGIBLE = 1e-9  # share of a radius below which an error does not become a generator
WORTH = 0.7  # relative width below which a clipped speed replaces its form
# contact with the load: unknown; inside the backlash; pushing forwards or backwards; the load's
# contact is in front of (behind) the axis and the opposite contact out of reach
ANY, GAP, FORWARD, BACKWARD, IN_FRONT, BEHIND = range(6)
# columns of the motion
(
    AT_REST,
    CONTACT,
    SPEED_LOW,
    SPEED_HIGH,
    DIRECTION,
    FROM_LOW,
    FROM_HIGH,
    REACH_LOW,
    REACH_HIGH,
    FAR,
    COUNT_LOW,
    COUNT_HIGH,
) = range(12)
MOTION = 12


class AxisCell(NamedTuple):
    """Constants of the axis for a cell, which is a box of plant parameters.

    Accelerations are in rad/s^2 | m/s^2 (effort divided by the inertia), `backlash` in rad | m.

    - gap_share: friction inside the backlash divided by the friction of the axis
    - breakaway: breakaway of the axis divided by its Coulomb friction
    - gap_breakaway: breakaway inside the backlash divided by the Coulomb friction there
    - lag_time: integral of e^(-t/lag) over a sample [s]
    - lag_move: error of a double integral over a sample [s^2] if e^(-t/lag) is replaced by its mean
      value
    """

    period: float
    lag: float
    ratio_low: float
    ratio_high: float
    friction_low: float
    friction_high: float
    viscous_high: float
    offset_low: float
    offset_high: float
    gap_share: float
    breakaway: float
    gap_breakaway: float
    backlash: float
    lag_time: float
    lag_move: float


@part_kernel
def drive_bounds(f: Forms, o: int, c: AxisCell) -> tuple[float, float]:
    """Return the least and the largest acceleration by drive and load during the sample.

    - o: row of the first quantity of the axis in the table of forms
    - c: constants of the cell

    The unit is rad/s^2 | m/s^2.
    """
    low = min(lowest(f, o + DRIVE), lowest(f, o + NEXT))
    high = max(highest(f, o + DRIVE), highest(f, o + NEXT))
    least = min(c.ratio_low * low, c.ratio_high * low) - c.offset_high
    most = max(c.ratio_low * high, c.ratio_high * high) - c.offset_low
    slack = ROUND * (abs(least) + abs(most) + abs(c.offset_high))
    return least - slack, most + slack


@part_kernel
def frictions(contact: int, forward: bool, c: AxisCell) -> tuple[float, float, float]:
    """Return least and largest friction, and largest viscous coefficient, divided by the inertia.

    - contact: contact with the load, one of the constants ANY to BEHIND
    - forward: True for a motion in positive direction
    """
    inside = contact == GAP or contact == (BEHIND if forward else IN_FRONT)
    sure = contact == (FORWARD if forward else BACKWARD)
    least = c.friction_low * (1.0 if sure else c.gap_share)
    most = c.friction_high * (c.gap_share if inside else 1.0)
    return least, most, 0.0 if inside else c.viscous_high


@part_kernel
def breakaways(contact: int, forward: bool, c: AxisCell) -> tuple[float, float]:
    """Return the least and the largest breakaway, divided by the inertia [rad/s^2 | m/s^2].

    - contact: contact with the load, one of the constants ANY to BEHIND
    - forward: True for a motion in positive direction
    """
    least, most, _ = frictions(contact, forward, c)
    inside = contact == GAP or contact == (BEHIND if forward else IN_FRONT)
    sure = contact == (FORWARD if forward else BACKWARD)
    low = c.breakaway if sure else min(c.breakaway, c.gap_breakaway)
    high = c.gap_breakaway if inside else max(c.breakaway, c.gap_breakaway)
    return least * low, most * high


@kernel
def prepare(f: Forms, o: int, c: AxisCell, nodes: Vector, weights: Vector) -> None:
    """Compute the coefficients that depend on viscous friction, for a motion in a known direction.

    nodes, weights: Gauss quadrature on [-1, 1].
    """
    lam = f.center[o + VISCOUS]
    r = radius(f, o + VISCOUS)
    t = c.period
    total = np.zeros(8)
    for g in range(nodes.shape[0]):
        s = 0.5 * t * (nodes[g] + 1.0)
        w = 0.5 * t * weights[g]
        e = math.exp(-lam * s)
        h = math.exp(-(t - s) / c.lag)
        q = c.lag * (1.0 - h)
        total[0] += w * e
        total[1] -= w * s * e
        total[2] += w * (t - s) * e
        total[3] -= w * (t - s) * s * e
        total[4] += w * e * h
        total[5] -= w * s * e * h
        total[6] += w * e * q
        total[7] -= w * s * e * q
    e = math.exp(-lam * t)
    _coefficient(f, o + V_V, o + VISCOUS, e, -t * e, t * t * r * r)
    _coefficient(f, o + Y_V, o + VISCOUS, total[0], total[1], t**3 / 3.0 * r * r)
    _coefficient(f, o + Y_FORCE, o + VISCOUS, total[2], total[3], t**4 / 12.0 * r * r)
    _coefficient(f, o + WORK, o + VISCOUS, total[4], total[5], t**3 / 3.0 * r * r)
    multiply(f, o + V_DRIVE, o + WORK, o + RATIO)
    combine(f, o + WORK, 1.0, o + Y_V, -1.0, o + WORK, 0.0, 0.0)
    multiply(f, o + V_ACTING, o + WORK, o + RATIO)
    _coefficient(f, o + WORK, o + VISCOUS, total[6], total[7], t**4 / 12.0 * r * r)
    multiply(f, o + Y_DRIVE, o + WORK, o + RATIO)
    combine(f, o + WORK, 1.0, o + Y_FORCE, -1.0, o + WORK, 0.0, 0.0)
    multiply(f, o + Y_ACTING, o + WORK, o + RATIO)


@part_kernel
def _coefficient(f: Forms, d: int, a: int, value: float, slope: float, second: float) -> None:
    error = 0.5 * second + 1e-12 * abs(value)  # quadrature and rounding
    combine(f, d, slope, a, 0.0, a, value - slope * f.center[a], error)


@part_kernel
def advance(f: Forms, o: int, c: AxisCell, m: Vector) -> None:
    """Advance the axis by one sample with the command in the row ACTING.

    - o: row of the first quantity of the axis in the table of forms
    - c: constants of the cell
    - m: numbers that describe the motion besides the forms, such as the contact with the load, at
      the indices AT_REST to COUNT_HIGH; updated in place
    """
    t = c.period
    decay = math.exp(-t / c.lag)
    combine(f, o + NEXT, decay, o + DRIVE, 1.0 - decay, o + ACTING, 0.0, 0.0)
    combine(f, o + LAG, 1.0, o + DRIVE, -1.0, o + ACTING, 0.0, 0.0)
    least, most = drive_bounds(f, o, c)
    contact = int(m[CONTACT])
    forward_break, forward_hold = breakaways(contact, True, c)
    backward_break, backward_hold = breakaways(contact, False, c)
    if m[AT_REST] == 1.0:
        if most < forward_break and least > -backward_break:
            copy_row(f, o + DRIVE, o + NEXT)
            m[SPEED_LOW] = 0.0
            m[SPEED_HIGH] = 0.0
            return
        m[AT_REST] = 0.0
    low = max(lowest(f, o + V), m[SPEED_LOW])
    high = min(highest(f, o + V), m[SPEED_HIGH])
    one_way = m[SPEED_LOW] >= 0.0 or m[SPEED_HIGH] <= 0.0  # known from the last sample
    if one_way and high - low < WORTH * (highest(f, o + V) - lowest(f, o + V)):
        clip_row(f, o + V, low, high)
    contact = _contact_now(f, o, c, m, low, high, least, most)
    forward_break, forward_hold = breakaways(contact, True, c)
    backward_break, backward_hold = breakaways(contact, False, c)
    f1, f2, slope_f = frictions(contact, True, c)
    b1, b2, slope_b = frictions(contact, False, c)
    b = max(high, 0.0) + t * max(0.0, most - f1)
    a = min(low, 0.0) + t * min(0.0, least + b1)
    slowest = low + t * min(0.0, least - f2 - slope_f * b)
    fastest = high + t * max(0.0, most + b2 - slope_b * a)
    slack = ROUND * (1.0 + abs(a) + abs(b) + t * (abs(most) + abs(least) + f2 + b2))
    if low > 0.0 and slowest > slack:
        a = slowest - slack
    elif low >= 0.0 and least > -backward_break:
        a = 0.0
    else:
        a -= slack
    if high < 0.0 and fastest < -slack:
        b = fastest + slack
    elif high <= 0.0 and most < forward_break:
        b = 0.0
    else:
        b += slack
    if (contact == FORWARD and a < 0.0) or (contact == BACKWARD and b > 0.0):
        # inside the backlash, or pushing the load as before
        contact = IN_FRONT if contact == FORWARD else BEHIND
        forward_break, forward_hold = breakaways(contact, True, c)
        backward_break, backward_hold = breakaways(contact, False, c)
        f1, f2, slope_f = frictions(contact, True, c)
        b1, b2, slope_b = frictions(contact, False, c)
        a = min(low, 0.0) + t * min(0.0, least + b1) - slack
        b = max(high, 0.0) + t * max(0.0, most - f1) + slack
    moving_forward = a > 0.0 or (a >= 0.0 and least > forward_hold)
    moving_backward = b < 0.0 or (b <= 0.0 and most < -backward_hold)
    _effort(f, o, c)
    if moving_forward and contact in (FORWARD, GAP, BEHIND):
        _known(f, o, c, 1.0, contact != FORWARD)
    elif moving_backward and contact in (BACKWARD, GAP, IN_FRONT):
        _known(f, o, c, -1.0, contact != BACKWARD)
    else:
        p = min(forward_hold, max(most, -backward_hold))  # stuck: friction = -drive
        q = min(backward_hold, max(-least, -forward_hold))
        if moving_forward:
            p, q = f2, -f1
        elif moving_backward:
            p, q = -b1, b2
        if b > 0.0:
            p, q = max(p, f2), max(q, -f1)
        if a < 0.0:
            p, q = max(p, -b1), max(q, b2)
        kappa = 0.0
        if not moving_forward and not moving_backward:
            combine(f, o + WORK, 1.0, o + V, 1.0, o + EFFORT, 0.0, 0.0)
            fast = min(b, max(highest(f, o + WORK) - t * f1, t * (most - f1)) + slack)
            slow = max(a, min(lowest(f, o + WORK) + t * b1, t * (least + b1)) - slack)
            kappa = 1e3
            if fast > 0.0:
                kappa = min(kappa, t * (q + f1) / fast)
            if slow < 0.0:
                kappa = min(kappa, t * (p + b1) / -slow)
            kappa = max(0.0, kappa * (1.0 - ROUND))
        down, up = p, q  # friction at one time
        if b > 0.0:
            p = max(p, f2 + _viscous_excess(slope_f, kappa, b, f2 - least, t))
            down = max(p, f2 + slope_f * b)
        if a < 0.0:
            q = max(q, b2 + _viscous_excess(slope_b, kappa, -a, b2 + most, t))
            up = max(q, b2 - slope_b * a)
        s = 1.0 / (1.0 + kappa)
        combine(f, o + SPEED, s, o + V, s, o + EFFORT, 0.5 * s * t * (q - p), 0.5 * s * t * (p + q))
        release(f, o + SPEED, NEGLIGIBLE)
        _trapezoid(f, o, c, 0.125 * t * t * (down + up))
    copy_row(f, o + V, o + SPEED)
    combine(f, o + Y, 1.0, o + Y, 1.0, o + MOVE, 0.0, 0.0)
    copy_row(f, o + DRIVE, o + NEXT)
    release(f, o + V, NEGLIGIBLE)
    release(f, o + Y, NEGLIGIBLE)
    release(f, o + DRIVE, NEGLIGIBLE)
    m[SPEED_LOW] = a
    m[SPEED_HIGH] = b
    _meet(f, o, c, m, contact)


@part_kernel
def _contact_now(
    f: Forms, o: int, c: AxisCell, m: Vector, low: float, high: float, least: float, most: float
) -> int:
    t = c.period
    contact = int(m[CONTACT])
    gap = c.friction_low * c.gap_share
    top = highest(f, o + Y) + t * (max(high, 0.0) + t * max(0.0, most - gap)) * GROWTH
    bottom = lowest(f, o + Y) + t * (min(low, 0.0) + t * min(0.0, least + gap)) * GROWTH
    if contact == GAP:
        travelled = max(top - m[FROM_LOW], m[FROM_HIGH] - bottom)
        return GAP if travelled < m[REACH_LOW] else ANY
    if contact == IN_FRONT:
        return IN_FRONT if bottom > m[FAR] - c.backlash else ANY
    if contact == BEHIND:
        return BEHIND if top < m[FAR] + c.backlash else ANY
    return contact


@part_kernel
def _meet(f: Forms, o: int, c: AxisCell, m: Vector, contact: int) -> None:
    """Update the contact with the load after a sample whose motion gives the state `contact`.

    Inside the backlash, the distance to the contact follows from the position alone. The distance
    therefore stays known if the direction of motion is uncertain.
    """
    low, high = lowest(f, o + Y), highest(f, o + Y)
    a, b = m[SPEED_LOW], m[SPEED_HIGH]
    top = high - c.period * min(a, 0.0)  # largest position during the sample
    bottom = low - c.period * max(b, 0.0)
    before = int(m[CONTACT])
    m[CONTACT] = contact
    if contact == IN_FRONT:
        m[FAR] = max(m[FAR], top) if before == IN_FRONT else top
    elif contact == BEHIND:
        m[FAR] = min(m[FAR], bottom) if before == BEHIND else bottom
    elif a >= 0.0 and (m[DIRECTION] >= 0.0 or contact == GAP):
        m[DIRECTION] = 1.0
        if low - m[FROM_HIGH] >= m[REACH_HIGH]:
            m[CONTACT] = FORWARD
        elif high - m[FROM_LOW] < m[REACH_LOW]:
            m[CONTACT] = GAP
        else:
            m[CONTACT] = ANY
    elif b <= 0.0 and (m[DIRECTION] <= 0.0 or contact == GAP):
        m[DIRECTION] = -1.0
        if m[FROM_LOW] - high >= m[REACH_HIGH]:
            m[CONTACT] = BACKWARD
        elif m[FROM_HIGH] - low < m[REACH_LOW]:
            m[CONTACT] = GAP
        else:
            m[CONTACT] = ANY
    elif contact != GAP:
        m[CONTACT] = ANY
        m[DIRECTION] = 0.0
        m[FROM_LOW] = low
        m[FROM_HIGH] = high
        m[REACH_LOW] = 0.0
        m[REACH_HIGH] = c.backlash


@part_kernel
def _viscous_excess(slope: float, kappa: float, speed: float, braking: float, t: float) -> float:
    """Return a bound of (mean viscous friction) - kappa (final speed)/t over a sample of length t.

    The module docstring defines kappa.

    - speed: bound of the speed
    - braking: bound of the deceleration without viscous friction
    """
    fall = 0.5 * t * max(0.0, braking + slope * speed)
    excess = max(0.0, slope * t - kappa) * speed / t + slope * min(fall, speed)
    return min(excess, slope * speed) * GROWTH


@part_kernel
def _effort(f: Forms, o: int, c: AxisCell) -> None:
    combine(f, o + WORK, c.period, o + ACTING, c.lag_time, o + LAG, 0.0, 0.0)
    multiply(f, o + EFFORT, o + RATIO, o + WORK)
    combine(f, o + EFFORT, 1.0, o + EFFORT, -c.period, o + OFFSET, 0.0, 0.0)


@part_kernel
def _trapezoid(f: Forms, o: int, c: AxisCell, error: float) -> None:
    """Set the row MOVE to the distance of a sample in which the speed changes from V to SPEED.

    The trapezoidal rule is exact for a constant acceleration. A second term corrects the distance
    for the lag of the drive; `error` [rad | m] bounds the effect of a friction that is not
    constant.
    """
    combine(f, o + MOVE, 0.5 * c.period, o + V, 0.5 * c.period, o + SPEED, 0.0, error)
    multiply(f, o + WORK, o + RATIO, o + LAG)
    combine(f, o + MOVE, 1.0, o + MOVE, c.lag_move, o + WORK, 0.0, 0.0)


@part_kernel
def _known(f: Forms, o: int, c: AxisCell, sign: float, inside: bool) -> None:
    if inside:
        combine(f, o + WORK, 1.0, o + V, 1.0, o + EFFORT, 0.0, 0.0)
        friction = -sign * c.period * c.gap_share
        combine(f, o + SPEED, 1.0, o + WORK, friction, o + FRICTION, 0.0, 0.0)
        _trapezoid(f, o, c, 0.0)
        return
    combine(f, o + EFFORT, -1.0, o + OFFSET, -sign, o + FRICTION, 0.0, 0.0)
    _linear(f, o, o + SPEED, o + V_V, o + V_ACTING, o + V_DRIVE, o + Y_V)
    _linear(f, o, o + MOVE, o + Y_V, o + Y_ACTING, o + Y_DRIVE, o + Y_FORCE)


@part_kernel
def _linear(f: Forms, o: int, d: int, speed: int, acting: int, drive: int, force: int) -> None:
    multiply(f, d, speed, o + V)
    multiply(f, o + WORK, acting, o + ACTING)
    combine(f, d, 1.0, d, 1.0, o + WORK, 0.0, 0.0)
    multiply(f, o + WORK, drive, o + DRIVE)
    combine(f, d, 1.0, d, 1.0, o + WORK, 0.0, 0.0)
    multiply(f, o + WORK, force, o + EFFORT)
    combine(f, d, 1.0, d, 1.0, o + WORK, 0.0, 0.0)
