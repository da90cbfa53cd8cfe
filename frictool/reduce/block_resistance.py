"""Resistance of one block to steady motion as a function of its position: load and friction.

    effort that moves the block forward    C_+(x) = S(x) + F(x)
                                backward   C_-(x) = S(x) - F(x)        thesis (2.28)

The load S is the effort of springs, cams and constant efforts. The friction F is the Coulomb
friction in slip, or the breakaway at rest. S and F are computed from the arrays of the simulation
engine, so that they have the same values as in a simulation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.friction.law_registry import ROWS
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.packed_mechanism import FRAME, Curves, PackedMechanism
from frictool.typing import Vector


@dataclass(frozen=True)
class SpeedDependentFriction:
    """Speed-dependent part of the friction of one element.

    drop: breakaway minus Coulomb friction [N m | N]; at speed v, the friction in slip is the
        Coulomb friction plus drop exp(-(v/velocity)^exponent).
    viscous: coefficient of viscous friction [N m s/rad | N s/m].
    """

    drop: float
    velocity: float  # rad/s | m/s; 0: drop at rest only
    exponent: float
    viscous: float
    law: str


@dataclass(frozen=True)
class BlockResistance:
    """Resistance of a block at n positions; all vectors are (n,) [N m | N].

    load: effort of springs, cams and constant efforts.
    friction: Coulomb friction.
    pressed_breakaway: breakaway, without the speed-dependent friction in `falling`.
    falling: speed-dependent parts of the friction, which do not depend on the position.
    damping: sum of the damping of the springs between block and frame.
    """

    load: Vector
    friction: Vector
    pressed_breakaway: Vector
    falling: tuple[SpeedDependentFriction, ...]
    damping: float

    @property
    def breakaway(self) -> Vector:
        """Return the breakaway (n,), including the friction in `falling`."""
        return self.pressed_breakaway + sum(one.drop for one in self.falling)

    @property
    def viscous(self) -> float:
        """Return the damping of the springs plus all coefficients of viscous friction."""
        return self.damping + sum(one.viscous for one in self.falling)


def resisting(assembled: AssembledMechanism, block: int, x: Vector) -> BlockResistance:
    """Return the load and friction of one block at positions x (n,) [rad | m]."""
    packed = assembled.packed
    friction, breakaway, falling = _frictions(packed, block, x)
    pressings = packed.pressings
    for k in np.flatnonzero(pressings.block == block):
        pressed = pressings.coefficient[k] * curve_at(packed.curves, int(pressings.force[k]), x)
        friction = friction + pressed
        breakaway = breakaway + pressings.breakaway_ratio[k] * pressed
    load, damping = _loads(packed, block, x)
    return BlockResistance(load, friction, breakaway, falling, damping)


def curve_at(curves: Curves, number: int, x: Vector) -> Vector:
    """Return curve `number` at the positions x (n,); the curve is constant outside its range."""
    first = int(curves.start[number])
    last = int(curves.start[number + 1])
    breaks = curves.breaks[first + number : last + number + 1]
    clipped = np.clip(x, breaks[0], breaks[-1])
    piece = np.clip(np.searchsorted(breaks, clipped, side="right") - 1, 0, last - first - 1)
    offset = clipped - breaks[piece]
    cubic = curves.cubic[first + piece]
    return np.asarray(
        ((cubic[:, 3] * offset + cubic[:, 2]) * offset + cubic[:, 1]) * offset + cubic[:, 0]
    )


def _loads(packed: PackedMechanism, block: int, x: Vector) -> tuple[Vector, float]:
    load = np.zeros_like(x)
    damping = 0.0
    couplings, pushes = packed.couplings, packed.pushes
    for k in np.flatnonzero((couplings.b == block) & (couplings.a == FRAME)):
        e = x - couplings.offset[k]
        gap = couplings.gap[k]
        load = load + couplings.stiffness[k] * (e - np.clip(e, -gap, gap))
        if couplings.curve[k] >= 0:
            load = load + curve_at(packed.curves, int(couplings.curve[k]), e)
        damping += float(couplings.damping[k]) if gap == 0.0 else 0.0
    for k in np.flatnonzero(pushes.block == block):
        load = load - pushes.constant[k]
        if pushes.curve[k] >= 0:
            load = load - curve_at(packed.curves, int(pushes.curve[k]), x)
    return load, damping


def _frictions(
    packed: PackedMechanism, block: int, x: Vector
) -> tuple[Vector, Vector, tuple[SpeedDependentFriction, ...]]:
    frictions = packed.frictions
    falling = []
    slip = np.zeros_like(x)
    for k in np.flatnonzero(frictions.block == block):
        law = ROWS[int(frictions.law[k])]
        p = frictions.law_values[int(frictions.law_start[k]) : int(frictions.law_start[k + 1])]
        values = {
            parameter.name: float(value)
            for parameter, value in zip(law.parameters, p, strict=False)
        }
        level = (
            curve_at(packed.curves, int(frictions.level[k]), x)
            if frictions.level[k] >= 0
            else np.ones_like(x)
        )
        coulomb = values["coulomb"]
        slip = slip + coulomb * level
        mean = float(np.mean(level))
        drop = mean * max(0.0, values.get("breakaway", coulomb) - coulomb)
        falling.append(
            SpeedDependentFriction(
                drop,
                values.get("stribeck_velocity", 0.0),
                values.get("stribeck_exponent", 2.0),
                mean * values.get("viscous", 0.0),
                law.name,
            )
        )
    return slip, slip.copy(), tuple(falling)
