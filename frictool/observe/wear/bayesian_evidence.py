"""What rows say of the parameters of a linear model, and how likely rows are under a belief about
them.

    rows = columns theta + errors       theta ~ N(mean, P), errors ~ N(0, 1)

with G = columns' columns, b = columns' effort, M = (P^-1 + G)^-1 = (I + P G)^-1 P, P that may be
singular (parameters that are tied together), and what fits best, G best = b:

    theta given the rows ~ N(mean + M (b - G mean), M)
    ln p(rows) = -1/2 ln det(I + G P) - 1/2 (best - mean)' (I + G P)^-1 G (best - mean) + const         const:
                                                                                                        of
                                                                                                        the
                                                                                                        rows
                                                                                                        alone

In this form nothing large is taken from anything large: what is compared are the distances of
beliefs from what fits best.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

Vector = NDArray[np.float64]

RANK = 1e-13  # of the largest eigenvalue: below it the rows tell nothing
NEGLIGIBLE = 1e-3  # of a mixture's weights


def posterior(gram: Vector, right: Vector, mean: Vector, belief: Vector) -> tuple[Vector, Vector]:
    """Mean (p,) and covariance (p, p) after the data; the belief may be singular."""
    spread: Vector = np.linalg.solve(np.eye(mean.size) + belief @ gram, belief).astype(np.float64)
    return mean + spread @ (right - gram @ mean), spread


def best_fit(gram: Vector, right: Vector) -> Vector:
    """What fits best (p,), the shortest of them where several do."""
    sizes, directions = np.linalg.eigh(gram)
    told = sizes > RANK * max(float(sizes[-1]), 0.0)
    along = directions[:, told]
    return np.asarray(along @ ((along.T @ right) / sizes[told]))


def evidences(gram: Vector, best: Vector, means: Vector, beliefs: Vector) -> Vector:
    """ln p (m,) of data (p, p) that `best` (p,) fits best under beliefs (m, p), (m, p, p), but for
    what all beliefs share."""
    off, whole = best - means, np.eye(best.size) + gram @ beliefs
    left = np.linalg.solve(whole, (off @ gram)[:, :, None])[:, :, 0]
    _, logarithms = np.linalg.slogdet(whole)
    return np.asarray(-0.5 * logarithms - 0.5 * np.sum(off * left, axis=1))


def mixture(
    gram: Vector, right: Vector, best: Vector, means: Vector, beliefs: Vector, beforehand: Vector
) -> tuple[Vector, Vector]:
    """Mean (p,) and covariance (p, p) after the data, of beliefs (m, p), (m, p, p), likely as
    `beforehand` (m,) says in logarithms."""
    weights = softmax(evidences(gram, best, means, beliefs) + beforehand)
    chosen = np.flatnonzero(weights > NEGLIGIBLE)
    shares = weights[chosen] / np.sum(weights[chosen])
    found = [posterior(gram, right, means[index], beliefs[index]) for index in chosen]
    theta = sum(
        (share * at for share, (at, _) in zip(shares, found, strict=True)), np.zeros_like(right)
    )
    spread = sum(
        (
            share * (own + np.outer(at - theta, at - theta))
            for share, (at, own) in zip(shares, found, strict=True)
        ),
        np.zeros_like(gram),
    )
    return theta, spread
