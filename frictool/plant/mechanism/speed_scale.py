"""Typical speed of each block, to which the tolerances of a simulation are relative."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from frictool.friction.parameter import Axis
from frictool.plant.mechanism.element_error import ElementError
from frictool.typing import Vector

SLOWEST, FASTEST = 1e-12, 1e12  # limits of the ratio of the speeds of two linked blocks
RISE_S = 0.01  # s, time in which the largest effort of the sources reaches the typical speed
# rad/s, m/s: typical speed if neither a top speed nor a limit is known
DEFAULT: dict[Axis, float] = {"rotary": 1.0, "linear": 0.1}


def speed_scale(
    inertia: Sequence[float],
    kinds: Sequence[Axis],
    ratios: Sequence[tuple[int, int, float]],
    pushed: Sequence[tuple[int, float]],
    known: tuple[int, float] | None,
    names: Sequence[str],
) -> Vector:
    """Return the typical speeds (n,) [rad/s | m/s] of the blocks.

    - ratios: (a, b, speed of b divided by speed of a) for the blocks a and b of every link
    - pushed: (block, largest effort) of every source
    - known: one block and its top speed; None if no top speed is known

    In each connected part of the mechanism, one block determines the speeds of all others by the
    link ratios. The speed of this block is its top speed or, if this is unknown, the speed that the
    largest effort reaches within RISE_S. If no effort is known either, this speed is DEFAULT.
    Raises ElementError if the speeds differ too much.
    """
    count = len(inertia)
    neighbours: list[list[tuple[int, float]]] = [[] for _ in range(count)]
    for a, b, ratio in ratios:
        neighbours[a].append((b, abs(ratio)))
        neighbours[b].append((a, 1.0 / abs(ratio)))
    scale = np.zeros(count)
    order = [] if known is None else [known[0]]
    for root in [*order, *range(count)]:
        if scale[root] > 0.0:
            continue
        part = _spread(root, neighbours)
        check_speeds(part, root, names)
        if known is not None and known[0] in part:
            speed = known[1] / part[known[0]]
        else:
            speed = _reached(part, inertia, pushed) or DEFAULT[kinds[root]]
        for block, ratio in part.items():
            scale[block] = speed * ratio
    return scale


def _spread(root: int, neighbours: list[list[tuple[int, float]]]) -> dict[int, float]:
    part = {root: 1.0}
    queue = [root]
    for here in queue:
        for there, ratio in neighbours[here]:
            if there not in part:
                part[there] = part[here] * ratio
                queue.append(there)
    return part


def _reached(
    part: dict[int, float], inertia: Sequence[float], pushed: Sequence[tuple[int, float]]
) -> float:
    total = sum(ratio**2 * inertia[block] for block, ratio in part.items())
    effort = max(
        (
            part[block] * effort
            for block, effort in pushed
            if block in part and math.isfinite(effort)
        ),
        default=0.0,
    )
    return effort / total * RISE_S if total > 0.0 else 0.0


def check_speeds(ratios: dict[int, float], root: int, names: Sequence[str]) -> None:
    """Raise ElementError if (speed of a block)/(speed of `root`) is too large or too small."""
    for block, ratio in ratios.items():
        if not SLOWEST <= abs(ratio) <= FASTEST:
            finding = (
                f"by the link ratios, its speed is {abs(ratio):g} times the speed of {names[root]}"
            )
            raise ElementError(
                f"blocks.{names[block]}", f"{finding}; allowed: {SLOWEST:g} to {FASTEST:g} times"
            )
