"""Parametrised controller of fixed order with integrator, bounded poles and optional roll-off.

                n0 + n1 (s/w0) + ... + nr (s/w0)^r
 K(s) = k ---------------------------------------------------,   r = order, or order - 1
          (s/w0)^i  prod (1 + s/p)  prod (1 + 2 m s/w + s²/w²)     with roll-off

 p = b e^u                                one real pole, if the number of free poles is odd
 w = b e^u,  m = m_lo^(1-y) m_hi^y        a pair, with m_hi = (b/w + w/b)/2 = cosh(u)
 parameters (u <= 0, ..., [u <= 0, 0 <= y <= 1], ..., n0 ... nr)

k is the gain, w0 a frequency that scales the coefficients, and b the largest modulus of a pole; i
is 1 with an integrator, else 0. p is a real pole; w and m are the natural frequency and the damping
of a pair of poles, u and y the parameters of the poles, and m_lo is the least damping.

A pair represents any two poles in the left half plane with modulus at most b and damping at least
m_lo, complex or real. With w <= b, at least one pole of a real pair is within b. With m <= m_hi
the polynomial is nonnegative at -b, so that the other pole is within b too. Two real poles can
therefore become a complex pair, or a complex pair two real poles, while the parameters change
continuously.

A sampled controller is the Tustin image of such a K, s = (2/T)(z - 1)/(z + 1); every sampled
controller without a pole at z = -1 has this form. With b = 2/T no pole has a negative real part in
z, so that no mode of the controller alternates from sample to sample. With roll-off the response is
zero at half the sampling frequency.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from frictool.plant.lti import Lti, parallel_sum, tustin
from frictool.typing import ComplexVector, Vector

SLOWEST = 1e-5  # smallest free pole, as a share of the bound b
LEAST_DAMPING = 0.1  # m_lo
_LOWEST = float(np.log(SLOWEST))


@dataclass(frozen=True)
class StructuredController:
    """Structure of a controller; the methods take the array of its parameters.

    The module docstring defines K and the symbols.

    - order: number of poles of K, at least 1
    - integrator: if True, one of these poles is an integrator (i = 1)
    - rolls_off: if True, the numerator has the degree r = order - 1, else r = order
    - bound: largest modulus b of a pole [rad/s]
    - around: frequency w0 that scales the coefficients [rad/s]
    - gain: gain k [drive per rad | m]
    - period: sample period T [s], 0 for continuous time
    """

    order: int
    integrator: bool
    rolls_off: bool
    bound: float
    around: float
    gain: float
    period: float = 0.0

    @property
    def free(self) -> int:
        """Return the number of poles other than the integrator."""
        return self.order - self.integrator

    @property
    def numerator(self) -> int:
        """Return the number of numerator coefficients n0 ... nr."""
        return self.order + 1 - self.rolls_off

    @property
    def size(self) -> int:
        """Return the number of parameters."""
        return self.free + self.numerator

    def limits(self) -> tuple[Vector, Vector]:
        """Return lower and upper bounds (size,) of the parameters; n0 ... nr are unbounded."""
        low = np.full(self.size, -np.inf)
        high = np.zeros(self.size)
        low[: self.free] = _LOWEST
        high[self.free :] = np.inf
        dampings = slice(self.free % 2 + 1, self.free, 2)
        low[dampings], high[dampings] = 0.0, 1.0
        return low, high

    def wider(self) -> StructuredController:
        """Return the same structure with one more pole."""
        return replace(self, order=self.order + 1)

    def grown(self, parameters: Vector, pole: float) -> Vector:
        """Return the parameters with which the structure `wider` describes the same controller.

        The added pole is at `pole` [rad/s], and a zero cancels it.
        """
        above = np.polymul(parameters[self.free :][::-1], [self.around / pole, 1.0])[::-1]
        u = max(_LOWEST, min(0.0, float(np.log(pole / self.bound))))
        if self.free % 2 == 0:
            return np.concatenate([[u], parameters[: self.free], above])
        # w² = p1 p2, m = (p1 + p2)/(2 w)
        middle = 0.5 * (u + parameters[0])
        apart = 0.5 * abs(u - parameters[0])
        widest = np.log(np.cosh(middle)) - np.log(LEAST_DAMPING)
        y = (np.log(np.cosh(apart)) - np.log(LEAST_DAMPING)) / widest
        return np.concatenate([[middle, min(1.0, y)], parameters[1 : self.free], above])

    def points(self, frequencies: Vector) -> ComplexVector:
        """Return the values of s (k,) at angular frequencies (k,) [rad/s].

        For a sampled controller, s is the value of Tustin's map on the unit circle.
        """
        w = frequencies
        return np.asarray(
            1j * (2.0 / self.period * np.tan(0.5 * w * self.period) if self.period else w),
            dtype=np.complex128,
        )

    def response(
        self, parameters: Vector, points: ComplexVector
    ) -> tuple[ComplexVector, ComplexVector]:
        """Return the response K (k,) and its derivatives (k, size) with respect to the parameters.

        points: complex frequencies s (k,), as `points` returns them.
        """
        x = points / self.around
        factors, slopes = self._denominator(parameters, points)
        powers = x[:, None] ** np.arange(self.numerator)
        over = self.gain / (np.prod(factors, axis=1) * (x if self.integrator else 1.0))
        k = (powers @ parameters[self.free :]) * over
        owner = self._owners()
        derivatives = np.concatenate(
            [-k[:, None] * slopes / factors[:, owner], powers * over[:, None]], axis=1
        )
        return k, derivatives

    def _owners(self) -> NDArray[np.intp]:
        odd = self.free % 2
        return np.array([0] * odd + [odd + j // 2 for j in range(self.free - odd)], dtype=np.intp)

    def _denominator(
        self, parameters: Vector, s: ComplexVector
    ) -> tuple[ComplexVector, ComplexVector]:
        """Return the factors (k, factors) of the denominator at s (k,), and their derivatives.

        The derivatives with respect to the `free` parameters of the poles have the shape (k, free).
        """
        factors = []
        slopes = []
        at = 0
        if self.free % 2:
            pole = self.bound * np.exp(parameters[0])
            factors.append(1.0 + s / pole)
            slopes.append(-s / pole)
            at = 1
        while at < self.free:
            u = parameters[at]
            y = parameters[at + 1]
            w, m = self._pair(u, y)
            factors.append(1.0 + 2.0 * m * s / w + (s / w) ** 2)
            slopes.append(2.0 * m * s / w * (y * np.tanh(u) - 1.0) - 2.0 * (s / w) ** 2)
            slopes.append(2.0 * m * s / w * (np.log(np.cosh(u)) - np.log(LEAST_DAMPING)))
            at += 2
        return np.array(factors).reshape(-1, len(s)).T, np.array(slopes).reshape(-1, len(s)).T

    def _pair(self, u: float, y: float) -> tuple[float, float]:
        return self.bound * float(np.exp(u)), float(LEAST_DAMPING ** (1.0 - y) * np.cosh(u) ** y)

    def factors(self, parameters: Vector) -> list[Vector]:
        """Return the monic factors of the free poles' polynomial in s/w0, highest power first."""
        odd = self.free % 2
        w0 = self.around
        sections = [np.array([1.0, self.bound * np.exp(parameters[0]) / w0])] if odd else []
        for j in range(odd, self.free, 2):
            w, m = self._pair(parameters[j], parameters[j + 1])
            sections.append(np.array([1.0, 2.0 * m * w / w0, (w / w0) ** 2]))
        return sections

    def system(self, parameters: Vector) -> Lti:
        """Return the controller as a linear system in continuous or discrete time.

        The integrator is a separate state; its pole is exactly s = 0, or z = 1 if sampled.
        """
        continuous = self._continuous(parameters)
        if not self.period:
            return continuous
        if not self.integrator:
            return tustin(continuous, self.period)
        rest = Lti(continuous.a[1:, 1:], continuous.b[1:], continuous.c[:, 1:], continuous.d, 0.0)
        return parallel_sum(
            tustin(_integrator(float(continuous.c[0, 0])), self.period), tustin(rest, self.period)
        )

    def _continuous(self, parameters: Vector) -> Lti:
        factors = self.factors(parameters)
        above = self.gain * parameters[self.free :][::-1]
        for factor in factors:
            above = above * factor[-1]  # the factors in the formula are 1 at s = 0, these are monic
        if not self.integrator:
            return chain(above, factors, self.around)
        below = np.ones(1)
        for factor in factors:
            below = np.convolve(below, factor)
        residue = above[-1] / below[-1]
        above = np.polysub(above, residue * below)[:-1]  # (N - r D)/x: the constant term is zero
        return parallel_sum(_integrator(residue * self.around), chain(above, factors, self.around))


