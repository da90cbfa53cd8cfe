"""Friction at each sample, with its interval.

    slip     direction (wear q F(x, |v|) + added + q fall(|v|)) + g viscous v
    in gap   direction wear q F_gap                                backlash (4.45)
    rest     effort - offset - load(x)                             at most breakaway times wear

    x, v     position and velocity
    F        dry friction of the model (2.34), (4.41)
    g, q     factors of viscous and dry friction at the temperature of the sample
    added    additive wear
    fall     friction that falls with speed and is not in the model
    F_gap    friction inside the gap (backlash)

Numbers in brackets are equations of the thesis. In slip, the friction is the model's law times the
wear. At rest, friction balances the effort. The axis is treated as at rest if the interval of its
velocity contains 0. An axis with such an interval may nevertheless move. The interval of the
friction therefore includes the effort that stops a motion within one count. A play operator
computes the position inside the backlash from the measured position, for three widths of the
backlash: nominal, least and largest.
"""

from __future__ import annotations

import math

from frictool.engine.axis_friction import breakaway_at, coulomb_at, straight_line
from frictool.plant.axis import BACKLASH_BREAKAWAY, OFFSET
from frictool.plant.axis_friction_laws import STRIBECK_EXPONENT, STRIBECK_VELOCITY
from frictool.plant.position_load import load_effort
from frictool.runtime.kernels import kernel
from frictool.typing import Matrix, Vector

# state from sample to sample: last position, last effort, 1 if these two are known, mean square of
# the effort's noise, weight of this mean (0 to 1), position inside the nominal, least and largest
# backlash
LAST_X, LAST_EFFORT, KNOWN, NOISE, WEIGHT, GAPS = 0, 1, 2, 3, 4, 5
STATE_SIZE = GAPS + 3
FORGET = 1.0 / 256.0  # weight of each new sample at rest in the mean square of the noise
VALUE, LOW, HIGH = 0, 1, 2
ROUNDING = 1e-9  # relative tolerance of half a backlash
ZONE_SIZE = 5  # columns of `zones`: start, end, then value, low and high of the wear


@kernel
def dry_friction(p: Vector, x: float, direction: float, speed: float) -> float:
    """Return the dry friction F [N m | N] in slip; `p` contains the parameters of the axis."""
    level = float(coulomb_at(p, direction, x))
    if p[STRIBECK_VELOCITY] > 0.0:
        fall = math.exp(-((speed / p[STRIBECK_VELOCITY]) ** p[STRIBECK_EXPONENT]))
        level += max(0.0, breakaway_at(p, direction, x, math.inf) - level) * fall
    return float(level)


@kernel
def viscous_friction(p: Vector, direction: float, speed: float) -> float:
    """Return the viscous friction [N m | N] at a speed; its coefficient may change with speed.

    `p` (EXTENDED_SIZE,) contains the parameters of the axis.
    """
    added, viscous = straight_line(p, direction, speed)
    return added + viscous * speed


@kernel
def _worn(factors: Matrix, zones: Matrix, x: float, direction: float) -> tuple[float, float, float]:
    """Return value, lower and upper bound of the wear at the position x."""
    for row in range(zones.shape[0]):
        if zones[row, 0] <= x < zones[row, 1]:
            return zones[row, 2], zones[row, 3], zones[row, 4]
    side = 0 if direction > 0.0 else 1
    return factors[side, VALUE], factors[side, LOW], factors[side, HIGH]


@kernel
def _strongest(p: Vector, direction: float, x: float, factors: Matrix, zones: Matrix) -> float:
    """Return the largest static friction [N m | N] at the position x for the largest wear."""
    worn = (
        breakaway_at(p, direction, x, math.inf) * _worn(factors, zones, x, direction)[HIGH]
        + factors[2, HIGH]
    )
    return float(max(worn, p[BACKLASH_BREAKAWAY]))


@kernel
def _in_slip(
    axes: Matrix,
    gap: Vector,
    x: float,
    v: float,
    factors: Matrix,
    zones: Matrix,
    fall: Vector,
    loose: float,
    viscous_factor: float,
    dry_factor: float,
) -> tuple[float, float, float]:
    """Return value, low, high of the friction [N m | N] in slip at position x and velocity v.

    `fall` (2,): value and half width of the friction that falls with speed and is not in the model.
    `loose`: fraction of the backlash widths for which the flanks do not touch (`_play`).
    `viscous_factor` and `dry_factor` apply at the temperature of the sample.
    """
    direction = 1.0 if v > 0.0 else -1.0
    speed = abs(v)
    value = 0.0
    low = math.inf
    high = 0.0
    wear = _worn(factors, zones, x, direction)
    if loose < 1.0:
        dry = dry_factor * dry_friction(axes[0], x, direction, speed)
        viscous = viscous_factor * viscous_friction(axes[0], direction, speed)
        worn = wear[VALUE] * dry + factors[2, VALUE]
        value = worn + dry_factor * fall[0] + viscous
        least = wear[LOW] * dry + factors[2, LOW] - worn
        most = wear[HIGH] * dry + factors[2, HIGH] - worn
        thin, thick = (
            viscous_factor * viscous_friction(axes[LOW], direction, speed),
            viscous_factor * viscous_friction(axes[HIGH], direction, speed),
        )
        unsure = (dry_factor * fall[1]) ** 2
        low = max(0.0, value - math.sqrt(least * least + (thin - viscous) ** 2 + unsure))
        high = value + math.sqrt(most * most + (thick - viscous) ** 2 + unsure)
    if loose > 0.0:
        low = min(low, dry_factor * gap[LOW] * wear[LOW])
        high = max(high, dry_factor * gap[HIGH] * wear[HIGH])
    if loose > 0.5:
        value = dry_factor * gap[VALUE] * wear[VALUE]
    return (value, low, high) if direction > 0.0 else (-value, -high, -low)


