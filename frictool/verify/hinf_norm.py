"""H-infinity norm of a system in continuous or discrete time, and its peak frequency.

The algorithm is the bisection of Boyd, Balakrishnan and Kabamba (1989) with the two-step level
update of Bruinsma and Steinbuch (1990). The imaginary eigenvalues of a Hamiltonian matrix are the
frequencies at which a singular value equals the level. A sampled system is transformed by s =
(z - 1)/(z + 1), so that the unit circle becomes the imaginary axis. The eigenvalues only locate
frequencies. At these frequencies, the gain is computed from the frequency response.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from frictool.plant.lti import Lti
from frictool.typing import Matrix

LEVELS = 100  # largest number of levels of the bisection; a few are usual
# relative real part below which an eigenvalue is treated as imaginary
ON_AXIS = 1e-8


def spectral_radius(a: Matrix) -> float:
    """Return the largest modulus of the eigenvalues of `a` (n, n); 0 for an empty matrix."""
    return float(np.max(np.abs(np.linalg.eigvals(a)))) if a.size else 0.0


def gains(system: Lti, frequencies: ArrayLike) -> NDArray[np.float64]:
    """Return the largest singular values (k,) at the angular frequencies (k,) [rad/s].

    In continuous time, a frequency may be inf.
    """
    w = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    gain = np.full(len(w), np.linalg.norm(system.d, 2))
    finite = np.isfinite(w)
    if system.order:
        responses = system.response(w[finite])
        gain[finite] = (
            np.abs(responses[:, 0, 0])
            if system.d.size == 1
            else np.linalg.norm(responses, 2, axis=(1, 2))
        )
    return gain


def norm(
    system: Lti, tolerance: float = 1e-6, looks: ArrayLike | None = None
) -> tuple[float, float]:
    """Return the H-infinity norm and its peak frequency [rad/s]; (inf, nan) if unstable.

    The returned norm is the gain at the peak frequency, which is below the true norm by at most the
    relative `tolerance`. The peak frequency may be inf for a continuous system. `looks` are the
    frequencies that are evaluated first, by default frequencies derived from the poles.
    """
    if not system.stable:
        return np.inf, np.nan
    try:
        return _peak(system, tolerance, looks)
    except np.linalg.LinAlgError:  # a pole lies at an evaluated frequency
        return np.inf, np.nan


def _peak(system: Lti, tolerance: float, looks: ArrayLike | None) -> tuple[float, float]:
    where = (
        _first_looks(system)
        if looks is None
        else np.concatenate([_ends(system), np.atleast_1d(np.asarray(looks, dtype=np.float64))])
    )
    responses = gains(system, where)
    best = int(np.argmax(responses))
    peak, at = float(responses[best]), float(where[best])
    for _ in range(LEVELS):
        crossings = (
            _crossings(system, peak * (1.0 + tolerance))
            if peak > 0.0 and system.order
            else np.empty(0)
        )
        if crossings.size == 0:
            return peak, at
        middles = _between(crossings, system.period)
        responses = gains(system, middles)
        best = int(np.argmax(responses))
        if responses[best] <= peak * (1.0 + tolerance):
            return peak, at
        peak, at = float(responses[best]), float(middles[best])
    return np.inf, np.nan


def _first_looks(system: Lti) -> NDArray[np.float64]:
    if not system.order:
        return _ends(system)
    poles = np.linalg.eigvals(system.a)
    if system.period:
        return np.concatenate(
            [
                _ends(system),
                np.abs(np.angle(poles)) / system.period,
                np.geomspace(1e-4, np.pi, 24) / system.period,
            ]
        )
    size = np.abs(poles)
    grid = np.geomspace(0.1 * size.min(), 10.0 * size.max(), 24)
    return np.concatenate([_ends(system), np.abs(poles.imag), size, grid])


def _ends(system: Lti) -> NDArray[np.float64]:
    return np.array([0.0, np.pi / system.period if system.period else np.inf])


def _between(crossings: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    if crossings.size == 1:
        return crossings
    low, high = crossings[:-1], crossings[1:]
    middles = 0.5 * (low + high)
    return middles if period else np.concatenate([middles, np.sqrt(low * high)])


def _crossings(system: Lti, level: float) -> NDArray[np.float64]:
    """Return the sorted frequencies [rad/s] at which a singular value equals `level`.

    The frequencies are imaginary eigenvalues of the Hamiltonian matrix. The level must exceed the
    gain at infinity (in continuous time) or at half the sampling frequency.
    """
    a, b, c, d = (
        _bilinear_image(system) if system.period else (system.a, system.b, system.c, system.d)
    )
    r = level**2 * np.eye(d.shape[1]) - d.T @ d
    s = level**2 * np.eye(d.shape[0]) - d @ d.T
    middle = a + b @ np.linalg.solve(r, d.T @ c)
    hamiltonian = np.block(
        [
            [middle, level * b @ np.linalg.solve(r, b.T)],
            [-level * c.T @ np.linalg.solve(s, c), -middle.T],
        ]
    )
    values = np.linalg.eigvals(hamiltonian)
    on_axis = np.abs(
        values[
            np.abs(values.real)
            < ON_AXIS * max(1.0 if system.period else 0.0, float(np.max(np.abs(values))))
        ].imag
    )
    return np.unique(2.0 * np.arctan(on_axis) / system.period if system.period else on_axis)


def _bilinear_image(system: Lti) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    identity = np.eye(system.order)
    inverse = np.linalg.inv(system.a + identity)
    root = np.sqrt(2.0)
    return (
        (system.a - identity) @ inverse,
        root * inverse @ system.b,
        root * system.c @ inverse,
        system.d - system.c @ inverse @ system.b,
    )
