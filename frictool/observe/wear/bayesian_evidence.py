"""Posterior of a linear model's parameters, and evidence of the data under a prior.

    effort = C theta + errors           prior theta ~ N(mean, P), errors ~ N(0, 1)

C is the matrix of the data rows. Let G = C' C, b = C' effort, M = (P^-1 + G)^-1 = (I + P G)^-1 P,
and let `best` be the least-squares fit, G best = b. P may be singular, because a prior may require
that parameters are equal. Then

    theta given the rows ~ N(mean + M (b - G mean), M)
    ln p(effort) = -1/2 ln det(I + G P)
                 - 1/2 (best - mean)' (I + G P)^-1 G (best - mean) + const

where const depends on the rows only. This form is numerically accurate: it contains the distance of
the prior mean from the best fit, and no difference of large numbers.
"""

from __future__ import annotations

import numpy as np
import scipy

from frictool.typing import Vector

RANK = 1e-13  # smallest eigenvalue that is used, relative to the largest
NEGLIGIBLE = 1e-3  # weight below which a component of a mixture is not used


def posterior(gram: Vector, right: Vector, mean: Vector, belief: Vector) -> tuple[Vector, Vector]:
    """Return the posterior mean (p,) and covariance (p, p) of the parameters.

    - gram, right: C' C and C' effort with the matrix C of the data rows
    - mean, belief: mean and covariance of the prior
    """
    spread: Vector = np.linalg.solve(np.eye(mean.size) + belief @ gram, belief).astype(np.float64)
    return mean + spread @ (right - gram @ mean), spread


def best_fit(gram: Vector, right: Vector) -> Vector:
    """Return the solution (p,) of gram @ fit = right with the smallest norm."""
    sizes, directions = np.linalg.eigh(gram)
    determined = sizes > RANK * max(float(sizes[-1]), 0.0)
    along = directions[:, determined]
    return np.asarray(along @ ((along.T @ right) / sizes[determined]))


def evidences(gram: Vector, best: Vector, means: Vector, beliefs: Vector) -> Vector:
    """Return the logarithms (m,) of the evidence of the data under m priors, up to a constant.

    - gram: (p, p), C' C
    - best: (p,), least-squares fit
    - means (m, p), beliefs (m, p, p): means and covariances of the priors
    """
    off = best - means
    whole = np.eye(best.size) + gram @ beliefs
    left = np.linalg.solve(whole, (off @ gram)[:, :, None])[:, :, 0]
    _, logarithms = np.linalg.slogdet(whole)
    return np.asarray(-0.5 * logarithms - 0.5 * np.sum(off * left, axis=1))


def posterior_means(gram: Vector, right: Vector, means: Vector, beliefs: Vector) -> Vector:
    """Return the posterior means (m, p) under m priors; `beliefs`: prior covariances (m, p, p)."""
    off = (right - means @ gram)[:, :, None]
    return means + np.linalg.solve(np.eye(right.size) + beliefs @ gram, beliefs @ off)[:, :, 0]


def mixture(
    gram: Vector, right: Vector, best: Vector, means: Vector, beliefs: Vector, beforehand: Vector
) -> tuple[Vector, Vector]:
    """Return the posterior mean (p,) and covariance (p, p) under a mixture of m priors.

    - gram: (p, p), C' C
    - right: (p,), C' effort
    - best: (p,), least-squares fit
    - means (m, p), beliefs (m, p, p): means and covariances of the priors
    - beforehand: (m,), logarithms of the weights of the priors
    """
    weights = scipy.special.softmax(evidences(gram, best, means, beliefs) + beforehand)
    chosen = np.flatnonzero(weights > NEGLIGIBLE)
    shares = weights[chosen] / np.sum(weights[chosen])
    posteriors = [posterior(gram, right, means[index], beliefs[index]) for index in chosen]
    theta = sum(
        (share * at for share, (at, _) in zip(shares, posteriors, strict=True)),
        np.zeros_like(right),
    )
    spread = sum(
        (
            share * (covariance + np.outer(at - theta, at - theta))
            for share, (at, covariance) in zip(shares, posteriors, strict=True)
        ),
        np.zeros_like(gram),
    )
    return theta, spread
