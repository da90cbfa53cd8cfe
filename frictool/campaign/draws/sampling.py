"""Draws: points (n, d) in the unit cube; the same seed gives the same draws.

- random: independent and uniform; the first draws do not change when more are drawn
- latin: Latin hypercube (McKay, Beckman and Conover 1979); the range of each factor is divided
  into n equal intervals, and each interval contains one draw at a random position
- vertices: all vertices, or a random subset of them
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from frictool.typing import Vector

Method = Literal["random", "latin", "vertices"]
MOST_VERTICES = 4096
RANDOM_STREAM = (1 << 33) + 1
LATIN_STREAM = (1 << 33) + 2
VERTICES_STREAM = (1 << 33) + 3
NOISE_STREAM = (1 << 33) + 4


class UnitDraws(NamedTuple):
    """Draws of a campaign.

    `units` (n, d): n points in the unit cube of d factors.
    `corners`: number of all vertices of the cube for the method `vertices`, else 0.
    """

    units: Vector
    corners: int = 0


def draws_of(method: Method, count: int | None, factors: int, seed: int) -> UnitDraws:
    """Draw `count` points in the unit cube of `factors` factors.

    For the method `vertices`, the points are vertices of the cube. If `count` is None, this method
    returns all vertices, but at most MOST_VERTICES. The other methods need `count`.
    """
    if method == "vertices":
        corners = 2**factors
        return UnitDraws(
            _vertices(min(corners, MOST_VERTICES if count is None else count), factors, seed),
            corners,
        )
    if count is None:
        raise ValueError("random draws and a Latin hypercube need a number of draws")
    return UnitDraws(
        _random(count, factors, seed) if method == "random" else _latin(count, factors, seed)
    )


def noise_seed(seed: int, draw: int) -> int:
    """Return the seed of the noise in the trial of a draw."""
    high, low = np.random.SeedSequence([seed, NOISE_STREAM, draw]).generate_state(2)
    return (int(high) >> 1 << 32) | int(low)


def _random(count: int, factors: int, seed: int) -> Vector:
    return np.random.Generator(np.random.PCG64([seed, RANDOM_STREAM])).random((count, factors))


def _latin(count: int, factors: int, seed: int) -> Vector:
    generator = np.random.Generator(np.random.PCG64([seed, LATIN_STREAM]))
    parts = (
        np.stack([generator.permutation(count) for _ in range(factors)], axis=1)
        if factors
        else np.empty((count, 0))
    )
    points: Vector = (parts + generator.random((count, factors))) / count
    return points


def _vertices(count: int, factors: int, seed: int) -> Vector:
    if count >= 2**factors:
        numbers = np.arange(2**factors)[:, None]
        return np.array((numbers >> np.arange(factors)[::-1]) & 1, dtype=np.float64)
    generator = np.random.Generator(np.random.PCG64([seed, VERTICES_STREAM]))
    corners: dict[bytes, Vector] = {}
    while len(corners) < count:
        corner = generator.integers(0, 2, factors).astype(np.float64)
        corners.setdefault(corner.tobytes(), corner)
    return np.stack(list(corners.values()))
