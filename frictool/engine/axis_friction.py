"""Friction of an axis with `AxisLaws` (plant/axis_friction_laws.py).

This friction depends on the direction, speed, position and time at rest. The speed w >= 0 is
measured in the direction of motion. A knee is a speed at which the viscous coefficient changes. The
Stribeck layer is the range of low speeds in which friction falls with speed. The limit between two
speed ranges is lower for an axis that slows down than for an axis that speeds up. This hysteresis
keeps an axis from changing back and forth between two ranges without end.
"""

from __future__ import annotations

import math

from frictool.friction.position_kernels import polynomial
from frictool.friction.rising_breakaway import dwell_factor
from frictool.plant import axis as ax
from frictool.plant import axis_friction_laws as al
from frictool.runtime.kernels import inner_kernel, kernel
from frictool.typing import Vector

# parameters of an axis with laws, None if it has none; numba compiles both cases separately
Laws = Vector | None

# speed at which a slowing axis passes a knee, or enters the Stribeck layer, relative to the speed
# of the knee or the layer
BELOW_KNEE = 1.0 - 2.0**-40
BELOW_LAYER = 0.98
NOWHERE, MAP_EDGE, END_STOP = 0, 1, 2


@kernel
def _side(direction: float) -> int:
    return 1 if direction > 0.0 else 0


@kernel
def _mapped(p: Vector, maps: int, direction: float, x: float) -> float:
    first = maps + al.MAX_TERMS * _side(direction)
    return polynomial(p[first : first + al.MAX_TERMS], min(max(x, p[al.MAP_LOW]), p[al.MAP_HIGH]))


@kernel
def coulomb_at(p: Vector, direction: float, x: float) -> float:
    """Return the Coulomb friction [N m | N] at position x; p: axis parameters with `AxisLaws`."""
    return (
        _mapped(p, al.COULOMB_MAPS, direction, x)
        if p[al.MAPPED] > 0.0
        else p[al.COULOMB_PAIR + _side(direction)]
    )


@kernel
def _rested_breakaway(p: Vector, direction: float, x: float) -> float:
    return (
        _mapped(p, al.BREAKAWAY_MAPS, direction, x)
        if p[al.MAPPED] > 0.0
        else p[al.BREAKAWAY_PAIR + _side(direction)]
    )


@kernel
def strength(p: Vector, direction: float, x: float) -> tuple[float, float]:
    """Return the parameters (full, fresh) of the breakaway friction at position x.

    - full [N m | N]: breakaway friction after a long rest
    - fresh: breakaway friction just after a stop, divided by full; fresh * full is at least the
      Coulomb friction
    - p: parameters of the axis, with `AxisLaws`
    """
    full = _rested_breakaway(p, direction, x)
    fresh = max(p[al.FRESH], coulomb_at(p, direction, x) / full) if full > 0.0 else 1.0
    return full, fresh


@kernel
def breakaway_at(p: Vector, direction: float, x: float, rested: float) -> float:
    """Return the breakaway friction [N m | N] at position x after `rested` [s] at rest.

    p: parameters of the axis, with `AxisLaws`.
    """
    full, fresh = strength(p, direction, x)
    return full * dwell_factor(rested, fresh, p[al.RISE_TIME])


@inner_kernel
def at_edge(state: Vector, p: Vector, direction: float) -> bool:
    """Return True if the backlash is closed in `direction`: the motor then moves the load."""
    return bool(direction * state[ax.GAP] >= 0.5 * p[ax.BACKLASH])


@inner_kernel
def threshold(state: Vector, p: Vector, laws: Laws, direction: float) -> float:
    """Return the largest effort [N m | N] in `direction` under which the axis stays at rest.

    The result is infinite if the axis touches the end stop in this direction.
    """
    if laws is not None and distance_to_stop(laws, state[ax.POSITION], direction) <= 0.0:
        return math.inf
    if not at_edge(state, p, direction):
        return float(p[ax.BACKLASH_BREAKAWAY])
    if laws is not None:
        return breakaway_at(laws, direction, state[ax.POSITION], state[ax.RESTED])
    return float(p[ax.BREAKAWAY])


@kernel
def distance_to_stop(p: Vector, x: float, direction: float) -> float:
    """Return the distance [rad | m] from x to the end stop in `direction`."""
    return float(direction * (p[al.STOP_PAIR + _side(direction)] - x))


