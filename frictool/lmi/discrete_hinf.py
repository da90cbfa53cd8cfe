"""Discrete-time H-infinity synthesis over a polytope with one Lyapunov matrix (theorem 5.3.1 in discrete time), by elimination.

Vocabulary: R, S the two blocks of the Lyapunov matrix (X, Y in (5.61)); gamma the bound on the norm from w to z; N_R, N_S bases of the
null spaces of [B2' D12'] and [C2 D21]. A controller exists for every vertex exactly when (Gahinet and Apkarian, 1994)

    [N_R 0]' [ A R A' - R   A R C1'             B1      ] [N_R 0]
    [0   I]  [ C1 R A'      C1 R C1' - gamma I  D11     ] [0   I] < 0        and its dual in S,       [R I; I S] >= 0.
             [ B1'          D11'                -gamma I]

Conditioning decides whether the solver's answer means anything (not the solver's status): the problem is solved several times in
coordinates in which R and S are equal and diagonal, then recentred: at gamma somewhat above the optimum the smallest R and S are sought,
then the largest distance of [R I; I S] from singular, so that the controller that they define has bounded coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cholesky, null_space, svd

from frictool.errors import NoSolutionError
from frictool.lmi.sdp import Affine, Vector, solve, symmetric, upper_triangle
from frictool.plant.generalised import GeneralisedPlant
from frictool.plant.lti import Lti

Matrix = NDArray[np.float64]
BALANCING_PASSES = 4
INFEASIBLE = frozenset({"PrimalInfeasible", "DualInfeasible", "AlmostPrimalInfeasible", "AlmostDualInfeasible"})
TRACE_SLACK = 1.5  # how far above the smallest trace(R + S) the recentring may go


@dataclass(frozen=True)
class Lyapunov:
    """R, S in the coordinates x = t x_balanced, the optimum gamma, and the gamma >= optimum at which R and S hold."""

    r: Matrix
    s: Matrix
    t: Matrix
    optimum: float
    gamma: float


def minimise(plants: Sequence[GeneralisedPlant], recentring: float) -> Lyapunov:
    """The smallest gamma over all plants with one (R, S), then (R, S) recentred at `recentring` times it.

    Raises NoSolutionError where the inequalities are infeasible or the solver gives nothing usable.
    """
    t = _first_scaling(plants)
    for balancing in range(2 * BALANCING_PASSES + 1):
        problem = _Problem([plant.transformed(t) for plant in plants])
        optimum, r, s, holds = problem.recentred(recentring)
        if holds and balancing >= BALANCING_PASSES:
            break
        t = t @ _balancing(r, s)
    else:
        raise NoSolutionError(
            f"the matrix inequalities do not hold where the solver stopped (gamma {recentring * optimum:.4g}); "
            "raise `recentring` or relax the weights"
        )
    return Lyapunov(r, s, t, optimum, recentring * optimum)


def _first_scaling(plants: Sequence[GeneralisedPlant], sweeps: int = 20) -> Matrix:
    """Diagonal t that evens out what flows into and out of each state (Osborne's balancing with inputs and outputs)."""
    n = plants[0].a.shape[0]
    whole = np.max([np.abs(np.block([[p.a, p.b1, p.b2], [p.c1, p.d11, p.d12], [p.c2, p.d21, np.zeros((1, 1))]])) for p in plants], axis=0)
    scale = np.ones(n)
    for _ in range(sweeps):
        for k in range(n):
            others = np.arange(whole.shape[0]) != k
            into = float(np.linalg.norm(whole[k, np.arange(whole.shape[1]) != k]))
            out_of = float(np.linalg.norm(whole[others, k]))
            if into > 0.0 and out_of > 0.0:
                factor = np.sqrt(into / out_of)
                whole[k] /= factor
                whole[:, k] *= factor
                scale[k] *= factor
    return np.diag(scale)


def _balancing(r: Matrix, s: Matrix) -> Matrix:
    """t with t^-1 R t^-T = t' S t diagonal."""
    root_r = cholesky(r + 1e-12 * np.trace(r) * np.eye(len(r)), lower=True)
    root_s = cholesky(s + 1e-12 * np.trace(s) * np.eye(len(s)), lower=True)
    _, values, v = svd(root_s.T @ root_r)
    return np.asarray(root_r @ v.T @ np.diag(values**-0.5))


class _Problem:
    """The inequalities in one set of coordinates; the decision vector is (R, S, last), last being gamma or b."""

    def __init__(self, plants: Sequence[GeneralisedPlant]) -> None:
        first = plants[0]
        for plant in plants[1:]:
            same = [
                np.allclose(p, q) for p, q in ((plant.b2, first.b2), (plant.c2, first.c2), (plant.d12, first.d12), (plant.d21, first.d21))
            ]
            if not all(same):
                raise ValueError("B2, C2, D12 and D21 must be the same at every vertex (5.61)")
        self.plants = plants
        self.n = first.a.shape[0]
        self.half = self.n * (self.n + 1) // 2
        self.null_r = null_space(np.hstack([first.b2.T, first.d12.T]))
        self.null_s = null_space(np.hstack([first.c2, first.d21]))

    def blocks(self, x: Matrix) -> tuple[Matrix, Matrix]:
        """R and S of decision vectors."""
        return symmetric(x[..., : self.half], self.n), symmetric(x[..., self.half : 2 * self.half], self.n)

    def recentred(self, recentring: float) -> tuple[float, Matrix, Matrix, bool]:
        """The optimum gamma; R, S at `recentring` times it; and whether they satisfy the inequalities by our own check.

        Raises NoSolutionError where the solver finds no finite point at all.
        """
        objective = np.zeros(2 * self.half + 1)
        objective[-1] = 1.0
        found = solve(objective, [*self._bounded_real(None), lambda x: self._coupling(x, np.ones(len(x)))])
        optimum = float(found.x[-1])
        if not np.isfinite(optimum) or optimum <= 0.0 or found.status in INFEASIBLE:
            raise NoSolutionError(f"no controller satisfies the matrix inequalities (solver: {found.status}); relax the weights")
        bounded = self._bounded_real(np.sqrt(recentring) * optimum)  # inside, so that the inequalities are strict at the gamma asked
        identity = np.eye(self.n)[upper_triangle(self.n)]
        trace = np.concatenate([identity, identity, [0.0]])
        smallest = solve(trace, [*bounded, lambda x: self._coupling(x, np.ones(len(x)))])
        limit = TRACE_SLACK * float(trace @ smallest.x)
        push = -np.eye(trace.shape[0])[-1]
        widest = solve(push, [*bounded, lambda x: self._coupling(x, x[:, -1]), lambda x: (limit - x @ trace)[:, None, None]])
        best = widest if widest.holds and widest.x[-1] > 1.0 else smallest
        return optimum, *self.blocks(best.x), best.holds

    def _coupling(self, x: Matrix, b: Vector) -> Matrix:
        r, s = self.blocks(x)
        side = b[:, None, None] * np.eye(self.n)
        return np.block([[r, side], [side, s]])

    def _bounded_real(self, gamma: float | None) -> list[Affine]:
        """The two inequalities of every plant, as matrices that must be positive; `gamma` None takes it from the decision vector."""
        constraints: list[Affine] = []
        for p in self.plants:
            constraints.append(self._one(p.a, p.b1, p.c1, p.d11, self.null_r, 0, gamma))
            constraints.append(self._one(p.a.T, p.c1.T, p.b1.T, p.d11.T, self.null_s, 1, gamma))
        return constraints

    def _one(self, a: Matrix, b: Matrix, c: Matrix, d: Matrix, null: Matrix, block: int, gamma: float | None) -> Affine:
        stacked, inner = np.vstack([a, c]), a.shape[0] + c.shape[0]
        outer = block_diag(null, np.eye(b.shape[1]))
        fixed = np.zeros((inner + b.shape[1],) * 2)
        fixed[:inner, inner:] = np.vstack([b, d])
        fixed += fixed.T
        level = np.diag(np.concatenate([np.zeros(a.shape[0]), np.ones(c.shape[0] + b.shape[1])]))

        def positive(x: Matrix) -> Matrix:
            variable = self.blocks(x)[block]
            whole = fixed - (x[:, -1] if gamma is None else np.full(len(x), gamma))[:, None, None] * level
            whole[:, :inner, :inner] += stacked @ variable @ stacked.T
            whole[:, : a.shape[0], : a.shape[0]] -= variable
            return np.asarray(-outer.T @ whole @ outer)

        return positive


def controller(plant: GeneralisedPlant, lyapunov: Lyapunov) -> Lti:
    """The central controller of one plant for the given (R, S).

    With P = [S, R^-1 - S; R^-1 - S, S - R^-1] the bounded-real lemma says that a norm is below one, affinely in the controller's
    matrices K: |Phi + U K V| < 1. That is Parrott's problem; its central solution is explicit (Davis, Kahan and Weinberger, 1982).
    Raises NoSolutionError where (R, S) do not admit a controller to working precision.
    """
    p = plant.transformed(lyapunov.t)
    n, n_w, n_z = p.a.shape[0], p.b1.shape[1], p.c1.shape[0]
    r_inverse = np.linalg.inv(lyapunov.r)
    gap = lyapunov.s - r_inverse
    big = np.block([[lyapunov.s, -gap], [-gap, gap]])
    values, vectors = np.linalg.eigh(0.5 * (big + big.T))
    if values[0] <= 0.0:
        raise NoSolutionError("the Lyapunov matrix of the synthesis is not positive; raise `recentring` or relax the weights")
    root, root_inverse = vectors @ np.diag(np.sqrt(values)) @ vectors.T, vectors @ np.diag(values**-0.5) @ vectors.T
    left = block_diag(root, np.eye(n_z) / np.sqrt(lyapunov.gamma))
    right = block_diag(root_inverse, np.eye(n_w) / np.sqrt(lyapunov.gamma))
    zero = np.zeros
    phi = left @ np.block([[p.a, zero((n, n)), p.b1], [zero((n, 2 * n + n_w))], [p.c1, zero((n_z, n)), p.d11]]) @ right
    u = left @ np.block([[zero((n, n)), p.b2], [np.eye(n), zero((n, 1))], [zero((n_z, n)), p.d12]])
    v = np.block([[zero((n, n)), np.eye(n), zero((n, n_w))], [p.c2, zero((1, n)), p.d21]]) @ right
    k = _parrott(phi, u, v)
    return Lti(k[:n, :n], k[:n, n:], k[n:, :n], k[n:, n:], plant.period)


def _parrott(phi: Matrix, u: Matrix, v: Matrix) -> Matrix:
    """The central K with |phi + u K v| < 1, u of full column rank and v of full row rank."""
    q_u, r_u = np.linalg.qr(u, mode="complete")
    q_v, r_v = np.linalg.qr(v.T, mode="complete")
    m, k = u.shape[1], v.shape[0]
    turned = q_u.T @ phi @ q_v
    corner, b, c, a = turned[:m, :k], turned[:m, k:], turned[m:, :k], turned[m:, k:]
    reach = max(np.linalg.norm(np.vstack([b, a]), 2), np.linalg.norm(np.hstack([c, a]), 2))
    if reach >= 1.0:
        raise NoSolutionError(
            f"no controller for the Lyapunov matrix found (norm {reach:.6g} >= 1); raise `recentring` or relax the weights"
        )
    completed = -b @ np.linalg.solve(np.eye(a.shape[1]) - a.T @ a, a.T @ c)
    return np.asarray(np.linalg.solve(r_u[:m], np.linalg.solve(r_v[:k], (completed - corner).T).T))
