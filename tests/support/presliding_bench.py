"""A SIMULATED bench with a fine encoder: slow loops of the effort below the breakaway, with LuGre,
elasto-plastic or Maxwell-slip contacts.

The contact is integrated with the axis's inertia and a damping; nothing of frictool's
identification is used.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from frictool.friction.virgin_curve import virgin_force
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

INERTIA, DAMPING = (
    1e-5,
    0.4,
)  # kg m^2, N m s/rad; no ringing after a step of the held effort, under which LuGre would drift
BREAKAWAY = 1.5  # N m
PERIOD, SUBSTEPS = 1e-3, 20
BRANCH = 2.0  # s
TURNS = (
    0.7,
    -0.7,
    0.85,
    -0.8,
    0.92,
    -0.9,
    0.6,
    -0.92,
    0.93,
    -0.5,
    0.8,
    -0.93,
    0.9,
)  # of the breakaway

Z_MAX, STIFFNESS = 1e-3, BREAKAWAY / 1e-3  # rad, N m/rad
Z_BA = 0.4 * Z_MAX


def _elements() -> tuple[Vector, Vector]:
    """Yield displacements and stiffnesses of ten elements through a parabola."""
    z = Z_MAX * np.arange(1, 11) / 10.0
    slopes = np.diff(BREAKAWAY * (1.0 - (1.0 - z / Z_MAX) ** 2), prepend=0.0) / (0.1 * Z_MAX)
    return z, -np.diff(slopes, append=0.0)


MAXWELL = _elements()
TRUTHS: dict[str, Vector] = {
    "lugre": np.array([STIFFNESS, BREAKAWAY]),
    "elasto_plastic": np.array([STIFFNESS, BREAKAWAY, Z_BA]),
    "maxwell_slip": np.concatenate(MAXWELL),
}


def curve(displacement: float) -> float:
    """The virgin curve of MAXWELL, N m."""
    return float(np.sum(MAXWELL[1] * np.minimum(displacement, MAXWELL[0])))


@kernel
def _contact(z: Vector, moved: float, values: Vector, law: int) -> float:
    """Moves the contact's state `z` in place; returns its force. law 0: LuGre, 1: elasto-plastic,
    2: Maxwell elements."""
    if law == 2:
        count, total = z.shape[0], 0.0
        for i in range(count):
            z[i] = min(max(z[i] + moved, -values[i]), values[i])
            total += values[count + i] * z[i]
        return total
    stiffness, breakaway = values[0], values[1]
    limit = breakaway / stiffness
    alpha = 1.0
    if law == 1:
        size = abs(z[0])
        if size < values[2] or z[0] * moved <= 0.0:
            alpha = 0.0
        elif size < limit:
            alpha = (
                0.5 * math.sin(math.pi * (size - 0.5 * (limit + values[2])) / (limit - values[2]))
                + 0.5
            )
    z[0] += moved - alpha * abs(moved) * z[0] / limit
    return stiffness * z[0]


@kernel
def _play(effort: Vector, values: Vector, law: int, states: int, out: Vector) -> None:
    z, x, v, step = np.zeros(states), 0.0, 0.0, PERIOD / SUBSTEPS
    force = 0.0
    for k in range(effort.shape[0]):
        out[k] = x
        for _ in range(SUBSTEPS):
            v = (v + step * (effort[k] - force) / INERTIA) / (1.0 + step * DAMPING / INERTIA)
            x += step * v
            force = _contact(z, step * v, values, law)


def slow_loops(
    law: str, seed: int, count: float, turns: tuple[float, ...] = TURNS, noise: float = 0.003
) -> MotionRecord:
    """A record of loops of a law of TRUTHS; count: of the encoder, rad; turns, noise: of the effort
    over the breakaway."""
    values = TRUTHS[law]
    generator = np.random.default_rng([seed, 31])
    n = round(BRANCH / PERIOD)
    ends = np.concatenate(([0.0], turns)) * BREAKAWAY
    effort = np.concatenate(
        [np.linspace(a, b, n, endpoint=False) for a, b in itertools.pairwise(ends)]
    )
    x = np.empty(effort.size)
    _play(
        effort, values, list(TRUTHS).index(law), values.size // 2 if law == "maxwell_slip" else 1, x
    )
    seen = np.floor(x / count + generator.random()) * count
    measured = effort + noise * BREAKAWAY * generator.standard_normal(effort.size)
    return make_record("loops", np.arange(x.size) * PERIOD, seen, measured, count, 0.0)


COUNT = Z_MAX / 200.0


def centred_cycles(repeats: int, noise: float, seed: int = 4, phase: float = 0.0) -> MotionRecord:
    """Ten growing centred cycles of the Masing hysteresis of the parabola, 3.7.1, again and again;
    the first from the virgin curve.

    phase: where in a count the encoder's zero lies, 0 to 1.
    """
    position, force, last = [0.0], [0.0], 0.0
    for top in np.tile(np.arange(1, 11) / 10.0, repeats):
        reach, fall = virgin_force(top * Z_MAX, BREAKAWAY, Z_MAX), np.linspace(top, -top, 400)
        position += [*np.linspace(last, top, 400)[1:-1], *fall]
        force += [
            *np.linspace(force[-1], reach, 400)[1:-1],
            *(reach + 2.0 * virgin_force(0.5 * (z - top) * Z_MAX, BREAKAWAY, Z_MAX) for z in fall),
        ]
        last = -top
    x, generator = np.array(position) * Z_MAX, np.random.default_rng(seed)
    seen, effort = (
        np.rint(x / (0.2 * COUNT) + phase) * 0.2 * COUNT,
        np.array(force) + noise * BREAKAWAY * generator.standard_normal(x.size),
    )
    return make_record("cycles", np.arange(x.size) * PERIOD, seen, effort, 0.2 * COUNT, 0.0)