@kernel
def next_boundary(p: Vector, x: float, direction: float) -> tuple[float, int]:
    """Return the distance [rad | m] from x to the next boundary in `direction`, and its kind.

    The boundary is an end stop (kind END_STOP), or an end of the range in which polynomials
    describe the friction over position (kind MAP_EDGE).
    """
    length = distance_to_stop(p, x, direction)
    kind = END_STOP
    if p[al.MAPPED] > 0.0:
        near, far = (
            (p[al.MAP_LOW], p[al.MAP_HIGH]) if direction > 0.0 else (p[al.MAP_HIGH], p[al.MAP_LOW])
        )
        edge = direction * ((near if direction * (near - x) > 0.0 else far) - x)
        if 0.0 < edge < length:
            length, kind = edge, MAP_EDGE
    return length, kind


@kernel
def is_curved(state: Vector, p: Vector, direction: float) -> bool:
    """Return True if the friction at a state depends on position, or nonlinearly on speed.

    p: parameters of the axis, with `AxisLaws`. The backlash must be closed.
    """
    if abs(state[ax.VELOCITY]) < p[al.LAYER]:
        return True
    low, high = direction * p[al.MAP_LOW], direction * p[al.MAP_HIGH]
    if p[al.MAPPED] == 0.0:
        return False
    return bool(min(low, high) <= direction * state[ax.POSITION] < max(low, high))


def is_straight(p: Vector, load: Vector) -> bool:
    """Return True if the motion of the axis in slip always has a closed form.

    This requires friction that is independent of the position and piecewise linear in the speed,
    and no load.

    - p: parameters of the axis
    - load (l,): array of plant/position_load.py
    """
    if load.shape[0] > 0:
        return False
    if p.shape[0] == al.PLAIN_SIZE:
        return True
    return bool(p[al.LAYER] == 0.0 and p[al.MAPPED] == 0.0 and p[al.DYNAMIC_SIZE] == 0.0)


@kernel
def straight_line(p: Vector, direction: float, w: float) -> tuple[float, float]:
    """Return (a, b) such that the friction is Coulomb friction + a + b w + Stribeck term.

    a is in N m | N, b in N m s/rad | N s/m. Both are valid in the speed range that contains the
    speed w [rad/s | m/s].
    """
    added = 0.0
    viscous = p[al.VISCOUS_PAIR + _side(direction)]
    for row in range(al.REGIMES, al.COULOMB_MAPS, al.REGIME_SIZE):
        if w < p[row]:
            break
        beyond = p[row + 1 + _side(direction)]
        added += (viscous - beyond) * p[row]
        viscous = beyond
    return added, viscous


@kernel
def speed_band(p: Vector, w: float) -> tuple[float, float]:
    """Return (low, high), the interval of speeds around w in which friction is smooth in speed."""
    lower = 0.0
    upper = math.inf
    for row in range(al.REGIMES, al.COULOMB_MAPS, al.REGIME_SIZE):
        if w < p[row]:
            upper = p[row]
            break
        lower = BELOW_KNEE * p[row]
    if w < p[al.LAYER]:
        return lower, min(upper, p[al.LAYER])
    return max(lower, BELOW_LAYER * p[al.LAYER]), upper


@inner_kernel
def slip_line(
    state: Vector, p: Vector, laws: Laws, direction: float, driving: bool
) -> tuple[float, float]:
    """Return (c, b) such that the friction at the present speed w is c + b w + Stribeck term.

    - driving: True if the backlash is closed, so that the motor moves the load
    - laws: `p` if the axis has `AxisLaws`, else None
    """
    if not driving:
        return p[ax.BACKLASH_COULOMB], 0.0
    if laws is not None:
        added, viscous = straight_line(laws, direction, abs(state[ax.VELOCITY]))
        return coulomb_at(laws, direction, state[ax.POSITION]) + added, viscous
    return p[ax.COULOMB], p[ax.VISCOUS]


@kernel
def has_stribeck(p: Vector) -> bool:
    """Return True if the axis has a Stribeck layer, in which the friction falls with speed."""
    return bool(p[al.STRIBECK_VELOCITY] > 0.0)
