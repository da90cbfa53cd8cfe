"""Drives of the sources during a call: limited commands, and drives that lag behind them."""

from __future__ import annotations

import math

from frictool.engine.mechanism.compiled_mechanism import (
    BLOCKS,
    CONSTANT,
    LAG,
    LIMIT,
    RESISTANCE,
    SOURCE,
    SOURCE_BLOCKS,
    SOURCE_WIDTH,
    SOURCES,
    SUPPLY,
)
from frictool.runtime.kernels import inset_kernel
from frictool.typing import IntVector, Vector


@inset_kernel
def source_limits(k: IntVector, p: Vector, source: int, y: Vector) -> tuple[float, float]:
    """Return the lowest and highest drive of a source, by its limit and its winding's.

    The winding's limit depends on the speed.
    """
    row, speed = k[SOURCE] + source * SOURCE_WIDTH, y[k[BLOCKS] + k[k[SOURCE_BLOCKS] + source]]
    low, high = -p[row + LIMIT], p[row + LIMIT]
    if p[row + RESISTANCE] > 0.0:
        back = p[row + CONSTANT] * speed
        low = max(low, (-p[row + SUPPLY] - back) / p[row + RESISTANCE])
        high = min(high, (p[row + SUPPLY] - back) / p[row + RESISTANCE])
    return low, high


@inset_kernel
def take_inputs(
    k: IntVector,
    p: Vector,
    command: Vector,
    external: Vector,
    y: Vector,
    drive: Vector,
    inputs: Vector,
) -> None:
    """Fill `inputs` with limited commands, drives, and efforts held on blocks.

    The limits are those of the speeds at the beginning.
    """
    n, u = k[BLOCKS], k[SOURCES]
    for s in range(u):
        low, high = source_limits(k, p, s, y)
        inputs[s] = min(max(command[s], low), high)
        inputs[u + s] = (
            min(max(drive[s], low), high)
            if p[k[SOURCE] + s * SOURCE_WIDTH + LAG] > 0.0
            else inputs[s]
        )
    for i in range(n):
        inputs[2 * u + i] = external[i]


@inset_kernel
def flowing_at(k: IntVector, p: Vector, source: int, t: float, inputs: Vector) -> float:
    """Return the drive of a source t [s] after its command."""
    lag = p[k[SOURCE] + source * SOURCE_WIDTH + LAG]
    target, before = inputs[source], inputs[k[SOURCES] + source]
    return float(target if lag == 0.0 else target + (before - target) * math.exp(-t / lag))


@inset_kernel
def let_flow(k: IntVector, p: Vector, inputs: Vector, t: float, drive: Vector) -> None:
    """Fill `drive` with the drive of each source t [s] after its command."""
    for s in range(k[SOURCES]):
        drive[s] = flowing_at(k, p, s, t, inputs)


@inset_kernel
def longest_step(k: IntVector, p: Vector, inputs: Vector) -> float:
    """Return the longest step [s] in which the drives are approximated well by polynomials."""
    u, longest = k[SOURCES], math.inf
    for s in range(u):
        lag = p[k[SOURCE] + s * SOURCE_WIDTH + LAG]
        if lag > 0.0 and inputs[s] != inputs[u + s]:
            longest = min(longest, 0.5 * lag)
    return longest


@inset_kernel
def is_steady(k: IntVector, inputs: Vector) -> bool:
    """Return True if all drives equal their commands."""
    u, steady = k[SOURCES], True
    for s in range(u):
        steady = steady and inputs[s] == inputs[u + s]
    return steady
