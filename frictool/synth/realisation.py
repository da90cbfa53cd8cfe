"""The controller's stored forms: a balanced realisation, its inverse Tustin image, second-order
sections, anti-windup gains.

An exact integrator, a pole at z = 1, is kept apart: a state of its own whose coefficient is 1 and
stays 1 whatever the numbers are rounded to, and a section of its own where the zeros allow it. The
rest is stable and is balanced, so that rounding its coefficients hurts least.
"""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

from frictool.documents.controller import LinearController
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, inverse_tustin, parallel_sum
from frictool.synth.balancing import balanced_form
from frictool.verify.feedback_loops import running_form
from frictool.verify.hinf_norm import spectral_radius

Matrix = NDArray[np.float64]
Roots = NDArray[np.complex128]
# Hankel singular value, of the largest: below what a solver resolves (the delayed command is known
# exactly)
NEGLIGIBLE = 1e-8
INFINITE = 1e8  # a zero beyond this is one at infinity
AT_ONE = 1e-9  # a pole nearer to z = 1 is meant to be an integrator


def stored_forms(k: Lti) -> LinearController:
    """Every stored form of the discrete controller `k`, which may have one integrator.

    Raises NoSolutionError where the rest of the controller is unstable (it would run away whenever
    the loop is open: in the limit, at rest), where it has two integrators, or where the sections do
    not reproduce the state space (checked on the unit circle to 1e-6 of the peak, that of (z - 1)
    K(z) with an integrator).
    """
    integrator, rest = split_integrator(k)
    radius = spectral_radius(rest.a)
    if radius >= 1.0:
        raise NoSolutionError(
            f"the controller found is itself unstable (a pole of modulus {radius:.6g}); raise weights.static_error or weights.command"
        )
    kept, _ = balanced_form(rest, NEGLIGIBLE)
    whole = kept if integrator is None else parallel_sum(integrator, kept)
    sections = _sections(whole, kept.a)
    angles = np.geomspace(1e-3, np.pi, 200)
    _, from_sections = signal.sosfreqz(sections, worN=angles)
    weight = np.ones(len(angles)) if integrator is None else np.abs(np.exp(1j * angles) - 1.0)
    direct = whole.response(angles / whole.period)[:, 0, 0]
    if np.max(weight * np.abs(from_sections - direct)) > 1e-6 * np.max(weight * np.abs(direct)):
        raise NoSolutionError(
            "the second-order sections of the controller do not reproduce it; its poles are too ill-conditioned, relax the weights"
        )
    return LinearController(
        discrete=whole.document(),
        continuous=inverse_tustin(whole).document(),
        sos=tuple(tuple(float(value) for value in row) for row in sections),
        anti_windup=tuple(
            float(value) for value in anti_windup_gains(whole.a, whole.b, whole.c, whole.d)
        ),
    )


def running_in_sections(linear: LinearController, period: float) -> LinearController:
    """The same controller whose sections run on the target, with the anti-windup gains of their
    states; period [s]."""
    chain = running_form(
        msgspec.structs.replace(linear, form="sos", sos_anti_windup=(0.0,) * (2 * len(linear.sos))),
        period,
    )
    gains = anti_windup_gains(chain.a, chain.b, chain.c, chain.d)
    return msgspec.structs.replace(
        linear, form="sos", sos_anti_windup=tuple(float(value) for value in gains)
    )


def split_integrator(k: Lti) -> tuple[Lti | None, Lti]:
    """The part of `k` with its pole at z = 1 or s = 0 (one state, coefficient exact, no direct
    gain), None without one; and the rest.

    Raises NoSolutionError where more than one pole is there.
    """
    exact = 1.0 if k.period else 0.0
    poles = np.linalg.eigvals(k.a) if k.order else np.empty(0)
    near = np.abs(poles - exact) < AT_ONE * (
        1.0 if k.period else np.max(np.abs(poles), initial=0.0)
    )
    if not near.any():
        return None, k
    if near.sum() > 1:
        raise NoSolutionError(
            f"the controller found has {near.sum()} integrators; one is allowed: lower order"
        )
    slope, rest = split_pole(k, exact)
    if slope == 0.0:  # nothing enters it or leaves it
        return None, rest
    return first_order(exact, slope, k.period), rest


