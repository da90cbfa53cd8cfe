"""Negativity of a quadratic form of a transfer matrix on a whole arc of the unit circle.

    Phi(z) = [M; I]* Pi [M; I],   M(z) = c (z - a)^-1 b + d

Phi is singular exactly at the imaginary eigenvalues of a Hamiltonian matrix. The circle is rotated
so that the middle of the arc is at 1, and mapped by s = tan(h/2) (z + 1)/(z - 1), with h half the
arc. The middle goes to infinity and the ends to +-j, so the arc becomes abs(s) >= 1 on the
imaginary axis. Phi is negative on the arc if it is negative at the middle and no eigenvalue lies on
that part of the axis.
"""

from __future__ import annotations

import numpy as np

from frictool.plant.lti import Lti
from frictool.typing import ComplexVector

# relative real part below which an eigenvalue counts as a crossing, which refuses the arc
ON_AXIS = 1e-8


def is_negative_on(system: Lti, pi: ComplexVector, start: float, stop: float) -> bool:
    """Return True if Phi < 0 for every angle from `start` to `stop` [rad].

    The system is sampled and stable, `pi` is Hermitian.
    """
    middle = 0.5 * (start + stop)
    half = 0.5 * (stop - start)
    stretch = np.tan(0.5 * half)
    turn = np.exp(-1j * middle)
    identity = np.eye(system.order)
    inverse = np.linalg.inv(identity - system.a * turn)
    e = inverse @ (identity + system.a * turn)
    a = -stretch * e
    b = np.sqrt(stretch) * (e + identity) @ inverse @ (system.b * turn)
    c = -np.sqrt(stretch) * system.c
    d = system.d + system.c @ inverse @ (system.b * turn)
    c_all = np.vstack([c, np.zeros((system.b.shape[1], system.order))])
    d_all = np.vstack([d, np.eye(system.b.shape[1])])
    r = d_all.conj().T @ pi @ d_all
    if np.linalg.eigvalsh(0.5 * (r + r.conj().T))[-1] >= 0.0:
        return False
    q, s = c_all.conj().T @ pi @ c_all, c_all.conj().T @ pi @ d_all
    solved = np.linalg.solve(r, np.hstack([s.conj().T, b.conj().T]))
    upper = a - b @ solved[:, : system.order]
    hamiltonian = np.block(
        [
            [upper, -b @ solved[:, system.order :]],
            [s @ solved[:, : system.order] - q, -upper.conj().T],
        ]
    )
    values = np.linalg.eigvals(hamiltonian)
    largest = max(1.0, float(np.max(np.abs(values), initial=0.0)))
    return not bool(
        np.any((np.abs(values.real) <= ON_AXIS * largest) & (np.abs(values.imag) >= 1.0 - 1e-6))
    )