@kernel
def _play(state: Vector, x: float, direction: float, widths: Vector) -> float:
    """Update the position inside the backlash, for each of three widths, after a motion to x.

    Return the fraction of the three widths (0 to 1) for which the flanks do not touch.
    """
    loose = 0
    for which in range(3):
        half = 0.5 * widths[which]
        gap = min(max(state[GAPS + which] + (x - state[LAST_X]), -half), half)
        state[GAPS + which] = gap
        loose += direction * gap < half * (1.0 - ROUNDING)
    return loose / 3.0


@kernel
def friction_along(
    axes: Matrix,
    load: Vector,
    gap: Matrix,
    swing: float,
    factors: Matrix,
    zones: Matrix,
    falls: Matrix,
    quantile: float,
    x: Vector,
    v: Matrix,
    effort: Vector,
    warm: Matrix,
    state: Vector,
    out: Matrix,
) -> None:
    """Fill `out` (3, n) with value, low and high of the friction at each sample [N m | N].

    - axes: (3, EXTENDED_SIZE), parameters of the axis with nominal, least and largest viscous
      friction
    - load: array of plant/position_load.py
    - gap: (2, 3); the rows are the width of the backlash [rad | m] and the friction inside the
      backlash [N m | N], the columns are value, low and high
    - swing: inertia/(2 encoder steps); swing v^2 is the effort [N m | N] that stops the axis within
      one encoder step
    - factors: (3, 3); the rows are wear forward, wear backward and added friction, the columns
      value, low and high
    - zones: (k, 5), one row for each zone; the columns are start and end [rad | m], then value, low
      and high of the wear
    - falls: (n, 2), at each sample: friction that falls with speed and is not in the model, and its
      half width [N m | N]
    - quantile: quantile of the normal distribution for the intervals
    - x, effort: position [rad | m] and effort [N m | N], (n,)
    - v: (3, n), value, low and high of the velocity [rad/s | m/s]
    - warm: (2, n), factors of viscous and dry friction at the temperature of each sample
    - state: (STATE_SIZE,), updated in place
    """
    p = axes[0]
    # at rest: position, largest static friction forward and backward, load
    rest_position = math.nan
    forward = 0.0
    backward = 0.0
    loaded = 0.0
    for k in range(x.shape[0]):
        if state[KNOWN] == 0.0:
            state[LAST_X] = x[k]
            state[LAST_EFFORT] = effort[k]
            state[KNOWN] = 1.0
        speed, slowest, fastest = v[VALUE, k], v[LOW, k], v[HIGH, k]
        loose = _play(state, x[k], 1.0 if speed >= 0.0 else -1.0, gap[0])
        if slowest <= 0.0 <= fastest:
            if x[k] != rest_position:
                rest_position = x[k]
                loaded = p[OFFSET] + load_effort(load, x[k])
                forward, backward = (
                    _strongest(p, 1.0, rest_position, factors, zones),
                    _strongest(p, -1.0, rest_position, factors, zones),
                )
            held = effort[k] - loaded
            step = effort[k] - state[LAST_EFFORT]
            state[NOISE] += FORGET * (0.5 * step * step - state[NOISE])
            state[WEIGHT] += FORGET * (1.0 - state[WEIGHT])
            # effort that stops the axis within one count
            stopped = swing * max(-slowest, fastest) ** 2
            spread = math.hypot(quantile * math.sqrt(state[NOISE] / state[WEIGHT]), stopped)
            least = -warm[1, k] * backward
            most = warm[1, k] * forward
            value = min(max(held, least), most)
            low = min(max(held - spread, least), most)
            high = min(max(held + spread, least), most)
        else:
            value, low, high = _in_slip(
                axes,
                gap[1],
                x[k],
                speed,
                factors,
                zones,
                falls[k],
                loose,
                warm[0, k],
                warm[1, k],
            )
        out[VALUE, k], out[LOW, k], out[HIGH, k] = value, low, high
        state[LAST_X], state[LAST_EFFORT] = x[k], effort[k]
