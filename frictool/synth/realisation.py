"""Forms of a linear controller in its document, and anti-windup gains.

The forms are a balanced discrete state space, its inverse Tustin transform, and second-order
sections.

An exact integrator (pole at z = 1) is a separate state with the coefficient 1, which rounding does
not change. If the zeros allow, the integrator is also a separate section. The remaining controller
is stable and balanced, so that rounded coefficients change it little.
"""

from __future__ import annotations

import msgspec
import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.adapters.state_space import stored_state_space
from frictool.documents.controller import LinearController
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, inverse_tustin, parallel_sum
from frictool.synth.balancing import balanced_form
from frictool.synth.pole_zero_pairs import paired_sections, section_response
from frictool.typing import ComplexVector, Matrix
from frictool.verify.feedback_loops import running_form
from frictool.verify.hinf_norm import spectral_radius
from frictool.verify.stored_forms import AT_ONE

# share of the largest Hankel singular value below which a state is left out
NEGLIGIBLE = 1e-8
INFINITE = 1e8  # zeros of larger modulus are treated as infinite


def stored_forms(k: Lti, conditional: bool = False) -> LinearController:
    """Return the discrete controller `k` in all stored forms; `k` may have one integrator.

    conditional: True for conditional integration, with anti-windup gains of 0

    Raises NoSolutionError in three cases:

    - `k` has two integrators.
    - `k` without its integrator is unstable; its states would diverge while the drive is limited.
    - The frequency responses of sections and state space differ by more than 1e-6 of the peak. With
      an integrator, the responses of (z - 1) K(z) are compared.
    """
    integrator, rest = split_integrator(k)
    radius = spectral_radius(rest.a)
    if radius >= 1.0:
        raise NoSolutionError(
            f"the controller is itself unstable (a pole of modulus {radius:.6g}); if it was "
            "synthesised, raise weights.static_error or weights.command"
        )
    kept, _ = balanced_form(rest, NEGLIGIBLE)
    whole = kept if integrator is None else parallel_sum(integrator, kept)
    sections = _sections(whole, kept.a)
    angles = np.geomspace(1e-3, np.pi, 200)
    from_sections = section_response(sections, angles)
    weight = np.ones(len(angles)) if integrator is None else np.abs(np.exp(1j * angles) - 1.0)
    direct = whole.response(angles / whole.period)[:, 0, 0]
    if np.max(weight * np.abs(from_sections - direct)) > 1e-6 * np.max(weight * np.abs(direct)):
        raise NoSolutionError(
            "the second-order sections do not have the frequency response of the controller, "
            "whose poles are ill-conditioned; relax the weights"
        )
    return LinearController(
        discrete=stored_state_space(whole),
        continuous=stored_state_space(inverse_tustin(whole)),
        sos=tuple(tuple(float(value) for value in row) for row in sections),
        anti_windup=(0.0,) * whole.order
        if conditional
        else tuple(float(one) for one in anti_windup_gains(whole.a, whole.b, whole.c, whole.d)),
        conditional=conditional,
    )


def running_in_sections(linear: LinearController, period: float) -> LinearController:
    """Return the controller that runs as sections, with anti-windup gains of the sections.

    period: sample period [s].
    """
    chain = running_form(
        msgspec.structs.replace(linear, form="sos", sos_anti_windup=(0.0,) * (2 * len(linear.sos))),
        period,
    )
    gains = anti_windup_gains(chain.a, chain.b, chain.c, chain.d)
    return msgspec.structs.replace(
        linear, form="sos", sos_anti_windup=tuple(float(value) for value in gains)
    )


def split_integrator(k: Lti) -> tuple[Lti | None, Lti]:
    """Return the integrator of `k`, and `k` minus this integrator.

    The integrator has one state with the exact pole z = 1 or s = 0, and no direct gain. It is None
    if `k` has no integrator. Raises NoSolutionError if `k` has several integrators.
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
            f"the computed controller has {near.sum()} integrators; one is allowed; lower `order`"
        )
    slope, rest = split_pole(k, exact)
    if slope == 0.0:  # unreachable or unobservable
        return None, rest
    return first_order(exact, slope, k.period), rest


def split_pole(k: Lti, pole: float) -> tuple[float, Lti]:
    """Return (residue, rest) with k = residue/(x - p) + rest, where x is s or z.

    p is the simple real pole of `k` nearest to `pole`; `rest` is a system.
    """
    _, scaling = scipy.linalg.matrix_balance(k.a, permute=False)
    # after balancing, null vectors are accurate relative to the size of each state
    k = k.transformed(scaling)
    difference = k.a - pole * np.eye(k.order)
    right = np.linalg.svd(difference)[2][-1]  # difference @ right = 0
    left = np.linalg.svd(difference.T)[2][-1]
    apart = k.transformed(np.column_stack([right, scipy.linalg.null_space(left[None, :])]))
    return float(apart.b[0, 0] * apart.c[0, 0]), Lti(
        apart.a[1:, 1:], apart.b[1:], apart.c[:, 1:], k.d, k.period
    )


def first_order(pole: float, residue: float, period: float) -> Lti:
    """Return the system residue/(s - pole) or residue/(z - pole).

    The entries b and c have equal magnitudes.

    - period: sample period [s], 0 for continuous time
    """
    size = np.sqrt(abs(residue))
    return Lti(
        np.array([[pole]]),
        np.array([[size]]),
        np.array([[np.copysign(size, residue)]]),
        np.zeros((1, 1)),
        period,
    )


def _sections(whole: Lti, kept: Matrix) -> Matrix:
    """Return second-order sections (m, 6) of the system `whole`.

    The zeros are eigenvalues of the pencil of the system matrix, which is better conditioned than a
    numerator polynomial. `kept` is the matrix of the stable part; if `whole` has one state more,
    its first state is the integrator.
    """
    a = whole.a
    b = whole.b
    c = whole.c
    d = whole.d
    n = len(a)
    pencil = scipy.linalg.eigvals(
        np.block([[a, b], [c, d]]), scipy.linalg.block_diag(np.eye(n), np.zeros((1, 1)))
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
    sections = paired_sections(zeros, poles, gain)
    # each pole without a zero delays by one sample: shift a numerator that has a free coefficient
    for _ in range(len(poles) - len(zeros)):
        row = int(np.argmin(np.abs(sections[:, 2])))
        sections[row, :3] = [0.0, sections[row, 0], sections[row, 1]]
    return np.vstack([first, sections])


def _integrator_section(
    zeros: ComplexVector, poles: ComplexVector
) -> tuple[Matrix, ComplexVector, ComplexVector]:
    """Return the section of the integrator, and the zeros and poles of the other sections.

    The section has the real zero nearest to z = 1, or no zero. If all zeros are complex and there
    are as many zeros as poles (the integrator included), the integrator shares a section with
    another pole.
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
    """Return gains l of x+ = a x + b eta + l (limited drive - drive) that make a - l c stable.

    While the drive is limited, the state follows the limited drive (conditioned form). l is a
    Kalman observer gain for the covariances b b' and d^2 + (c b)^2, the squared responses to one
    unit of eta.
    """
    if not len(a):
        return np.empty(0)
    noise = np.array([[float(d[0, 0] ** 2 + (c @ b)[0, 0] ** 2)]])
    p = scipy.linalg.solve_discrete_are(
        a.T, c.T, b @ b.T + 1e-12 * np.trace(b @ b.T) * np.eye(len(a)), noise
    )
    return np.asarray(a @ p @ c.T / (c @ p @ c.T + noise))[:, 0]
