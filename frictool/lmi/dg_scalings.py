"""D-G scalings of a structured uncertainty as one quadratic form (Fan, Tits and Doyle, 1991).

    w_D = Delta z_D, Delta = diag(delta I, ..., Delta_f, ...), delta real in [-1, 1],
    |Delta_f| <= 1

    real block   D = D* > 0, G = G*, both full:   z* D z - w* D w >= 0,
                                                  j (w* G z - z* G w) = 0
    full block   d > 0:                           d |z|^2 - d |w|^2 >= 0

M maps (w_D, w) to (z_D, z). Adding the terms of all blocks and the level g gives

    Phi = [M; I]* Pi [M; I] = M* diag(D, 1/g) M + j (G M_D - M_D* G) - diag(D, g) < 0

on the whole imaginary axis or unit circle (G acts on w_D). Then |z| < g |w| for every Delta, and
the loop is stable for every Delta if it is stable for one. Pi is linear in the unknowns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictool.plant.uncertain_axis import RealBlock, Uncertain
from frictool.typing import ComplexVector, Vector


@dataclass(frozen=True)
class ScalingForm:
    """Quadratic form Pi = fixed(g) + sum x_k `basis`[k].

    `blocks` has one tuple per uncertainty block: slice of outputs, slice of inputs, True if real.
    `z` and `w` count all outputs and inputs of M; the first `z_uncertain` and `w_uncertain` of them
    belong to the uncertainty.
    """

    basis: ComplexVector
    blocks: tuple[tuple[slice, slice, bool], ...]
    z_uncertain: int
    w_uncertain: int
    z: int
    w: int

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return len(self.basis)

    def fixed(self, level: float) -> ComplexVector:
        """Return the term of the performance: z* z/level - level w* w."""
        diagonal = np.zeros(self.z + self.w)
        diagonal[self.z_uncertain : self.z] = 1.0 / level
        diagonal[self.z + self.w_uncertain :] = -level
        return np.diag(diagonal).astype(np.complex128)

    def at(self, x: Vector, level: float) -> ComplexVector:
        """Return Pi for the unknowns x (count,)."""
        return np.asarray(self.fixed(level) + np.tensordot(x, self.basis, 1))

    def scales(self, x: Vector) -> list[ComplexVector]:
        """Return the matrices D of the blocks, which must be positive."""
        whole = np.tensordot(x, self.basis, 1)
        return [
            whole[z, z] if real else whole[z.start : z.start + 1, z.start : z.start + 1]
            for z, _, real in self.blocks
        ]


def form(blocks: Sequence[Uncertain], z: int, w: int) -> ScalingForm:
    """Return the form of an uncertainty; `z` and `w` count all outputs and inputs of M."""
    z_at = 0
    w_at = 0
    bases = []
    placed = []
    for block in blocks:
        rows = slice(z_at, z_at + block.entering)
        columns = slice(z + w_at, z + w_at + block.size)
        placed.append((rows, columns, isinstance(block, RealBlock)))
        bases += (
            _real(block, rows, columns, z + w)
            if isinstance(block, RealBlock)
            else [_full(rows, columns, z + w)]
        )
        z_at, w_at = z_at + block.entering, w_at + block.size
    return ScalingForm(np.array(bases).reshape(-1, z + w, z + w), tuple(placed), z_at, w_at, z, w)


def _real(block: RealBlock, z: slice, w: slice, size: int) -> list[ComplexVector]:
    """Return one matrix for each real unknown of D and of G."""
    bases = []
    for part in _hermitian(block.size):
        for_d, for_g = np.zeros((2, size, size), dtype=np.complex128)
        for_d[z, z] = part
        for_d[w, w] = -part
        for_g[w, z], for_g[z, w] = 1j * part, -1j * part
        bases += [for_d, for_g]
    return bases


def _hermitian(size: int) -> list[ComplexVector]:
    """Return a basis of the Hermitian matrices over the real numbers."""
    bases = []
    for row in range(size):
        for column in range(row + 1):
            for value in (1.0,) if row == column else (1.0, 1j):
                part = np.zeros((size, size), dtype=np.complex128)
                part[row, column] = value
                part[column, row] = np.conj(value)
                bases.append(part)
    return bases


def _full(z: slice, w: slice, size: int) -> ComplexVector:
    diagonal = np.zeros(size)
    diagonal[z], diagonal[w] = 1.0, -1.0
    return np.diag(diagonal).astype(np.complex128)
