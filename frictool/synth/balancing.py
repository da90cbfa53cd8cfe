"""Balanced coordinates of a stable system in continuous or discrete time (Moore 1981)."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.plant.lti import Lti
from frictool.typing import Matrix


def balanced_form(k: Lti, negligible: float = 0.0) -> tuple[Lti, NDArray[np.float64]]:
    """Return the stable system `k` in balanced coordinates, and its Hankel singular values.

    In balanced coordinates both Gramians are the same diagonal matrix, whose entries are the Hankel
    singular values. Two kinds of states are left out: states that are unreachable or unobservable
    to working precision, and states with a Hankel singular value of at most `negligible` times the
    largest.
    """
    if not k.order:
        return k, np.empty(0)
    reach, see = (_root(_gramian(*pair, k.period)) for pair in ((k.a, k.b), (k.a.T, k.c.T)))
    u, hankel, vh = np.linalg.svd(see.T @ reach)
    there = hankel > max(negligible, np.finfo(float).eps * k.order) * hankel[0]
    half = hankel[there] ** -0.5
    t = reach @ vh[there].T * half
    inverse = (see @ u[:, there] * half).T
    return Lti(inverse @ k.a @ t, inverse @ k.b, k.c @ t, k.d, k.period), hankel[there]


def _gramian(a: Matrix, b: Matrix, period: float) -> Matrix:
    return np.asarray(
        scipy.linalg.solve_discrete_lyapunov(a, b @ b.T, method="bilinear")
        if period
        else scipy.linalg.solve_continuous_lyapunov(a, -b @ b.T)
    )


def _root(gramian: Matrix) -> Matrix:
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
