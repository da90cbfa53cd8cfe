"""Balancing of states, which makes matrix inequalities well-conditioned for the solver."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.typing import Matrix

SMALLEST = 1e-12  # smallest eigenvalue of R and S that balancing uses, relative to the largest


def even_out(plants: Sequence[GeneralisedPlant], sweeps: int = 20) -> Matrix:
    """Return a diagonal matrix t that balances the states x, by Osborne's method.

    For the states t^-1 x, the gains into and out of each state are nearly equal.
    """
    return osborne([_whole(p) for p in plants], len(plants[0].a), sweeps)


def osborne(systems: Sequence[Matrix], n: int, sweeps: int = 20) -> Matrix:
    """Return Osborne's balancing, a diagonal t (n, n), for matrices [A B; C D] with n states.

    The row and column norms include inputs and outputs.
    """
    whole = np.max(np.abs(systems), axis=0)
    scale = np.ones(n)
    for _ in range(sweeps):
        for k in range(n):
            into = float(np.linalg.norm(np.delete(whole[k], k)))
            out_of = float(np.linalg.norm(np.delete(whole[:, k], k)))
            if into > 0.0 and out_of > 0.0:
                factor = np.sqrt(into / out_of)
                whole[k] /= factor
                whole[:, k] *= factor
                scale[k] *= factor
    return np.diag(scale)


def _whole(p: GeneralisedPlant) -> Matrix:
    return np.block(
        [
            [p.a, p.b1, p.b2],
            [p.c1, p.d11, p.d12],
            [p.c2, p.d21, np.zeros((len(p.c2), p.b2.shape[1]))],
        ]
    )


def balancing(r: Matrix, s: Matrix) -> Matrix:
    """Return the matrix t for which t^-1 R t^-T and t' S t are equal and diagonal.

    r, s: positive definite matrices R and S.
    """
    root_r, root_s = _root(r), _root(s)
    _, values, v = scipy.linalg.svd(root_s.T @ root_r)
    return np.asarray(root_r @ v.T @ np.diag(values**-0.5))


def _root(m: Matrix) -> Matrix:
    values, vectors = np.linalg.eigh(m)
    return np.asarray(vectors * np.sqrt(np.maximum(values, SMALLEST * values[-1])))
