"""Norms of discrete-time systems x+ = a x + b w, z = c x + d w.

The peak gain over the unit circle is found by the bisection of Boyd, Balakrishnan and Kabamba (1989) with the two-step level
update of Bruinsma and Steinbuch (1990), on the bilinear image of the system, whose imaginary axis is the unit circle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


def spectral_radius(a: Matrix) -> float:
    """Largest modulus of the eigenvalues of `a` (n, n); 0 for an empty matrix."""
    return float(np.max(np.abs(np.linalg.eigvals(a)))) if a.size else 0.0


def gain_at(a: Matrix, b: Matrix, c: Matrix, d: Matrix, angle: float) -> float:
    """Largest singular value of c (z - a)^-1 b + d at z = exp(j angle)."""
    z = np.exp(1j * angle)
    return float(np.linalg.norm(c @ np.linalg.solve(z * np.eye(a.shape[0]) - a, b) + d, 2))


def peak_gain(a: Matrix, b: Matrix, c: Matrix, d: Matrix, tolerance: float = 1e-6) -> tuple[float, float]:
    """H-infinity norm and the angle [rad a sample] where it is reached; (inf, nan) for an unstable `a`.

    Shapes: a (n, n), b (n, m), c (p, n), d (p, m). The norm is exact to the relative `tolerance`.
    """
    if spectral_radius(a) >= 1.0:
        return np.inf, np.nan
    angles = np.concatenate([[0.0, np.pi], np.abs(np.angle(np.linalg.eigvals(a))), np.geomspace(1e-4, np.pi, 24)])
    peak, where = max((gain_at(a, b, c, d, angle), angle) for angle in angles)
    for _ in range(100):
        crossings = _crossings(a, b, c, d, peak * (1.0 + tolerance))
        if crossings.size == 0:
            return peak, float(where)
        middles = 0.5 * (crossings[:-1] + crossings[1:]) if crossings.size > 1 else crossings
        candidate, angle = max((gain_at(a, b, c, d, middle), middle) for middle in middles)
        if candidate <= peak * (1.0 + tolerance):
            return peak, float(where)
        peak, where = candidate, angle
    return np.inf, np.nan


def _crossings(a: Matrix, b: Matrix, c: Matrix, d: Matrix, level: float) -> NDArray[np.float64]:
    """Angles in [0, pi] at which some singular value equals `level`: imaginary eigenvalues of the Hamiltonian of the bilinear image."""
    identity = np.eye(a.shape[0])
    inverse = np.linalg.inv(a + identity)
    ac, bc, cc = (a - identity) @ inverse, np.sqrt(2.0) * inverse @ b, np.sqrt(2.0) * c @ inverse
    dc = d - c @ inverse @ b
    r = level**2 * np.eye(d.shape[1]) - dc.T @ dc
    s = level**2 * np.eye(d.shape[0]) - dc @ dc.T
    middle = bc @ np.linalg.solve(r, dc.T @ cc)
    hamiltonian = np.block(
        [[ac + middle, level * bc @ np.linalg.solve(r, bc.T)], [-level * cc.T @ np.linalg.solve(s, cc), -(ac + middle).T]]
    )
    values = np.linalg.eigvals(hamiltonian)
    on_axis = values[np.abs(values.real) < 1e-8 * max(1.0, float(np.max(np.abs(values))))]
    return np.sort(np.unique(2.0 * np.arctan(np.abs(on_axis.imag))))
