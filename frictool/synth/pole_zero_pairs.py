"""Second-order sections from the poles and zeros of a discrete system, as scipy computes them.

The last section has the pole nearest to the unit circle and the zeros nearest to this pole. The
section before the last has the next pole, and so on. Zeros in the same section thus compensate the
large gain near a pole. The tests compare the sections with `scipy.signal.zpk2sos`. `scipy.signal`
is not imported here, because the import takes 0.7 s, a third of `synth --vertices-only`.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import ComplexVector, Matrix, Vector

REAL = 100.0 * float(np.finfo(np.float64).eps)  # |imaginary part|/modulus of a real number


def paired_sections(zeros: ComplexVector, poles: ComplexVector, gain: float) -> Matrix:
    """Return second-order sections (m, 6) of a system; the first section contains `gain`.

    Poles and zeros are real or pairs of conjugate numbers. Poles or zeros at z = 0 are added, so
    that their numbers are equal and even.
    """
    count = max(len(zeros), len(poles), 1)
    count += count % 2
    zeros_left = _halves(np.append(zeros, np.zeros(count - len(zeros))))
    poles_left = _halves(np.append(poles, np.zeros(count - len(poles))))
    sections = np.empty((count // 2, 6))
    for row in sections[::-1]:
        pole, poles_left = _taken(poles_left, np.abs(1.0 - np.abs(poles_left)))
        if pole.imag:
            poles_taken = [pole, pole.conjugate()]
        else:
            other, poles_left = _taken(poles_left, _real(poles_left, 1.0 - np.abs(poles_left)))
            poles_taken = [pole, other]
        zero, zeros_left = _taken(zeros_left, np.abs(zeros_left - pole))
        if zero.imag:
            zeros_taken = [zero, zero.conjugate()]
        else:
            other, zeros_left = _taken(zeros_left, _real(zeros_left, zeros_left - pole))
            zeros_taken = [zero, other]
        row[:3] = np.poly(np.array(zeros_taken))
        row[3:] = np.poly(np.array(poles_taken))
    sections[0, :3] *= gain
    return sections


def section_response(sections: Matrix, angles: Vector) -> ComplexVector:
    """Return the frequency response (n,) of sections (m, 6) at z = exp(j angles), angles (n,)."""
    powers = np.exp(-1j * np.outer(np.arange(3), angles))
    return np.asarray(np.prod((sections[:, :3] @ powers) / (sections[:, 3:] @ powers), axis=0))


def _halves(values: ComplexVector) -> ComplexVector:
    """Return one number of each conjugate pair, then the real numbers, both in rising order.

    A pair is represented by its number with positive imaginary part. Because the two numbers are
    conjugate only up to rounding, this number is averaged with the conjugate of the other.
    """
    ordered = values[np.lexsort((np.abs(values.imag), values.real))]
    is_real = np.abs(ordered.imag) <= REAL * np.abs(ordered)
    upper = ordered[~is_real & (ordered.imag > 0.0)]
    partners = ordered[~is_real & (ordered.imag < 0.0)].conj()
    means = [0.5 * (one + partners[np.argmin(np.abs(partners - one))]) for one in upper]
    return np.array([*means, *ordered[is_real].real], dtype=np.complex128)


def _real(values: ComplexVector, distances: ComplexVector | Vector) -> Vector:
    return np.where(values.imag == 0.0, np.abs(distances), np.inf)


def _taken(values: ComplexVector, distances: Vector) -> tuple[complex, ComplexVector]:
    at = int(np.argmin(distances))
    return complex(values[at]), np.delete(values, at)
