"""Projected inequalities of thesis (5.62) at grid points, with parameter-dependent X and Y.

    N_X' [ A X + X A' - dX/dt   X C1'      B1       ]
         [ C1 X                 -gamma I   D11      ] N_X < 0
         [ B1'                  D11'       -gamma I ]

    N_Y' [ Y A + A' Y + dY/dt   Y B1       C1'      ]
         [ B1' Y                -gamma I   D11'     ] N_Y < 0        [X I; I Y] > 0
         [ C1                   D11        -gamma I ]

' is the transpose, and r the vector of scheduled parameters. The inequalities must hold at every r
of the grid and every corner of the rates dr/dt, with dX/dt = sum dr_j/dt dX/dr_j (Wu, 1995;
Apkarian and Adams, 1998). The thesis prints + before both derivatives. Here dX/dt has a minus,
because X is a block of an inverse. If the limits of each rate are -a and a, both signs give the
same conditions. In discrete time the terms are A X(r) A' - X(r + step) and A' Y(r + step) A - Y(r).

The solver gets the smaller form of lmi/bounded_real.py: without the last block row (Schur
complement), and with unknowns X/gamma and Y/gamma.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np
import scipy

from frictool.lmi.bounded_real import ProjectedInequality
from frictool.lmi.sdp import AffineConstraint, symmetric, upper_triangle
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.typing import Matrix, Vector

Values = tuple[float, ...]


@dataclass(frozen=True)
class ParameterBasis:
    """Monomials of the scheduled parameters r, up to a degree, as basis functions of X(r) or Y(r).

    - degree: 0 for constant, 1 for affine, 2 for quadratic functions
    - on: indices of the parameters that occur in the monomials
    """

    degree: int
    on: tuple[int, ...]

    @property
    def terms(self) -> tuple[tuple[int, ...], ...]:
        """Return the monomials up to the degree, each as the tuple of its parameters' indices."""
        return tuple(
            term
            for d in range(self.degree + 1)
            for term in combinations_with_replacement(self.on, d)
        )

    def at(self, values: Sequence[float]) -> Vector:
        """Return the values (terms,) of the monomials at the parameter values `values`."""
        return np.array(
            [np.prod([values[j] for j in term]) for term in self.terms], dtype=np.float64
        )

    def along(self, values: Sequence[float], motion: Sequence[float]) -> Vector:
        """Return the time derivatives (terms,) of the monomials.

        - values: parameters
        - motion: rates of the parameters [1/unit of time]
        """
        weights = []
        for term in self.terms:
            others = [
                np.prod([values[j] for k, j in enumerate(term) if k != index])
                for index in range(len(term))
            ]
            weights.append(sum(motion[j] * other for j, other in zip(term, others, strict=True)))
        return np.array(weights, dtype=np.float64)


@dataclass(frozen=True)
class GridPlants:
    """Plants at one grid point in balanced coordinates, all continuous or all sampled.

    B2, D12, C2 and D21 are the same for all plants. values: scheduled parameters at the point.
    """

    values: Values
    plants: tuple[GeneralisedPlant, ...]