def chain(above: Vector, factors: list[Vector], around: float) -> Lti:
    """Return the system N/(q1 q2 ... qm), polynomials in x = s/w0, as a chain of blocks.

    - above: coefficients of N
    - factors: monic polynomials q1 ... qm, highest power first
    - around: frequency w0 [rad/s]

    The blocks are 1/qm, then 1/q(m-1) ... 1/q1, each with separate output coefficients. N = r1 + q1
    (r2 + q2 (r3 + ... + qm d)), so that N/D = r1/(q1 ... qm) + r2/(q2 ... qm) + ... + rm/qm + d.
    The diagonal blocks keep the poles even if poles nearly coincide; a companion form of the
    product would lose this accuracy. q1 has the slowest poles: division by a factor with fast poles
    multiplies the coefficients of the remainders, whose sum would then cancel at low frequencies.
    """
    factors = sorted(factors, key=lambda factor: factor[-1] ** (1.0 / (len(factor) - 1)))
    n = sum(len(factor) - 1 for factor in factors)
    a = np.zeros((n, n))
    b = np.zeros((n, 1))
    c = np.zeros((1, n))
    end = n
    for number, factor in enumerate(factors):
        size = len(factor) - 1
        above, rest = _divided(above, factor)
        start = end - size
        a[start:end, start:end] = np.eye(size, k=-1)
        a[start, start:end] = -factor[1:]
        c[0, start:end] = rest
        if number + 1 < len(factors):
            a[start, start - 1] = 1.0  # the output of the previous block is its last state
        else:
            b[start] = 1.0
        end = start
    return Lti(around * a, around * b, c, np.array([[np.sum(above)]]), 0.0)


def _divided(above: Vector, factor: Vector) -> tuple[Vector, Vector]:
    """Return quotient and remainder of the division of a polynomial by a monic factor.

    The remainder has as many coefficients as the degree of the factor, including leading zeros.
    """
    size = len(factor) - 1
    rest = np.concatenate([np.zeros(max(0, size - len(above))), above])
    quotient = rest[: len(rest) - size].copy()
    for k in range(len(quotient)):
        quotient[k] = rest[k]
        rest[k : k + size + 1] -= quotient[k] * factor
    return quotient, rest[len(rest) - size :]


def _integrator(slope: float) -> Lti:
    return Lti(np.zeros((1, 1)), np.ones((1, 1)), np.array([[slope]]), np.zeros((1, 1)), 0.0)
