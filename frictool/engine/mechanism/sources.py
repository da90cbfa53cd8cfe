"""Drives of the sources during a call: limited commands through first-order lags."""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.runtime.kernels import bare_kernel
from frictool.typing import IntVector, Vector


@bare_kernel
def source_limits(k: IntVector, p: Vector, source: int, y: Vector) -> tuple[float, float]:
    """Return the lowest and highest drive that the limit and the winding of a source allow."""
    row = ly.source_row(k, source)
    speed = y[k[ly.BLOCKS] + ly.source_block(k, source)]
    low = -ly.limit(p, row)
    high = ly.limit(p, row)
    if ly.resistance(p, row) > 0.0:
        back = ly.constant(p, row) * speed
        low = max(low, (-ly.supply(p, row) - back) / ly.resistance(p, row))
        high = min(high, (ly.supply(p, row) - back) / ly.resistance(p, row))
    return low, high


@bare_kernel
def take_inputs(
    k: IntVector,
    p: Vector,
    command: Vector,
    external: Vector,
    y: Vector,
    drive: Vector,
    inputs: Vector,
) -> None:
    """Fill `inputs` with limited commands, drives, and external efforts on the blocks.

    The limits are computed for the speeds at the beginning of the call.
    """
    n, u = k[ly.BLOCKS], k[ly.SOURCES]
    for s in range(u):
        low, high = source_limits(k, p, s, y)
        inputs[s] = min(max(command[s], low), high)
        inputs[u + s] = (
            min(max(drive[s], low), high) if ly.lag(p, ly.source_row(k, s)) > 0.0 else inputs[s]
        )
    for i in range(n):
        inputs[2 * u + i] = external[i]


@bare_kernel
def flowing_at(k: IntVector, p: Vector, source: int, t: float, inputs: Vector) -> float:
    """Return the drive of a source at the time t [s] after the command was set."""
    lag = ly.lag(p, ly.source_row(k, source))
    target = inputs[source]
    before = inputs[k[ly.SOURCES] + source]
    return float(target if lag == 0.0 else target + (before - target) * math.exp(-t / lag))


@bare_kernel
def let_flow(k: IntVector, p: Vector, inputs: Vector, t: float, drive: Vector) -> None:
    """Fill `drive` (u,) with the drives of all sources, t [s] after the command was set."""
    for s in range(k[ly.SOURCES]):
        drive[s] = flowing_at(k, p, s, t, inputs)


@bare_kernel
def longest_step(k: IntVector, p: Vector, inputs: Vector) -> float:
    """Return the longest integration step [s]: half the shortest lag of all changing drives."""
    u = k[ly.SOURCES]
    longest = math.inf
    for s in range(u):
        lag = ly.lag(p, ly.source_row(k, s))
        if lag > 0.0 and inputs[s] != inputs[u + s]:
            longest = min(longest, 0.5 * lag)
    return longest


@bare_kernel
def is_steady(k: IntVector, inputs: Vector) -> bool:
    """Return True if all drives equal their commands."""
    u = k[ly.SOURCES]
    steady = True
    for s in range(u):
        steady = steady and inputs[s] == inputs[u + s]
    return steady
