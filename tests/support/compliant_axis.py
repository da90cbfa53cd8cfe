"""Axis whose drive train yields before the axis breaks away, and its breakaway ramps.

At rest, a spring and a damper connect the axis to the ground. If the force of the spring reaches
the breakaway, the spring lets go, and the friction of a Stribeck curve with the exponent 2 acts. If
the axis stops, the spring holds it, with a force equal to the Coulomb friction.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.plant.axis import AxisParameters
from frictool.runtime.kernels import kernel
from frictool.typing import Vector
from tests.identify.arm import PERIOD
from tests.support.stribeck_rigs import PAUSE, Ramps

SUBSTEPS = 10
DAMPING = 0.7  # damping ratio of the axis on its spring


@kernel
def _play(
    axis: Vector, test: Vector, stiffness: float, noise: Vector, position: Vector, effort: Vector
) -> None:
    """Fill `position` (n,) [counts] and `effort` (n,) [N m | N]; `noise` (n,) [counts] is added to
    the position before it is rounded to counts."""
    inertia, viscous, coulomb, breakaway, step, stribeck = axis
    rate, counts, span = test
    damper, h = 2.0 * DAMPING * math.sqrt(stiffness * inertia), PERIOD / SUBSTEPS
    x, v, anchor, stuck = 0.3 * step, 0.0, 0.3 * step, True
    level, side, before, pause = 0.0, 1.0, 0.0, 0
    for k in range(position.size):
        count = math.floor(x / step + noise[k])
        position[k], effort[k] = count, side * level
        for _ in range(SUBSTEPS):
            if stuck:
                force = stiffness * (x - anchor)
                v = (inertia * v + h * (side * level - force)) / (
                    inertia + h * damper + h * h * stiffness
                )
                x += h * v
                stuck = abs(stiffness * (x - anchor)) < breakaway
            else:
                way = math.copysign(1.0, v)
                left = math.exp(-((v / stribeck) ** 2)) if stribeck > 0.0 else 0.0
                friction = coulomb + (breakaway - coulomb) * left
                after = v + h / inertia * (side * level - way * friction - viscous * v)
                stuck = after * way <= 0.0
                v = 0.0 if stuck else after
                x += h * v
                anchor = x - way * coulomb / stiffness
        if pause > 0:
            pause, before = pause - 1, count
        elif abs(count - before) >= counts:
            level, pause = 0.0, PAUSE
            side = -1.0 if x > span else 1.0 if x < -span else side
        else:
            level += rate * PERIOD


def play(
    axis: AxisParameters, ramps: Ramps, samples: int, seed: int, counts: float, sensor: float = 0.0
) -> tuple[Vector, Vector]:
    """Return the position (n,) by the encoder and the measured effort (n,) of ramps to and fro.

    Before it breaks away, the axis yields by so many `counts` of the encoder. `sensor` is the
    standard deviation of the noise of the encoder in counts.
    """
    step = axis.encoder_step
    draw = np.random.default_rng(seed)
    position, effort = np.empty(samples), np.empty(samples)
    _play(
        np.array(
            [
                axis.inertia,
                axis.viscous,
                axis.coulomb,
                axis.breakaway,
                step,
                axis.laws.stribeck_velocity,
            ]
        ),
        np.array([ramps.rate, ramps.counts, max(15.0 * step, ramps.span)]),
        axis.breakaway / (counts * step),
        sensor * draw.standard_normal(samples),
        position,
        effort,
    )
    return step * position, effort + ramps.noise * draw.standard_normal(samples)
