"""Projected bounded-real inequalities of a set of plants with common Lyapunov blocks R and S.

R and S are the two blocks of the Lyapunov matrix (X and Y in thesis 5.61). gamma bounds the norm
from w to z. N_R and N_S are bases of the null spaces of [B2' D12'] and [C2 D21]. A controller
exists for every plant if and only if (Gahinet and Apkarian, 1994)

    [N_R 0]' [ L(R)   M(R)'            B1       ] [N_R 0]
    [0   I]  [ M(R)   Q(R) - gamma I   D11      ] [0   I] < 0
             [ B1'    D11'             -gamma I ]

    continuous:  L = A R + R A'    M = C1 R       Q = 0
    discrete:    L = A R A' - R    M = C1 R A'    Q = C1 R C1'

and its dual in S hold, and [R I; I S] >= 0. With P = [A; C1] and E = [I; 0], the terms in R of the
upper left corner are P R E' + E R P' in continuous time and P R P' - E R E' in discrete time.

The solver gets a smaller problem: a Schur complement removes the last block row, and the
inequalities are divided by gamma. Let R' = R/gamma and S' = S/gamma (at all other matrices, ' is a
transpose), d = 1/gamma, and a scalar m >= d^2. The solver maximises d subject to

    N_R' [ L(R')   M(R')'    ] N_R + m N_R' [B1; D11] [B1; D11]' N_R < 0,
         [ M(R')   Q(R') - I ]
    [R' dI; dI S'] >= 0
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.lmi.sdp import AffineConstraint, symmetric, upper_triangle
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.typing import Matrix, Vector

ROUNDING = 1e-14


@dataclass(frozen=True)
class ProjectedInequality:
    """Projected bounded-real inequality of one plant in the Lyapunov block v = R or S.

    The inequality is fixed + gamma level - p v e' - e v p' > 0 in continuous time, and fixed +
    gamma level - p v p' + e v e' > 0 in discrete time. p and e are the projected matrices [A; C1]
    and [I; 0]. `fixed` and `level` are constant matrices. `disc` is True in discrete time.
    """

    p: Matrix
    e: Matrix
    fixed: Matrix
    level: Matrix
    disc: bool

    @staticmethod
    def of(
        a: Matrix, b: Matrix, c: Matrix, d: Matrix, null: Matrix, disc: bool
    ) -> ProjectedInequality:
        """Return the projected inequality of the system x' = a x + b w, z = c x + d w.

        The columns of `null` are a basis of the null space of [B2' D12'] (for R) or [C2 D21] (for
        S).
        """
        n = len(a)
        n_z = len(c)
        n_w = b.shape[1]
        outer = scipy.linalg.block_diag(null, np.eye(n_w)).T
        fixed = np.zeros((n + n_z + n_w,) * 2)
        fixed[: n + n_z, n + n_z :] = np.vstack([b, d])
        level = np.diag(np.concatenate([np.zeros(n), np.ones(n_z + n_w)]))
        stacked = np.vstack([a, c, np.zeros((n_w, n))])
        picked = np.vstack([np.eye(n), np.zeros((n_z + n_w, n))])
        return ProjectedInequality(
            outer @ stacked,
            outer @ picked,
            -outer @ (fixed + fixed.T) @ outer.T,
            outer @ level @ outer.T,
            disc,
        )

    def at(self, v: Matrix, gamma: float) -> Matrix:
        """Return the left side for v = R or S; it is positive definite if the inequality holds."""
        if self.disc:
            return np.asarray(
                self.fixed + gamma * self.level - self.p @ v @ self.p.T + self.e @ v @ self.e.T
            )
        crossed = self.p @ v @ self.e.T
        return np.asarray(self.fixed + gamma * self.level - crossed - crossed.T)

    @property
    def columns(self) -> Matrix:
        """Return the matrices that multiply the entries of R or S in the inequality.

        Column k is the upper triangle of the matrix that multiplies entry k of R's or S's upper
        triangle.
        """
        return _columns(self.p, self.e, self.disc)

    def reduced(self, n_w: int) -> tuple[Matrix, Matrix, Matrix]:
        """Return (fixed, columns, entering) of the inequality fixed + F - entering/gamma^2 > 0.

        F is linear in R/gamma or S/gamma, and `columns` contains the matrices that multiply its
        entries. The inequality is the Schur complement that removes the last `n_w` rows, divided by
        gamma.
        """
        k = len(self.p) - n_w
        side = self.fixed[:k, k:]
        return self.level[:k, :k], _columns(self.p[:k], self.e[:k], self.disc), side @ side.T


Indices = tuple[NDArray[np.intp], NDArray[np.intp]]


def _columns(p: Matrix, e: Matrix, disc: bool) -> Matrix:
    rows = upper_triangle(len(p))
    pairs = upper_triangle(p.shape[1])
    if disc:
        return _products(e, e, rows, pairs) - _products(p, p, rows, pairs)
    return -_products(p, e, rows, pairs) - _products(e, p, rows, pairs)


def _products(left: Matrix, right: Matrix, rows: Indices, pairs: Indices) -> Matrix:
    """Return the coefficients of the product left v right' in the entries of the symmetric v.

    Each row belongs to an entry of the product (upper triangle `rows`), each column to an entry of
    v (upper triangle `pairs`).
    """
    up, down, i, j = left[rows[0]], right[rows[1]], *pairs
    both = up[:, i] * down[:, j]
    both[:, i != j] += up[:, j[i != j]] * down[:, i[i != j]]
    return np.asarray(both)


class BoundedRealInequalities:
    """Bounded-real inequalities of several plants with common Lyapunov blocks R and S.

    The plants must have the same state coordinates. Decision vectors begin with the upper triangles
    of R/gamma and S/gamma.
    """

    def __init__(self, plants: Sequence[GeneralisedPlant]) -> None:
        first = plants[0]
        for plant in plants[1:]:
            pairs = (
                (plant.b2, first.b2),
                (plant.c2, first.c2),
                (plant.d12, first.d12),
                (plant.d21, first.d21),
            )
            if not all(np.allclose(p, q) for p, q in pairs):
                raise ValueError("B2, C2, D12 and D21 must be the same at every vertex")
        self.n = len(first.a)
        self.half = self.n * (self.n + 1) // 2
        null_r = scipy.linalg.null_space(np.hstack([first.b2.T, first.d12.T]))
        null_s = scipy.linalg.null_space(np.hstack([first.c2, first.d21]))
        disc = first.period > 0.0
        self.sides_r = [
            ProjectedInequality.of(p.a, p.b1, p.c1, p.d11, null_r, disc) for p in plants
        ]
        self.sides_s = [
            ProjectedInequality.of(p.a.T, p.c1.T, p.b1.T, p.d11.T, null_s, disc) for p in plants
        ]
        self.n_z, self.n_w = first.d11.shape

    @cached_property
    def reduced(self) -> list[tuple[int, tuple[Matrix, Matrix, Matrix]]]:
        """Return one pair (first, inequality) for each reduced inequality.

        first: index in the decision vector of the first unknown of the inequality.
        """
        return [(0, side.reduced(self.n_w)) for side in self.sides_r] + [
            (self.half, side.reduced(self.n_z)) for side in self.sides_s
        ]

    def blocks(self, x: Vector, gamma: float) -> tuple[Matrix, Matrix]:
        """Return the Lyapunov blocks R and S for the decision vector `x`."""
        return gamma * symmetric(x[: self.half], self.n), gamma * symmetric(
            x[self.half : 2 * self.half], self.n
        )

    def free(self) -> list[AffineConstraint]:
        """Return the inequalities with unknown gamma, in the unknowns (R/gamma, S/gamma, d, m).

        d is 1/gamma, and m a scalar with m >= d^2.
        """
        count = 2 * self.half + 2
        inequalities = [self._coupling(count, None)]
        for start, (fixed, coefficients, entering) in self.reduced:
            columns = np.zeros((len(coefficients), count))
            columns[:, start : start + self.half] = coefficients
            columns[:, -1] = -entering[upper_triangle(len(entering))]
            inequalities.append(AffineConstraint(fixed, columns))
        cone = np.zeros((3, count))
        cone[1, -2] = cone[0, -1] = 1.0  # [m d; d 1]
        return [*inequalities, AffineConstraint(np.diag([0.0, 1.0]), cone)]

    def at(self, gamma: float, b: float | None, margin: float) -> list[AffineConstraint]:
        """Return the inequalities for a given gamma, with [R bI; bI S] in place of [R I; I S].

        The matrix of each projected inequality must have no eigenvalue below `margin`. The decision
        vector is (R/gamma, S/gamma); if b is None, b/gamma is its last entry.
        """
        count = 2 * self.half + (b is None)
        inequalities = [self._coupling(count, None if b is None else b / gamma)]
        for start, (fixed, coefficients, entering) in self.reduced:
            columns = np.zeros((len(coefficients), count))
            columns[:, start : start + self.half] = coefficients
            inequalities.append(
                AffineConstraint(fixed - entering / gamma**2 - margin * np.eye(len(fixed)), columns)
            )
        return inequalities

    def _coupling(self, count: int, b: float | None) -> AffineConstraint:
        n, (i, j) = self.n, upper_triangle(2 * self.n)
        side = np.block([[np.zeros((n, n)), np.eye(n)], [np.eye(n), np.zeros((n, n))]])
        columns = np.zeros((len(i), count))
        columns[j < n, np.arange(self.half)] = 1.0
        columns[i >= n, self.half + np.arange(self.half)] = 1.0
        if b is None:
            columns[:, 2 * self.half] = side[i, j]
        return AffineConstraint(np.zeros((2 * n, 2 * n)) if b is None else b * side, columns)

    def hold(self, r: Matrix, s: Matrix, gamma: float) -> bool:
        """Return True if the blocks `r`, `s` solve all inequalities at `gamma` strictly."""
        n = self.n
        matrices = [side.at(r, gamma) for side in self.sides_r] + [
            side.at(s, gamma) for side in self.sides_s
        ]
        matrices.append(np.block([[r, np.eye(n)], [np.eye(n), s]]))
        return all(bool(np.all(np.isfinite(m))) and _positive(m) for m in matrices)


def _positive(matrix: Matrix) -> bool:
    values = np.linalg.eigvalsh(matrix)
    return bool(values[0] > ROUNDING * abs(values[-1]))
