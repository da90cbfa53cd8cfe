"""Rows of the weak form, sample by sample over a whole log.

The reference for frictool/observe/wear/weak_form_rows.py.
"""

from __future__ import annotations

import numpy as np

from frictool.observe.wear.weak_form_layout import WeakFormLayout
from frictool.typing import Vector


def carried(position: Vector, gap: float) -> list[int]:
    """1 or -1 where, wherever in its backlash the axis began, the motor has pushed through all of
    it in that direction; else 0."""
    out = [0] * position.size
    ends = np.array([-0.5 * gap, 0.5 * gap])
    for k in range(1, position.size):
        ends = np.clip(ends + position[k] - position[k - 1], -0.5 * gap, 0.5 * gap)
        step = np.sign(position[k] - position[k - 1])
        out[k] = int(step) if gap == 0.0 else int(ends[0] >= 0.5 * gap) - int(ends[1] <= -0.5 * gap)
    return out


def directions(position: Vector, layout: WeakFormLayout) -> list[int]:
    """Return, for each sample, the direction in which it slips for certain, or 0."""
    n, reach = position.size, layout.reach
    start = layout.window + reach  # before it, nothing is known of the gap
    pushed = [0] * start + carried(position[start - 1 :], layout.gap)[1:]
    out = [0] * n
    for k in range(start, n - reach):
        before, after = position[k] - position[k - reach], position[k + reach] - position[k]
        side = 1 if before > 0.0 else -1
        speeds = side * np.array([before, after]) / (reach * layout.period)
        fast = np.all(speeds >= layout.slowest * (1.0 - 1e-12)) and np.all(speeds <= layout.fastest)
        free = layout.stops[0] <= position[k] <= layout.stops[1]
        if fast and free and (layout.gap == 0.0 or pushed[k] == side):
            out[k] = side
    return out


def row(
    position: Vector,
    effort: Vector,
    last: int,
    side: int,
    layout: WeakFormLayout,
    factors: tuple[Vector, Vector] | None = None,
) -> Vector:
    """The columns and the effort (p + 1,) of the window that ends at `last`.

    factors: of viscous and dry friction at the temperature of each sample, (n,) each.
    """
    window, reach, period = layout.window, layout.reach, layout.period
    total = dict.fromkeys((*layout.names, "effort"), 0.0)
    for j in range(window):
        k = last - window + 1 + j
        thin, dry = (1.0, 1.0) if factors is None else (factors[0][k], factors[1][k])
        x, weight = position[k] + 0.5 * layout.count, layout.phi[j]
        speed = abs(position[k + reach] - position[k - reach]) / (2.0 * reach * period)
        velocity = (position[k + 1] - position[k - 1]) / (2.0 * period)
        zone = int(np.clip(np.searchsorted(layout.edges, x, side="right") - 1, 0, layout.zones - 1))
        name = "forward" if side > 0 else "backward"
        friction = max(
            0.0, np.polynomial.Polynomial(layout.dry[int(side > 0)])(np.clip(x, *layout.mapped))
        )
        for place, width in enumerate(layout.falls):
            total[f"fall_{place}"] += weight * side * dry * np.exp(-((speed / width) ** 2))
        total["inertia"] += layout.second[j] * (position[k] - position[last])
        total["viscous"] += weight * thin * velocity
        total["asymmetry"] += weight * side * thin * velocity
        for place, knee in enumerate(layout.knees):
            total[f"bend_{place}"] += weight * side * thin * max(speed - knee, 0.0)
        total[f"dry_{name}_{zone}"] += weight * side * dry * friction
        total[f"level_{name}"] += weight * side
        total["delay"] += weight * (effort[k + 1] - effort[k - 1]) / (2.0 * period)
        acting = float(layout.effort @ effort[k - 1 : k + 2])
        total["effort"] += weight * (acting - load(x, layout) - layout.offset)
    return np.array(list(total.values()))


def load(x: float, layout: WeakFormLayout) -> float:
    """Beside friction."""
    if layout.load.size == 0:
        return 0.0
    terms = layout.load[1:].reshape(-1, 3)
    return float(
        layout.load[0] * x
        + np.sum(terms[:, 1] * np.sin(terms[:, 0] * x) + terms[:, 2] * np.cos(terms[:, 0] * x))
    )


def grams(
    position: Vector,
    effort: Vector,
    layout: WeakFormLayout,
    rest: float,
    most: int,
    factors: tuple[Vector, Vector] | None = None,
) -> list[tuple[Vector, int]]:
    """The Gram matrix and the number of rows of each move."""
    out: list[tuple[Vector, int]] = []
    rows: list[Vector] = []
    run = idle = moving = 0
    last = 0
    for k, side in enumerate(directions(position, layout)):
        run = run + 1 if side != 0 and side == last else int(side != 0)
        idle = 0 if side else idle + 1
        last = side
        if rows and (
            (side == 0 and idle >= rest * layout.window) or side == -moving or len(rows) >= most
        ):
            out.append((np.transpose(rows) @ np.array(rows), len(rows)))
            rows = []
        if side and run >= layout.window and (run - layout.window) % layout.every == 0:
            moving = moving if rows else side
            rows.append(row(position, effort, k, side, layout, factors))
    return [*out, (np.transpose(rows) @ np.array(rows), len(rows))] if rows else out
