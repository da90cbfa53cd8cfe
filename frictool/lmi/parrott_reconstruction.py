"""Explicit controller of a plant for given Lyapunov blocks (R, S), by Parrott's lemma.

The lemma replaces the optimisation of the controller in thesis (5.62)-(5.63). With
P = [S, -G; -G, G] and G = S - R^-1, the bounded-real lemma in discrete time becomes
|Phi + U K V| < 1. K contains the controller's matrices; Phi, U and V follow from plant and P. This
is Parrott's problem. Its central solution is explicit (Davis, Kahan and Weinberger, 1982).

A continuous plant is first made discrete (Cayley transform): the same P solves both bounded-real
inequalities. D12 = 0 and D21 = 0 are allowed; the formula fails only if [R I; I S] is singular.

P depends on (R, S) alone, so that the controllers of all vertices have the same state coordinates.
For constant B2, C2, D12 and D21 the inequalities are affine in plant and controller together. They
therefore hold for any barycentric sum of these controllers (5.64).
"""

from __future__ import annotations

import numpy as np
import scipy

from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.typing import Matrix

# tried steps h in the frame's unit of time; for at least one step, 1/h is far from unstable poles
CAYLEY_STEPS = (1.0, 0.7, 0.5)


def central(plant: GeneralisedPlant, r: Matrix, s: Matrix, gamma: float) -> Lti:
    """Return the central controller for the Lyapunov blocks R = `r`, S = `s` and the norm `gamma`.

    The controller has the order and the time domain of the plant.

    Raises NoSolutionError if (R, S) do not admit a controller to working precision.
    """
    if plant.period:
        return _discrete(
            plant, r, s, gamma, np.zeros((len(plant.c2), plant.b2.shape[1])), plant.period
        )
    identity = np.eye(len(plant.a))
    h = max(CAYLEY_STEPS, key=lambda step: float(np.linalg.norm(identity - step * plant.a, -2)))
    mapped, d22 = _cayley(plant, h)
    k = _discrete(mapped, r, s, gamma, d22, 1.0)
    inverse = np.linalg.inv(k.a + identity)
    root = np.sqrt(2.0 / h)
    return Lti(
        (k.a - identity) @ inverse / h,
        root * inverse @ k.b,
        root * k.c @ inverse,
        k.d - k.c @ inverse @ k.b,
        0.0,
    )


def _cayley(p: GeneralisedPlant, h: float) -> tuple[GeneralisedPlant, Matrix]:
    identity = np.eye(len(p.a))
    inverse = np.linalg.inv(identity - h * p.a)
    root = np.sqrt(2.0 * h)
    mapped = GeneralisedPlant(
        inverse @ (identity + h * p.a),
        root * inverse @ p.b1,
        root * inverse @ p.b2,
        root * p.c1 @ inverse,
        root * p.c2 @ inverse,
        p.d11 + h * p.c1 @ inverse @ p.b1,
        p.d12 + h * p.c1 @ inverse @ p.b2,
        p.d21 + h * p.c2 @ inverse @ p.b1,
        1.0,
    )
    return mapped, h * p.c2 @ inverse @ p.b2


def _discrete(
    p: GeneralisedPlant, r: Matrix, s: Matrix, gamma: float, d22: Matrix, period: float
) -> Lti:
    n = len(p.a)
    n_w = p.b1.shape[1]
    n_z = len(p.c1)
    n_u = p.b2.shape[1]
    n_y = len(p.c2)
    gap = s - np.linalg.inv(r)
    big = np.block([[s, -gap], [-gap, gap]])
    values, vectors = np.linalg.eigh(0.5 * (big + big.T))
    if values[0] <= 0.0:
        raise NoSolutionError(
            "the Lyapunov matrix of the synthesis is not positive; raise `recentring` or relax "
            "the weights"
        )
    root = vectors @ np.diag(np.sqrt(values)) @ vectors.T
    root_inverse = vectors @ np.diag(values**-0.5) @ vectors.T
    left = scipy.linalg.block_diag(root, np.eye(n_z) / np.sqrt(gamma))
    right = scipy.linalg.block_diag(root_inverse, np.eye(n_w) / np.sqrt(gamma))
    zero = np.zeros
    phi = (
        left
        @ np.block(
            [[p.a, zero((n, n)), p.b1], [zero((n, 2 * n + n_w))], [p.c1, zero((n_z, n)), p.d11]]
        )
        @ right
    )
    u = left @ np.block(
        [[zero((n, n)), p.b2], [np.eye(n), zero((n, n_u))], [zero((n_z, n)), p.d12]]
    )
    v = np.block([[zero((n, n)), np.eye(n), zero((n, n_w))], [p.c2, zero((n_y, n)), p.d21]]) @ right
    k = parrott(phi, u, v)
    # k was computed for the measurement y - d22 u: solve u = k (y - d22 u) for u
    direct = np.linalg.inv(np.eye(n_u) + k[n:, n:] @ d22)
    c, d = direct @ k[n:, :n], direct @ k[n:, n:]
    return Lti(k[:n, :n] - k[:n, n:] @ d22 @ c, k[:n, n:] - k[:n, n:] @ d22 @ d, c, d, period)


def parrott(phi: Matrix, u: Matrix, v: Matrix) -> Matrix:
    """Return the central solution K of |phi + u K v| < 1; raise NoSolutionError if there is none.

    u must have full column rank and v full row rank.
    """
    q_u, r_u = np.linalg.qr(u, mode="complete")
    q_v, r_v = np.linalg.qr(v.T, mode="complete")
    m, k = u.shape[1], v.shape[0]
    turned = q_u.T @ phi @ q_v
    corner = turned[:m, :k]
    b = turned[:m, k:]
    c = turned[m:, :k]
    a = turned[m:, k:]
    reach = max(np.linalg.norm(np.vstack([b, a]), 2), np.linalg.norm(np.hstack([c, a]), 2))
    if reach >= 1.0:
        raise NoSolutionError(
            f"no controller exists for the computed Lyapunov matrix (norm {reach:.6g} >= 1); raise "
            "`recentring` or relax the weights"
        )
    completed = -b @ np.linalg.solve(np.eye(a.shape[1]) - a.T @ a, a.T @ c)
    solution = np.linalg.solve(r_u[:m], np.linalg.solve(r_v[:k], (completed - corner).T).T)
    if not np.linalg.norm(phi + u @ solution @ v, 2) < 1.0:
        raise NoSolutionError(
            "the computed controller exceeds the bound for which it was computed; raise "
            "`recentring` or relax the weights"
        )
    return np.asarray(solution)