def split_pole(k: Lti, pole: float) -> tuple[float, Lti]:
    """The residue of the simple real pole of `k` nearest to `pole`, and `k` without that pole: k =
    residue/(s - pole) + rest."""
    _, scaling = linalg.matrix_balance(k.a, permute=False)
    k = k.transformed(scaling)  # whose vectors are known to the rounding of each state's own size
    difference = k.a - pole * np.eye(k.order)
    right = np.linalg.svd(difference)[2][-1]  # difference @ right = 0
    left = np.linalg.svd(difference.T)[2][-1]
    apart = k.transformed(np.column_stack([right, linalg.null_space(left[None, :])]))
    return float(apart.b[0, 0] * apart.c[0, 0]), Lti(
        apart.a[1:, 1:], apart.b[1:], apart.c[:, 1:], k.d, k.period
    )


def first_order(pole: float, residue: float, period: float) -> Lti:
    """residue/(s - pole) or residue/(z - pole), as much of it before the state as behind."""
    size = np.sqrt(abs(residue))
    return Lti(
        np.array([[pole]]),
        np.array([[size]]),
        np.array([[np.copysign(size, residue)]]),
        np.zeros((1, 1)),
        period,
    )


def _sections(whole: Lti, kept: Matrix) -> Matrix:
    """Second-order sections (m, 6) of the transfer function, zeros from the pencil of the system
    matrix and not from a polynomial.

    kept: the stable part's matrix; where the whole has one state more, that is the integrator,
    first.
    """
    a, b, c, d = whole.a, whole.b, whole.c, whole.d
    n = len(a)
    pencil = linalg.eigvals(
        np.block([[a, b], [c, d]]), linalg.block_diag(np.eye(n), np.zeros((1, 1)))
    )
    zeros = np.asarray(
        pencil[np.isfinite(pencil) & (np.abs(pencil) < INFINITE)], dtype=np.complex128
    )
    poles = np.asarray(np.linalg.eigvals(kept) if kept.size else np.empty(0), dtype=np.complex128)
    everyone = np.append(poles, np.ones(n - len(poles)))
    probe = 2.0  # any point outside the unit circle
    response = (c @ np.linalg.solve(probe * np.eye(n) - a, b) + d)[0, 0]
    gain = float(np.real(response * np.prod(probe - everyone) / np.prod(probe - zeros)))
    first, zeros, poles = (
        _integrator_section(zeros, poles) if len(poles) < n else (np.empty((0, 6)), zeros, poles)
    )
    if len(first) and not len(poles):
        return np.asarray(first * [gain, gain, gain, 1.0, 1.0, 1.0])
    sections = np.asarray(signal.zpk2sos(zeros, poles, gain))
    for _ in range(
        len(poles) - len(zeros)
    ):  # each pole without a zero is a sample of delay: a numerator that has room moves by one
        row = int(np.argmin(np.abs(sections[:, 2])))
        sections[row, :3] = [0.0, sections[row, 0], sections[row, 1]]
    return np.vstack([first, sections])


def _integrator_section(zeros: Roots, poles: Roots) -> tuple[Matrix, Roots, Roots]:
    """The integrator's own section with the real zero nearest to it, or with none; and the zeros
    and poles that are left.

    Where every zero is complex and none is missing, no first-order section is proper: the
    integrator shares a section with another pole.
    """
    real = np.flatnonzero(zeros.imag == 0.0)
    if real.size:
        nearest = real[np.argmin(np.abs(zeros[real] - 1.0))]
        return (
            np.array([[1.0, -zeros[nearest].real, 0.0, 1.0, -1.0, 0.0]]),
            np.delete(zeros, nearest),
            poles,
        )
    if len(zeros) <= len(poles):
        return np.array([[0.0, 1.0, 0.0, 1.0, -1.0, 0.0]]), zeros, poles
    return np.empty((0, 6)), zeros, np.append(poles, 1.0)


def anti_windup_gains(a: Matrix, b: Matrix, c: Matrix, d: Matrix) -> NDArray[np.float64]:
    """l in x+ = a x + b eta + l (limited drive - drive): the observer gain that makes a - l c
    stable and fast.

    While limited, the controller's state follows what the limited drive says it should be
    (conditioned form). The weights b b' and d^2 + (c b)^2 are the drive's response to one unit of
    eta, so that no further tuning enters.
    """
    if not len(a):
        return np.empty(0)
    noise = np.array([[float(d[0, 0] ** 2 + (c @ b)[0, 0] ** 2)]])
    p = linalg.solve_discrete_are(
        a.T, c.T, b @ b.T + 1e-12 * np.trace(b @ b.T) * np.eye(len(a)), noise
    )
    return np.asarray(a @ p @ c.T / (c @ p @ c.T + noise))[:, 0]
