"""The controller's stored forms: a balanced realisation, its inverse Tustin image, second-order sections, anti-windup gains."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

from frictool.documents.controller import LinearController
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, inverse_tustin
from frictool.verify.norms import spectral_radius

Matrix = NDArray[np.float64]
NEGLIGIBLE = 1e-8
INFINITE = 1e8  # a zero beyond this is one at infinity


def stored_forms(k: Lti) -> LinearController:
    """Every stored form of the discrete controller `k`.

    Raises NoSolutionError where the controller itself is unstable (it would run away whenever the loop is open: in the limit, at rest),
    or where the sections do not reproduce the state space (checked on the unit circle to 1e-6 of the peak).
    """
    radius = spectral_radius(k.a)
    if radius >= 1.0:
        raise NoSolutionError(
            f"the controller found is itself unstable (a pole of modulus {radius:.6g}); raise weights.static_error or weights.command"
        )
    balanced = _balanced(k)
    a, b, c, d = balanced.a, balanced.b, balanced.c, balanced.d
    sections = _sections(a, b, c, d)
    angles = np.geomspace(1e-3, np.pi, 200)
    _, from_sections = signal.sosfreqz(sections, worN=angles)
    z = np.exp(1j * angles)
    direct = np.array([(c @ np.linalg.solve(zi * np.eye(len(a)) - a, b) + d)[0, 0] for zi in z])
    if np.max(np.abs(from_sections - direct)) > 1e-6 * np.max(np.abs(direct)):
        raise NoSolutionError(
            "the second-order sections of the controller do not reproduce it; its poles are too ill-conditioned, relax the weights"
        )
    return LinearController(
        discrete=balanced.document(),
        continuous=inverse_tustin(balanced).document(),
        sos=tuple(tuple(float(value) for value in row) for row in sections),
        anti_windup=tuple(float(value) for value in _anti_windup(a, b, c, d)),
    )


def _sections(a: Matrix, b: Matrix, c: Matrix, d: Matrix) -> Matrix:
    """Second-order sections (m, 6) of the transfer function, zeros from the pencil of the system matrix and not from a polynomial."""
    n = len(a)
    pencil = linalg.eigvals(np.block([[a, b], [c, d]]), linalg.block_diag(np.eye(n), np.zeros((1, 1))))
    zeros = pencil[np.isfinite(pencil) & (np.abs(pencil) < INFINITE)]
    poles = np.linalg.eigvals(a)
    probe = 2.0  # any point outside the unit circle
    response = (c @ np.linalg.solve(probe * np.eye(n) - a, b) + d)[0, 0]
    gain = float(np.real(response * np.prod(probe - poles) / np.prod(probe - zeros)))
    sections = np.asarray(signal.zpk2sos(zeros, poles, gain))
    for _ in range(n - len(zeros)):  # each pole without a zero is a sample of delay: a numerator that has room moves by one
        row = int(np.argmin(np.abs(sections[:, 2])))
        sections[row, :3] = [0.0, sections[row, 0], sections[row, 1]]
    return sections


def _balanced(k: Lti) -> Lti:
    """The realisation with equal diagonal Gramians, so that rounding its coefficients hurts least.

    States that the synthesis leaves unreachable or unobservable (the delayed command is known exactly) are dropped: Hankel singular value
    below 1e-8 of the largest, which is below what the solver resolves.
    """
    a, b, c = k.a, k.b, k.c
    reach, see = (_root(linalg.solve_discrete_lyapunov(*pair)) for pair in ((a, b @ b.T), (a.T, c.T @ c)))
    u, hankel, v = np.linalg.svd(see.T @ reach)
    kept = hankel > NEGLIGIBLE * hankel[0]
    t = reach @ v[kept].T * hankel[kept] ** -0.5
    inverse = (see @ u[:, kept] * hankel[kept] ** -0.5).T
    return Lti(inverse @ a @ t, inverse @ b, c @ t, k.d, k.period)


def _root(gramian: Matrix) -> Matrix:
    """A square root of a positive semidefinite matrix that may be singular to working precision."""
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _anti_windup(a: Matrix, b: Matrix, c: Matrix, d: Matrix) -> NDArray[np.float64]:
    """l in x+ = a x + b eta + l (limited drive - drive): the observer gain that makes a - l c stable and fast.

    While limited, the controller's state follows what the limited drive says it should be (conditioned form). The weights b b' and
    d^2 + (c b)^2 are the drive's response to one unit of eta, so that no further tuning enters.
    """
    noise = np.array([[float(d[0, 0] ** 2 + (c @ b)[0, 0] ** 2)]])
    p = linalg.solve_discrete_are(a.T, c.T, b @ b.T + 1e-12 * np.trace(b @ b.T) * np.eye(len(a)), noise)
    return np.asarray(a @ p @ c.T / (c @ p @ c.T + noise))[:, 0]
