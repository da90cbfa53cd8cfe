"""Friction laws at full count: the hybrid versions' stick-slip, presliding loops, Preisach against
relays.

Figures are those of thesis 3.7 on table 3.1, with the drivers of tests/friction: fixed steps,
nothing of the engine.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from frictool.friction.law_registry import LAWS
from frictool.friction.preisach import preisach_force, preisach_move
from frictool.friction.preisach_cycles import (
    cell_weights,
    everett_tail,
    masing_cycles,
    masing_everett,
)
from frictool.friction.reversal_memory import new_memory
from studies.rigs.table_3_1 import packed
from tests.support.law_drivers import (
    FORCE,
    MODE,
    SLIPPING,
    STUCK,
    VELOCITY,
    dynamic_run,
    hybrid_run,
    pointers,
)
from tests.support.plain_laws import Relays

EXACT_PERIOD = 6.5123  # s, event-exact
PUBLISHED = {
    "hybrid_a": (6.5124, 0.01),
    "hybrid_b": (6.5127, 0.01),
    "hybrid_c": (6.5119, 0.03),
}  # period [s], tolerance
CORNERS = np.array([0, 0.7, -0.7, 0.4, -0.2, 0.4, -0.7, 0.7, -0.7, 0.7, 1.2])  # z_max
LOOPS = {
    "lugre": (0.116, 0.377),
    "elasto_plastic": (0.0, 0.001),
    "hybrid_c": (0.0, 0.455),
}  # closure/F_s, area/(F_s z_max)
LEG, SLOW = 2000, 1e-6  # steps per movement, m/s


def stick_slip() -> dict[str, Any]:
    """A spring of 2 N/m pulled at 0.1 m/s for 60 s."""
    step = 2e-5
    pull = 0.2 * step * np.arange(round(60 / step) + 1)
    figures: dict[str, Any] = {}
    passed = True
    for name, (period, tolerance) in PUBLISHED.items():
        rows = hybrid_run(*pointers(LAWS[name].kernels), pull, 2.0, step, packed(LAWS[name]))
        starts = np.flatnonzero((rows[1:, MODE] == SLIPPING) & (rows[:-1, MODE] == STUCK)) * step
        found = float(np.diff(starts).mean())
        passed &= (
            len(starts) == 9
            and abs(found / period - 1) < tolerance
            and abs(rows[:, VELOCITY].max() / 0.381 - 1) < 0.02
        )
        figures |= {f"{name}_sticks": len(starts), f"{name}_period_s": found}
    return {"passed": bool(passed), **figures}


def presliding_path() -> np.ndarray:
    return (
        np.concatenate([np.linspace(a, b, LEG + 1)[1:] for a, b in itertools.pairwise(CORNERS)])
        * 1e-5
    )


def presliding_force(name: str, path: np.ndarray) -> np.ndarray:
    """Friction along the path, held so slowly that damping is nothing."""
    if name == "hybrid_c":
        memory, table, forces = new_memory(64), masing_everett(), []
        for place in path:
            forces.append(preisach_force(memory, place, table, 1.5, 1e-5))
            preisach_move(memory, place, table, 1e-5)
        return np.array(forces)
    steps = np.diff(path, prepend=0.0)
    velocities = np.append(steps, steps[-1]) / np.abs(steps).max() * SLOW
    half = np.repeat(velocities[:-1], 2)  # held for half a step, then led over to the next step's
    rows = dynamic_run(
        *pointers(LAWS[name].kernels),
        np.append(half, velocities[-1]),
        0.5 * np.abs(steps).max() / SLOW,
        packed(LAWS[name]),
    )
    return rows[2::2, FORCE]


def presliding() -> dict[str, Any]:
    """Closure of the inner loop 0.4, -0.2, 0.4 z_max, and area of the outer one, -0.7 to 0.7
    z_max."""
    path = presliding_path()
    figures: dict[str, Any] = {}
    passed = True
    for name, (closure, area) in LOOPS.items():
        force = presliding_force(name, path)
        outer = slice(7 * LEG - 1, 9 * LEG)
        closed = abs(force[3 * LEG - 1] - force[5 * LEG - 1]) / 1.5
        enclosed = abs(np.trapezoid(force[outer], path[outer])) / 1.5e-5
        passed &= (
            abs(closed - closure) < 0.01 * closure + 1e-3
            and abs(enclosed - area) < 0.03 * area + 1e-3
        )
        figures |= {f"{name}_closure": closed, f"{name}_area": enclosed}
    return {"passed": bool(passed), **figures}


def preisach_against_relays() -> dict[str, Any]:
    """2000 random paths of 40 movements on random distributions of 20 x 20 cells, against 3240
    relays."""
    draw, worst = np.random.default_rng(0), 0.0
    for path in range(2000):
        if path % 100 == 0:
            cycles = [
                (z, f + np.concatenate([[0.0], draw.normal(0, 0.1, f.size - 2), [0.0]]))
                for z, f in masing_cycles()
            ]
            table = everett_tail(cycles)
        relays, memory = Relays(cell_weights(table), 4), new_memory(64)
        for place in draw.integers(-40, 41, 40) / 40:
            found = preisach_force(memory, place, table, 1.0, 1.0)
            preisach_move(memory, place, table, 1.0)
            worst = max(worst, abs(found - relays.force(place)))
    return {"passed": worst < 1e-11, "worst": worst, "paths": 2000}


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "friction_stick_slip_of_hybrid_versions": stick_slip,
    "friction_presliding_loops": presliding,
    "friction_preisach_against_relays": preisach_against_relays,
}
