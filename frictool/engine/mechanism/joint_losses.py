"""Force g(lambda) at the driving end a of a lossy joint, for a force lambda at the load end b.

    g(lambda) = ratio lambda + loss = ratio kink + (lambda - kink) (ratio + c)

The module also contains the inverse of g, and the ranges of both forces at rest. The joint has the
parameters ratio, drive_loss, back_loss, thread and thesis_screw. The kink is the force lambda at
which the slope of g changes. c has the sign of s (lambda - kink), where s is the direction of
motion of end a.

- Link with an efficiency (thesis 2.3, 2.20): the kink is 0. abs(c) is drive_loss if end a drives,
  and back_loss if end b drives.
- Screw of the thesis (2.12)-(2.13), (2.15): the kink is thesis_screw u_a/thread, where u_a is the
  effort of the sources on block a. abs(c) is thread.

If the load can drive the joint, g is a rising function of (ratio lambda).
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.runtime.kernels import bare_kernel
from frictool.typing import Vector


@bare_kernel
def is_lossy(p: Vector, row: int) -> bool:
    """Return True if the joint has losses."""
    return bool(
        ly.drive_loss(p, row) != 0.0 or ly.back_loss(p, row) != 0.0 or ly.thread(p, row) != 0.0
    )


@bare_kernel
def is_self_locking(p: Vector, row: int) -> bool:
    """Return True if the load end b of the joint cannot drive the driving end a."""
    return bool(max(ly.back_loss(p, row), ly.thread(p, row)) > abs(ly.ratio(p, row)))


@bare_kernel
def kink_of(p: Vector, row: int, driven: float) -> float:
    """Return the force [N | N m] at load end b at which the slope of a joint's loss changes.

    `driven` is the effort of the sources on block a.
    """
    return ly.thesis_screw(p, row) * driven / ly.thread(p, row) if ly.thread(p, row) > 0.0 else 0.0


@bare_kernel
def slope_of(p: Vector, row: int, direction: float, above: bool) -> float:
    """Return d(force at end a)/d(force at end b) on one side of the kink of the loss.

    - direction: direction of motion of end a
    - above: True for the side with the larger force at end b
    """
    ratio, drive, back = ly.ratio(p, row), ly.drive_loss(p, row), ly.back_loss(p, row)
    if ly.thread(p, row) > 0.0:
        return float(ratio + (direction if above else -direction) * ly.thread(p, row))
    if (ratio * direction > 0.0) == above:
        return float(ratio + (direction if above else -direction) * drive)
    return float(ratio + (direction if above else -direction) * back)


@bare_kernel
def transmitted(p: Vector, row: int, kink: float, direction: float, force: float) -> float:
    """Return the force [N | N m] at the driving end a for a `force` at load end b.

    direction: direction of motion of end a.
    """
    slope = slope_of(p, row, direction, force > kink)
    if force == kink or slope == 0.0:
        return float(ly.ratio(p, row) * kink)
    return float(ly.ratio(p, row) * kink + (force - kink) * slope)


@bare_kernel
def received(p: Vector, row: int, kink: float, direction: float, effort: float) -> float:
    """Return the force [N | N m] at load end b for a force `effort` at driving end a."""
    ratio = ly.ratio(p, row)
    beyond = effort - ratio * kink
    if beyond == 0.0:
        return kink
    return float(kink + beyond / slope_of(p, row, direction, beyond * ratio > 0.0))


@bare_kernel
def range_at_driver(
    p: Vector, row: int, kink: float, low: float, high: float
) -> tuple[float, float]:
    """Return the lowest and highest force at end a for which a joint at rest stays at rest.

    low, high: range of the force at end b. At an end stop, one limit of this range is infinite. An
    infinite force is transmitted without loss, so that a stop does not wedge a self-locking link.
    """
    least = math.inf
    most = -math.inf
    for side in range(2):
        direction = 2.0 * side - 1.0
        for point in range(3):
            force = low if point == 0 else high if point == 1 else kink
            if low <= force <= high:
                g = (
                    transmitted(p, row, kink, direction, force)
                    if math.isfinite(force)
                    else ly.ratio(p, row) * force
                )
                least, most = min(least, g), max(most, g)
    return least, most


@bare_kernel
def range_at_load(p: Vector, row: int, kink: float, low: float, high: float) -> tuple[float, float]:
    """Return the lowest and highest force at end b for which a joint at rest stays at rest.

    low, high: range of the force at end a. Infinite forces are treated as in `range_at_driver`.
    """
    least = math.inf
    most = -math.inf
    for side in range(2):
        direction = 2.0 * side - 1.0
        for point in range(3):
            effort = low if point == 0 else high if point == 1 else ly.ratio(p, row) * kink
            if low <= effort <= high:
                force = (
                    received(p, row, kink, direction, effort)
                    if math.isfinite(effort)
                    else effort * ly.ratio(p, row)
                )
                least, most = min(least, force), max(most, force)
    return least, most