class GridInequalities:
    """Inequalities of thesis (5.62) at all points of a grid of scheduled parameters.

    - cells: plants of each grid point
    - bases: monomials of X and of Y
    - motions: corners of the rates of the parameters

    Decision vectors begin with the upper triangles of the coefficients of X/gamma, followed by the
    upper triangles of the coefficients of Y/gamma.
    """

    def __init__(
        self,
        cells: Sequence[GridPlants],
        bases: tuple[ParameterBasis, ParameterBasis],
        motions: Sequence[Values],
    ) -> None:
        first = cells[0].plants[0]
        self.cells, self.bases, self.motions = cells, bases, motions
        self.n = len(first.a)
        self.disc = first.period > 0.0
        self.ports = (first.b1.shape[1], len(first.c1))
        self.half = self.n * (self.n + 1) // 2
        self.sizes = (len(bases[0].terms) * self.half, len(bases[1].terms) * self.half)
        null_x = scipy.linalg.null_space(np.hstack([first.b2.T, first.d12.T]))
        null_y = scipy.linalg.null_space(np.hstack([first.c2, first.d21]))
        self.sides = [
            (
                [
                    ProjectedInequality.of(p.a, p.b1, p.c1, p.d11, null_x, self.disc)
                    for p in cell.plants
                ],
                [
                    ProjectedInequality.of(p.a.T, p.c1.T, p.b1.T, p.d11.T, null_y, self.disc)
                    for p in cell.plants
                ],
            )
            for cell in cells
        ]

    @property
    def unknowns(self) -> int:
        """Return the number of unknown coefficients of X and Y."""
        return sum(self.sizes)

    def blocks(self, x: Vector, gamma: float) -> tuple[Matrix, Matrix]:
        """Return the coefficients (terms, n, n) of X and of Y for the decision vector `x`."""
        first = x[: self.sizes[0]]
        second = x[self.sizes[0] : self.unknowns]
        return gamma * symmetric(first.reshape(-1, self.half), self.n), gamma * symmetric(
            second.reshape(-1, self.half), self.n
        )

    def free(self) -> list[AffineConstraint]:
        """Return the inequalities with unknown gamma.

        The decision vector is (X/gamma, Y/gamma, d, m), with d = 1/gamma and m >= d^2.
        """
        count = self.unknowns + 2
        inequalities = self.coupling(count, None)
        for fixed, coefficients, entering in self.reduced():
            columns = np.zeros((len(coefficients), count))
            columns[:, : self.unknowns] = coefficients
            columns[:, -1] = -entering[upper_triangle(len(entering))]
            inequalities.append(AffineConstraint(fixed, columns))
        cone = np.zeros((3, count))
        cone[1, -2] = cone[0, -1] = 1.0  # [m d; d 1]
        return [*inequalities, AffineConstraint(np.diag([0.0, 1.0]), cone)]

    def at(self, gamma: float, b: float | None, margin: float) -> list[AffineConstraint]:
        """Return the inequalities for a given gamma, with [X bI; bI Y] in place of [X I; I Y].

        b: factor of the identity; a larger b moves X Y away from the singular case X Y = I.
        The decision vector is (X/gamma, Y/gamma); if b is None, b/gamma is its last entry. The
        matrix of each projected inequality must have no eigenvalue below `margin`.
        """
        count = self.unknowns + (b is None)
        inequalities = self.coupling(count, None if b is None else b / gamma)
        for fixed, coefficients, entering in self.reduced():
            columns = np.zeros((len(coefficients), count))
            columns[:, : self.unknowns] = coefficients
            inequalities.append(
                AffineConstraint(fixed - entering / gamma**2 - margin * np.eye(len(fixed)), columns)
            )
        return inequalities

    def reduced(self) -> Iterator[tuple[Matrix, Matrix, Matrix]]:
        """Yield (fixed, columns, entering) of each inequality fixed + F - entering/gamma^2 > 0.

        There is one inequality for X and one for Y for each plant of each grid point and each
        combination of extreme rates. `fixed` and `entering` are constant matrices; F is linear in
        X/gamma or Y/gamma. A column of `columns` is the upper triangle of the matrix that
        multiplies one unknown in F.
        """
        for cell, sides in zip(self.cells, self.sides, strict=True):
            for block in (0, 1):
                start = block * self.sizes[0]
                weights = self.weights(block, cell.values)
                for side in sides[block]:
                    fixed, _, entering = side.reduced(self.ports[block])
                    flow = _flowing(side).reduced(self.ports[block])[1]
                    compared = _compared(side).reduced(self.ports[block])[1]
                    for weight, moved in weights:
                        columns = np.zeros((len(flow), self.unknowns))
                        stacked = [
                            a * flow + b * compared for a, b in zip(weight, moved, strict=True)
                        ]
                        columns[:, start : start + self.sizes[block]] = np.hstack(stacked)
                        yield fixed, columns, entering

    def weights(self, block: int, values: Values) -> list[tuple[Vector, Vector]]:
        """Return pairs (w1, w2) of weights of the coefficients X_k of X (block 0) or Y (block 1).

        There is one pair for each distinct corner of the rates of r. The inequality contains two
        linear combinations of the coefficients. Matrices of the plant multiply the first, sum w1_k
        X_k. The second, v = sum w2_k X_k, is part of the separate term e v e'
        (lmi/bounded_real.py). In continuous time, v is the derivative of X, or minus the derivative
        of Y. In discrete time, w1 and w2 belong to the start and the end of a step for X, and to
        the end and the start for Y.
        """
        basis = self.bases[block]
        pairs = []
        for motion in self.motions:
            now = basis.at(values)
            if self.disc:
                after = basis.at([v + m for v, m in zip(values, motion, strict=True)])
                pairs.append((now, after) if block == 0 else (after, now))
            else:
                pairs.append((now, (1.0, -1.0)[block] * basis.along(values, motion)))
        unique = {(tuple(a.tolist()), tuple(b.tolist())): (a, b) for a, b in pairs}
        return list(unique.values())

    def coupling(self, count: int, b: float | None) -> list[AffineConstraint]:
        """Return the constraints [X/gamma bI; bI Y/gamma] >= 0, one for each grid point.

        If b is None, b is the unknown that follows Y/gamma in the decision vector.
        """
        n, (i, j) = self.n, upper_triangle(2 * self.n)
        side = np.block([[np.zeros((n, n)), np.eye(n)], [np.eye(n), np.zeros((n, n))]])
        inequalities = []
        for cell in self.cells:
            columns = np.zeros((len(i), count))
            for block, rows in ((0, np.flatnonzero(j < n)), (1, np.flatnonzero(i >= n))):
                for k, weight in enumerate(self.bases[block].at(cell.values)):
                    columns[rows, block * self.sizes[0] + k * self.half + np.arange(self.half)] = (
                        weight
                    )
            if b is None:
                columns[:, self.unknowns] = side[i, j]
            inequalities.append(
                AffineConstraint(np.zeros((2 * n, 2 * n)) if b is None else b * side, columns)
            )
        return inequalities

    def margins(self, x: Matrix, y: Matrix, gamma: float) -> Vector:
        """Return the smallest relative eigenvalue (points,) of the inequalities at each grid point.

        A relative eigenvalue is an eigenvalue divided by the largest absolute eigenvalue of the
        same matrix. All values are positive if all inequalities hold.

        - x, y: coefficients of X and of Y
        """
        smallest = []
        for cell, sides in zip(self.cells, self.sides, strict=True):
            values = []
            for block, v in ((0, x), (1, y)):
                for weight, moved in self.weights(block, cell.values):
                    flow, drift = np.tensordot(weight, v, 1), np.tensordot(moved, v, 1)
                    values += [
                        _least(_flowing(side).at(flow, gamma) + side.e @ drift @ side.e.T)
                        for side in sides[block]
                    ]
            here = [
                np.tensordot(basis.at(cell.values), v, 1)
                for basis, v in zip(self.bases, (x, y), strict=True)
            ]
            values.append(_least(np.block([[here[0], np.eye(self.n)], [np.eye(self.n), here[1]]])))
            smallest.append(min(values))
        return np.array(smallest)


def _flowing(side: ProjectedInequality) -> ProjectedInequality:
    return replace(side, e=np.zeros_like(side.e)) if side.disc else side


def _compared(side: ProjectedInequality) -> ProjectedInequality:
    return replace(side, p=np.zeros_like(side.p), disc=True)


def _least(matrix: Matrix) -> float:
    values = np.linalg.eigvalsh(matrix)
    return float(values[0] / max(abs(values[-1]), abs(values[0])))
