"""A plain reference for starts from rest: Gauss's principle of least constraint, every face of the
problem tried.

Of all accelerations a that the contacts allow, the motion has the least  sum (m a^2/2 - f a + level
|a|): convex, so that the least of the minima over all faces that lie in the allowed set is it. No
losses in joints, breakaway equal to Coulomb's friction.
"""

from __future__ import annotations

import itertools

import numpy as np

from frictool.typing import Vector
from studies.rigs.mechanism_builder import Builder

CLOSE = 1e-9


def accelerations(b: Builder, efforts: Vector, levels: Vector, sides: list[int]) -> Vector:
    """sides: of each joint, 0 rigid, -1 the second block can be pushed forward, +1 backward.
    Returns a (n,)."""
    n = len(b.inertia)
    rows = np.zeros((len(b.joints), n))
    for row, joint in zip(rows, b.joints, strict=True):
        row[joint["b"]], row[joint["a"]] = 1.0, -joint["ratio"]
    mass, best, least = np.diag(b.inertia), np.zeros(n), np.inf
    flanks = [i for i, side in enumerate(sides) if side != 0]
    for signs in itertools.product((-1, 0, 1), repeat=n):
        for closed in itertools.product((False, True), repeat=len(flanks)):
            held = [rows[i] for i, side in enumerate(sides) if side == 0]
            held += [rows[i] for i, shut in zip(flanks, closed, strict=True) if shut]
            held += [np.eye(n)[i] for i in range(n) if signs[i] == 0]
            c = np.array(held).reshape(-1, n)
            kkt = np.block([[mass, c.T], [c, np.zeros((len(c), len(c)))]])
            right = np.concatenate([efforts - levels * np.array(signs), np.zeros(len(c))])
            a = np.linalg.lstsq(kkt, right, rcond=None)[0][:n]
            allowed = all(-sides[i] * rows[i] @ a >= -CLOSE for i in flanks) and all(
                s * x >= -CLOSE for s, x in zip(signs, a, strict=True)
            )
            cost = float(0.5 * a @ mass @ a - efforts @ a + levels @ np.abs(a))
            if allowed and np.all(np.abs(c @ a) < CLOSE) and cost < least:
                best, least = a, cost
    return best
