"""Pole placement by the Diophantine equation of an RST controller with an integrator.

    R u = T r - S y    R = x R' monic with an integrator    A R + B S = P
    closed loop: y = B T/P r

r is the reference, y the measurement, u the drive, B/A the plant and P the desired denominator. The
variable x of all polynomials is s/w0 in continuous time and (z - 1)/(w0 h) at a sample period h. In
both domains an integrator is a root at x = 0, and the coefficients have similar sizes; in powers of
z, the equations would be ill-conditioned at 1 kHz. With deg A = n and deg R = m, R' has m - 1
unknown coefficients, S has n + 1, and P has n + m. The solution is unique if A x and B have no
common root.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictool.plant.lti import Lti, parallel_sum
from frictool.synth.structured_controller import chain
from frictool.typing import Vector


@dataclass(frozen=True)
class PlacementVariable:
    """Normalised variable x of the polynomials: s/w0, or (z - 1)/(w0 h) for sampled plants.

    `around` is w0 [rad/s]; `period` is the sample period h [s], 0 for continuous time.
    """

    around: float
    period: float = 0.0

    def pole(self, s: complex) -> complex:
        """Return the value of the variable x for the continuous pole s [rad/s].

        In discrete time, the pole is sampled first: z = exp(s h).
        """
        return (
            complex(np.expm1(s * self.period) / (self.around * self.period))
            if self.period
            else s / self.around
        )

    @property
    def step(self) -> float:
        """Return the change of s [rad/s], or of z, for a change of x by 1."""
        return self.around * self.period if self.period else self.around

    def polynomials(self, plant: Lti) -> tuple[Vector, Vector]:
        """Return A (monic, degree n) and B (degree below n) of a strictly proper SISO plant B/A.

        A and B are coefficients of the powers of x, the highest power first.
        """
        a = (plant.a - np.eye(plant.order)) / self.step if self.period else plant.a / self.step
        below = _characteristic(a)
        above = _characteristic(a - plant.b @ plant.c / self.step) - below
        return below, np.asarray(above[1:], dtype=np.float64)

    def system(self, above: Vector, below: Vector) -> Lti:
        """Return N(x)/(x D(x)) as a system whose first state is the integrator.

        `above` and `below` are the coefficients of N and of the monic D, highest power first.
        """
        residue = above[-1] / below[-1]
        rest = chain(np.polysub(above, residue * below)[:-1], [below], 1.0)
        first = Lti(np.zeros((1, 1)), np.ones((1, 1)), np.array([[residue]]), np.zeros((1, 1)), 0.0)
        whole = parallel_sum(first, rest)
        a = np.eye(whole.order) + self.step * whole.a if self.period else self.step * whole.a
        return Lti(a, self.step * whole.b, whole.c, whole.d, self.period)


def place_poles(a: Vector, b: Vector, p: Vector, order: int) -> tuple[Vector, Vector]:
    """Return R' (monic, degree order - 1) and S (degree n = deg A) with A x R' + B S = P.

    Polynomials have the highest power first: `a` is monic of shape (n + 1,), `b` has at most n
    coefficients, `p` is monic of shape (n + order + 1,). Raises numpy.linalg.LinAlgError if A x and
    B have a common root, ValueError if `order` is below n.
    """
    n = len(a) - 1
    if order < n:
        raise ValueError(f"order {order} is below the plant's {n}")
    extended = np.append(a, 0.0)  # A x
    # columns of R'
    columns = [_shifted(extended, order - 1 - k, n + order + 1) for k in range(order)]
    columns += [_shifted(b, n - k, n + order + 1) for k in range(n + 1)]  # columns of S
    matrix = np.array(columns).T
    unknown = np.asarray(np.linalg.solve(matrix[1:, 1:], (p - matrix[:, 0])[1:]), dtype=np.float64)
    return np.concatenate([[1.0], unknown[: order - 1]]), unknown[order - 1 :]


def _characteristic(a: Vector) -> Vector:
    return np.asarray(np.real(np.poly(a)), dtype=np.float64)


def polynomial(roots: Sequence[complex]) -> Vector:
    """Return the monic polynomial with the given roots, which are real or conjugate pairs."""
    return np.asarray(np.real(np.poly(np.asarray(roots))))


def _shifted(coefficients: Vector, power: int, length: int) -> Vector:
    row = np.zeros(length)
    end = length - power
    row[end - len(coefficients) : end] = coefficients
    return row
