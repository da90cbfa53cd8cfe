"""Tolerances of the guards (mode_guards.py), and the guards of distances."""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.state import OPEN
from frictool.engine.mechanism.workspace_rows import GROSS
from frictool.runtime.kernels import bare_kernel
from frictool.typing import IntVector, Vector

SLACK = 1e-11  # tolerance of an effort, relative to the efforts on its block
LEAST_RATE = 1e-9  # 1/s, tolerance of an acceleration, relative to the speed scale
SPEED_SLACK = 1e-11  # tolerance of a speed, relative to the speed scale
PLACE_SLACK = 1e-10  # tolerance of a position, relative to the gap
ROUNDING = 1e-15  # rounding error of a position, relative to its terms


@bare_kernel
def slack_at(k: IntVector, p: Vector, w: Vector, block: int) -> float:
    """Return the force [N | N m] below which a force at the block counts as zero."""
    least = 1e-300  # smallest tolerance [N | N m], for a block without mass and efforts
    return float(
        SLACK * w[GROSS, block]
        + LEAST_RATE * ly.mass_of(k, p, block) * ly.speed_scale(k, p, block)
        + least
    )


@bare_kernel
def joint_gap(k: IntVector, p: Vector, joint: int, y: Vector) -> tuple[float, float, float]:
    """Return the position difference e of a joint's flanks, its rate e', and the tolerance of e.

    e is in the coordinate of block b, and is 0 in the middle of the backlash.
    """
    n = k[ly.BLOCKS]
    row = ly.joint_row(k, joint)
    ratio = ly.ratio(p, row)
    a, b = ly.joint_a(k, joint), ly.joint_b(k, joint)
    e = y[b] - ratio * y[a] - ly.offset(p, row)
    size = abs(y[b]) + abs(ratio * y[a]) + abs(ly.offset(p, row))
    return e, y[n + b] - ratio * y[n + a], PLACE_SLACK * ly.gap(p, row) + ROUNDING * size


@bare_kernel
def stop_slack(p: Vector, row: int) -> float:
    """Return the tolerance of the distance to a stop [rad | m]."""
    low, high = ly.low(p, row), ly.high(p, row)
    span = high - low
    if span == math.inf:
        span = abs(low) if low > -math.inf else abs(high)
    return float(PLACE_SLACK * 1e-2 * span + 1e-13)


@bare_kernel
def place_guards(k: IntVector, p: Vector, y: Vector, modes: IntVector, guard: Vector) -> None:
    """Set the guards of open flanks and stops: (distance to contact)/(its tolerance)."""
    n, j, c = k[ly.BLOCKS], k[ly.JOINTS], k[ly.COUPLINGS]
    for joint in range(j):
        if modes[n + joint] == OPEN:
            e, _, slack = joint_gap(k, p, joint, y)
            gap = ly.gap(p, ly.joint_row(k, joint))
            guard[n + joint] = min(e + gap, gap - e) / slack
    for s in range(k[ly.STOPS]):
        at = n + 2 * j + c + s
        if modes[at] == OPEN:
            block, row = ly.stop_block(k, s), ly.stop_row(k, s)
            guard[at] = min(y[block] - ly.low(p, row), ly.high(p, row) - y[block]) / stop_slack(
                p, row
            )
