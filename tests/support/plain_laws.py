"""The laws once more, plain and slow, straight from the printed equations as
docs/theory/friction.md reads them."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np


def sign(x: float) -> float:
    return float(np.sign(x))


def stribeck_curve(v: float, q: dict[str, float]) -> float:
    ratio = abs(v / q["stribeck_velocity"])
    fallen = math.exp(-(ratio ** q["stribeck_exponent"])) if ratio < 1e3 else 0.0
    return q["coulomb"] + (q["breakaway"] - q["coulomb"]) * fallen


def static_force(name: str, v: float, q: dict[str, float]) -> float:
    """Friction in slip."""
    if name == "coulomb_tanh":
        return q["coulomb"] * math.tanh(v / q["smoothing_velocity"])
    if name == "coulomb_atan":
        return q["coulomb"] * math.atan2(v, q["smoothing_velocity"]) / (math.pi / 2)
    dry = stribeck_curve(v, q) if name == "stribeck" else q["coulomb"]
    return dry * sign(v) + q.get("viscous", 0.0) * v


def presliding_rate(name: str, z: float, v: float, q: dict[str, float]) -> float:
    """z' of the laws whose state is one number."""
    if name == "dahl":
        a = 1 - q["stiffness"] * z * sign(v) / q["coulomb"]
        return v * abs(a) ** q["exponent"] * sign(a)
    g, sigma_0 = stribeck_curve(v, q), q["stiffness"]
    if name == "lugre":
        return v - sigma_0 * abs(v) / g * z
    z_max, z_ba = q["breakaway"] / sigma_0, q["elastic_limit"]
    if sign(v) != sign(z) or abs(z) < z_ba:
        alpha = 0.0
    elif abs(z) < z_max:
        alpha = 0.5 * (math.sin(math.pi * (abs(z) - (z_max + z_ba) / 2) / (z_max - z_ba)) + 1)
    else:
        alpha = 1.0
    return v * (1 - alpha * sigma_0 / g * sign(v) * z)


def presliding_force(name: str, z: float, zdot: float, v: float, q: dict[str, float]) -> float:
    return q["stiffness"] * z + q.get("damping", 0.0) * zdot + q.get("viscous", 0.0) * v


class Masing:
    """Rules I and II of annex A on any virgin curve, from the whole history of turning points."""

    def __init__(self, virgin: Any) -> None:
        self.virgin, self.path = virgin, [0.0]

    def force(self, z: float) -> float:
        """Moves to z; the force follows from the reversals of the path that later extremes leave
        alone."""
        self.path.append(z)
        left = self.main_reversals(self.path)
        if len(left) == 1:
            return float(self.virgin(left[0]))
        total = self.virgin(left[0])
        for before, after in itertools.pairwise(left):
            total += 2 * self.virgin((after - before) / 2)
        return float(total)

    @staticmethod
    def main_reversals(path: list[float]) -> list[float]:
        """The largest excursion, then the opposite extreme after it, then the extreme after that
        ... until now."""
        sizes = [abs(z) for z in path]
        start = len(sizes) - 1 - sizes[::-1].index(max(sizes))
        left = [path[start]]
        while start < len(path) - 1:
            rest = path[start + 1 :]
            extreme = min(rest) if len(left) % 2 == (left[0] > 0) else max(rest)
            start += len(rest) - rest[::-1].index(extreme)
            left.append(extreme)
        return left


class Relays:
    """A Preisach operator as relays, `split` x `split` of them in each cell; on the diagonal
    `split` relays of no width."""

    def __init__(self, weights: np.ndarray, split: int) -> None:
        cells = weights.shape[0]
        places = (np.arange(cells * split) + 0.5) * 2 / (cells * split) - 1
        up, down = np.meshgrid(places, places, indexing="ij")
        share = np.kron(weights, np.full((split, split), 1 / split**2))
        for cell in range(cells):
            block = slice(cell * split, (cell + 1) * split)
            share[block, block] = np.eye(split) * weights[cell, cell] / split
        keep = up >= down
        self.up, self.down, self.share = up[keep], down[keep], share[keep]
        tilt = self.up + self.down
        self.state = np.where(np.abs(tilt) < 1e-9, 0.0, -np.sign(tilt))

    def force(self, z: float) -> float:
        self.state[self.up < z] = 1.0
        self.state[self.down > z] = -1.0
        return float(self.share @ self.state)
