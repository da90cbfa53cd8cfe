"""Linear time-invariant systems and their discretisation.

The period of a system distinguishes continuous and discrete time:

    x' = a x + b u      (period 0: continuous time)          y = c x + d u
    x+ = a x + b u      (period T > 0: one step every T s)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from frictool.typing import Matrix


@dataclass(frozen=True)
class Lti:
    """Matrices a (n, n), b (n, m), c (p, n), d (p, m) and the period [s], 0 for continuous time."""

    a: Matrix
    b: Matrix
    c: Matrix
    d: Matrix
    period: float

    @property
    def order(self) -> int:
        """Return the number of states."""
        return len(self.a)

    def transformed(self, t: Matrix) -> Lti:
        """Return the same system with the new state x_new, where x = t x_new."""
        inverse = np.linalg.inv(t)
        return replace(self, a=inverse @ self.a @ t, b=inverse @ self.b, c=self.c @ t)

    def response(self, frequencies: ArrayLike) -> NDArray[np.complex128]:
        """Return the responses (k, outputs, inputs) at k angular frequencies (k,) [rad/s]."""
        w = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
        point = np.exp(1j * w * self.period) if self.period else 1j * w
        inner = point[:, None, None] * np.eye(self.order) - self.a
        return np.asarray(
            self.c @ np.linalg.solve(inner, np.broadcast_to(self.b, (len(w), *self.b.shape)))
            + self.d
        )

    @property
    def stable(self) -> bool:
        """Return True if all poles are stable: Re < 0 in continuous, |z| < 1 in discrete time."""
        poles = np.linalg.eigvals(self.a)
        return bool(np.all(np.abs(poles) < 1.0) if self.period else np.all(poles.real < 0.0))


def gain(value: ArrayLike, period: float) -> Lti:
    """Return a static gain as a system; value: number or matrix (outputs, inputs)."""
    d = np.atleast_2d(np.asarray(value, dtype=np.float64))
    return Lti(np.zeros((0, 0)), np.zeros((0, d.shape[1])), np.zeros((d.shape[0], 0)), d, period)


def block_diagonal(*blocks: Matrix) -> Matrix:
    """Return the block-diagonal matrix of `blocks`; a block may have no row or no column."""
    # scipy.linalg.block_diag takes ten times as long for small blocks
    out = np.zeros((sum(len(one) for one in blocks), sum(one.shape[1] for one in blocks)))
    row = 0
    column = 0
    for one in blocks:
        out[row : row + len(one), column : column + one.shape[1]] = one
        row += len(one)
        column += one.shape[1]
    return out


def parallel_sum(first: Lti, second: Lti) -> Lti:
    """Return the parallel connection of two systems; the states of `first` come first."""
    return Lti(
        block_diagonal(first.a, second.a),
        np.vstack([first.b, second.b]),
        np.hstack([first.c, second.c]),
        first.d + second.d,
        first.period,
    )


def zero_order_hold(system: Lti, period: float) -> Lti:
    """Return the exact zero-order-hold equivalent of a continuous system at `period` [s]."""
    n, m = system.b.shape
    whole = scipy.linalg.expm(np.block([[system.a, system.b], [np.zeros((m, n + m))]]) * period)
    return Lti(whole[:n, :n], whole[:n, n:], system.c, system.d, period)


def tustin(system: Lti, period: float, prewarp: float = 0.0) -> Lti:
    """Return the Tustin equivalent of a continuous system at `period` [s].

    The frequency response is exact at `prewarp` [rad/s]. Raises ValueError if `prewarp` is not
    below half the sampling frequency.
    """
    if prewarp * period >= np.pi:
        raise ValueError(
            f"the prewarping frequency {prewarp:g} rad/s is not below half the sampling "
            f"frequency, {np.pi / period:g} rad/s"
        )
    half = np.tan(0.5 * prewarp * period) / prewarp if prewarp else 0.5 * period
    identity = np.eye(system.order)
    inverse = np.linalg.inv(identity - half * system.a)
    root = np.sqrt(2.0 * half)
    return Lti(
        inverse @ (identity + half * system.a),
        root * inverse @ system.b,
        root * system.c @ inverse,
        system.d + half * system.c @ inverse @ system.b,
        period,
    )


def inverse_tustin(system: Lti) -> Lti:
    """Return the continuous system whose Tustin equivalent without prewarping is `system`.

    The substitution is z = (1 + s T/2)/(1 - s T/2).
    """
    identity = np.eye(system.order)
    inverse = np.linalg.inv(system.a + identity)
    period = system.period
    return Lti(
        2.0 / period * (system.a - identity) @ inverse,
        2.0 / np.sqrt(period) * inverse @ system.b,
        2.0 / np.sqrt(period) * system.c @ inverse,
        system.d - system.c @ inverse @ system.b,
        0.0,
    )


def delay(samples: int, period: float) -> Lti:
    """Return a delay of one signal by `samples` steps; the first state is the newest sample."""
    a = np.eye(samples, k=-1)
    b = np.zeros((samples, 1))
    c = np.zeros((1, samples))
    if samples:
        b[0, 0] = c[0, -1] = 1.0
    return Lti(a, b, c, np.full((1, 1), 0.0 if samples else 1.0), period)
