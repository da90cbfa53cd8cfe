"""Response of rigidly joined blocks to an impulse, with losses in the joints.

The loss of a joint is proportional to the transmitted force and therefore takes a fraction of an
impulse. The impulse grows from zero in small increments (Routh 1860). Each increment changes the
speeds as a force does, and the losses have the signs of the current speeds. As long as no speed
reaches zero, the change of speed per unit of impulse is constant. It equals the acceleration that a
unit effort in place of the impulse would cause without other efforts: the zero of Lambda
(engine/mechanism/tree_solver.py). A self-locking group at rest stays at rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.joint_losses import is_lossy, received, slope_of, transmitted
from frictool.engine.mechanism.workspace_rows import SLOPE, VALUE
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

MAX_PIECES = 200  # largest number of linear pieces of Lambda that a search visits
FOUND = 1e-14  # tolerance of a zero, relative to the impulse


@bare_kernel
def is_group_lossy(k: IntVector, p: Vector, group: int) -> bool:
    """Return True if a rigid joint inside the group has losses."""
    for joint in range(k[ly.JOINTS]):
        row = ly.joint_row(k, joint)
        if is_lossy(p, row):
            a, b = ly.joint_a(k, joint), ly.joint_b(k, joint)
            if ly.group_of(k, a) == group and ly.group_of(k, b) == group:
                return True
    return False


class Group(NamedTuple):
    """Group of rigidly joined blocks, with the block on which an impulse acts.

    - k, p: compiled mechanism (array_layout.py)
    - group: first block of the group
    - w: work array with the rows of workspace_rows.py
    """

    k: IntVector
    p: Vector
    group: int
    block: int
    w: Vector


@part_kernel
def _need(hit: Group, impulse: float, towards: float, x: float) -> None:
    k, p, group, block, w = hit
    n = k[ly.BLOCKS]
    for i in range(n):
        if ly.group_of(k, i) == group:
            along = ly.group_ratio(k, p, i) * ly.mass_of(k, p, i)
            w[VALUE, i] = along * x
            w[SLOPE, i] = along
    w[VALUE, block] -= impulse
    for index in range(n - 1, -1, -1):
        i = ly.block_at(k, index)
        if ly.group_of(k, i) != group or i == group:
            continue
        parent = ly.parent_of(k, i)
        row = ly.joint_row(k, ly.joint_of(k, i))
        if ly.outward(k, i) == 1:
            direction = math.copysign(1.0, towards * ly.group_ratio(k, p, parent))
            force = w[VALUE, i]
            w[SLOPE, parent] += w[SLOPE, i] * slope_of(p, row, direction, force > 0.0)
            w[VALUE, parent] += transmitted(p, row, 0.0, direction, force)
        else:
            direction = math.copysign(1.0, towards * ly.group_ratio(k, p, i))
            force = received(p, row, 0.0, direction, -w[VALUE, i])
            w[SLOPE, parent] += w[SLOPE, i] / slope_of(p, row, direction, force > 0.0)
            w[VALUE, parent] -= force


@bare_kernel
def _search(hit: Group, impulse: float, towards: float, start: float) -> float:
    k, p, group, block, w = hit
    low = -math.inf
    high = math.inf
    x = start
    for _ in range(MAX_PIECES):
        _need(hit, impulse, towards, x)
        value, slope = w[VALUE, group], w[SLOPE, group]
        if abs(value) <= FOUND * abs(impulse * ly.group_ratio(k, p, block)):
            return x if slope > 0.0 else math.nan
        if value > 0.0:
            high = min(high, x)
        else:
            low = max(low, x)
        after = x - value / slope if slope > 0.0 else math.nan
        if not low < after < high:
            if math.isinf(low) or math.isinf(high):
                return math.nan
            after = 0.5 * (low + high)
        if after == x:
            return x if slope > 0.0 else math.nan
        x = after
    return math.nan


@bare_kernel
def _by_direction(hit: Group, row: int, force: float, towards: float, lossy: bool) -> float:
    k, p, group, block, _ = hit
    impulse = force
    if row >= 0:
        direction = math.copysign(1.0, towards * ly.group_ratio(k, p, block))
        impulse = -force * slope_of(p, row, direction, force > 0.0)
    free = impulse * ly.group_ratio(k, p, block) / ly.group_mass(k, p, group)
    if not lossy or impulse == 0.0:
        return float(free)
    x = _search(hit, impulse, towards, free)
    return _search(hit, impulse, towards, 0.0) if math.isnan(x) else x


@part_kernel
def yielding(hit: Group, row: int, force: float, speed: float, lossy: bool) -> float:
    """Return the speed change of a group's first block per unit of impulse.

    - force: ±1, sign of the impulse
    - speed: present speed of the first block
    - row: -1 if the impulse acts on `hit.block`. Otherwise the impulse acts on the load end b of
      the joint in this row, and `hit.block` is at end a
    - lossy: True if a rigid joint inside the group has losses

    The result is NaN if the group jams.
    """
    if speed != 0.0:
        return _by_direction(hit, row, force, math.copysign(1.0, speed), lossy)
    for side in range(2):
        towards = 2.0 * side - 1.0
        x = _by_direction(hit, row, force, towards, lossy)
        if x * towards > 0.0:
            return x
    return 0.0
