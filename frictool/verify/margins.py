"""How far the sampled loop is from instability, in the directions that an engineer asks for, around
one plant.

L(z) = C(z) P(z) z^-d, u = C eta and eta = s - position. Stability ends where L passes through -1:

    gain      k L = -1            factors k > 1 and k < 1, at the frequencies where L is real and
              negative
    phase     e^(-j phi) L = -1   at the frequencies where |L| = 1; either sign counts
    delay     e^(-j w T) L = -1   additional lag only; exact in the sampled loop for whole samples,
              and how it is usually meant in between
    modulus   min |1 + L| = 1/max |S| (5.57), all of these at once

Crossings are generalised eigenvalues on the unit circle, of L(z) - L(1/z) and of L(z) L(1/z) - 1,
and sign changes on a grid, whichever finds them; each one is refined on L itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigvals
from scipy.optimize import brentq

from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.plant.lti import Lti, delay
from frictool.verify.hinf_norm import norm

Vector = NDArray[np.float64]

NEAR_CIRCLE = 1e-3  # an eigenvalue within this of the unit circle is looked at
LOOKS = 1500  # points of the grid, over six decades below half the sampling frequency
NOTHING = 1e-9  # |L| below this is zero: a roll-off at half the sampling frequency bounds no gain
REAL = 1e-6  # a crossing is one where |f| is below this part of |L| + 1


@dataclass(frozen=True)
class LoopMargins:
    """Of one loop; all of them 0 (and gain_up 1) where it is unstable.

    gain_up: factor by which the gain may rise, inf without an end. gain_down: factor in [0, 1) down
    to which it may fall. phase [rad], delay [s], delay_samples. modulus: min |1 + L|. crossing
    [rad/s]: the highest frequency where |L| = 1, nan without one.
    """

    gain_up: float
    gain_down: float
    phase: float
    delay: float
    delay_samples: float
    modulus: float
    crossing: float


def open_loop(controller: Lti, rates: AxisRates, lag: float, delay_samples: int) -> Lti:
    """L, from eta to the position, around one plant; lag [s]."""
    blocks = {
        "controller": DiagramBlock(controller, ("error",), ("u",)),
        "delay": DiagramBlock(delay(delay_samples, controller.period), ("u",), ("command",)),
        "axis": linear_axis(rates, lag, controller.period),
    }
    sums: dict[str, dict[str, float]] = {
        "speed_reference": {},
        "friction": {},
        "uncertain_effort": {},
        "position": {"eta": -1.0},
    }
    return connect(blocks, sums, ("error",), ("position",))


def margins(controller: Lti, rates: AxisRates, lag: float, delay_samples: int) -> LoopMargins:
    """The margins of the sampled loop around one plant; lag [s]."""
    return loop_margins(open_loop(controller, rates, lag, delay_samples))


def loop_margins(loop: Lti) -> LoopMargins:
    """The margins of a sampled loop gain `loop`, one input and one output, whose closed loop has
    the feedback -1."""
    peak, _ = norm(sensitivity(loop))
    if not np.isfinite(peak):
        return LoopMargins(1.0, 1.0, 0.0, 0.0, 0.0, 0.0, np.nan)
    at_phase, at_gain = phase_crossings(loop), gain_crossings(loop)
    real = loop.response(at_phase)[:, 0, 0].real if at_phase.size else np.empty(0)
    factors = -1.0 / real[real < -NOTHING]
    lags = (
        np.mod(np.angle(loop.response(at_gain)[:, 0, 0]) + np.pi, 2.0 * np.pi)
        if at_gain.size
        else np.empty(0)
    )
    wait = float(np.min(lags / at_gain, initial=np.inf))
    return LoopMargins(
        gain_up=float(np.min(factors[factors > 1.0], initial=np.inf)),
        gain_down=float(np.max(factors[factors < 1.0], initial=0.0)),
        phase=float(np.min(np.minimum(lags, 2.0 * np.pi - lags), initial=np.pi)),
        delay=wait,
        delay_samples=wait / loop.period,
        modulus=1.0 / peak,
        crossing=float(np.max(at_gain)) if at_gain.size else np.nan,
    )


def small_gain(controller: Lti, rates: AxisRates, lag: float, delay_samples: int) -> float:
    """||H_v/w|| of annex (27): the peak gain from the friction w in [-1, 1] to the speed [rad/s or
    m/s]; inf for an unstable loop.

    The annex asks for at most 1 and concludes stability from |sign(v)| <= 1. Read with its unit:
    sign(v) is bounded by |v|/N for speeds beyond N only, so that a norm of N says that no
    oscillation with a speed always beyond N can keep itself up by friction. It is not a proof near
    v = 0, where the gain of sign is without bound; there friction takes energy out, and the
    simulated loop has to tell.
    """
    period = controller.period
    blocks = {
        "controller": DiagramBlock(controller, ("eta",), ("u",)),
        "delay": DiagramBlock(delay(delay_samples, period), ("u",), ("command",)),
        "axis": linear_axis(rates, lag, period),
    }
    return norm(
        connect(blocks, {"speed_reference": {}, "uncertain_effort": {}}, ("friction",), ("speed",))
    )[0]


def phase_crossings(loop: Lti) -> Vector:
    """Angular frequencies [rad/s] in (0, pi/T] where L is real, sorted."""
    n = loop.order
    zero = np.zeros
    # z x = a x + b u,  p = z (a p + b u),  c x = c p
    m = np.block(
        [
            [loop.a, zero((n, n)), loop.b],
            [zero((n, n)), np.eye(n), zero((n, 1))],
            [loop.c, -loop.c, zero((1, 1))],
        ]
    )
    e = np.block(
        [
            [np.eye(n), zero((n, n)), zero((n, 1))],
            [zero((n, n)), loop.a, loop.b],
            [zero((1, 2 * n + 1))],
        ]
    )
    return np.append(_refined(loop, m, e, lambda value: float(np.imag(value))), np.pi / loop.period)


def gain_crossings(loop: Lti) -> Vector:
    """Angular frequencies [rad/s] in (0, pi/T) where |L| = 1, sorted."""
    n = loop.order
    zero, a, b, c, d = np.zeros, loop.a, loop.b, loop.c, loop.d
    # z x = a x + b u,  v = c x + d u,  p = z (a p + b v),  c p + d v = u
    m = np.block(
        [
            [a, zero((n, n)), b],
            [zero((n, n)), np.eye(n), zero((n, 1))],
            [d @ c, c, d @ d - np.eye(1)],
        ]
    )
    e = np.block(
        [[np.eye(n), zero((n, n)), zero((n, 1))], [b @ c, a, b @ d], [zero((1, 2 * n + 1))]]
    )
    return _refined(loop, m, e, lambda value: float(np.abs(value) - 1.0))


def _refined(loop: Lti, m: Vector, e: Vector, function: Callable[[complex], float]) -> Vector:
    """The roots in (0, pi/T) of `function` of L near the eigenvalues of z e - m on the unit circle,
    and at sign changes on a grid."""
    period, last = loop.period, np.pi * (1.0 - 1e-9)
    values = eigvals(m, e)
    values = values[np.isfinite(values)]
    angles = np.abs(np.angle(values[np.abs(np.abs(values) - 1.0) < NEAR_CIRCLE]))
    angles = angles[(angles > 1e-7) & (angles < last)]
    looked = np.unique(
        np.concatenate(
            [
                np.geomspace(1e-6, last, LOOKS),
                angles,
                angles * (1.0 - 1e-6),
                np.minimum(angles * (1.0 + 1e-6), last),
            ]
        )
    )
    responses = loop.response(looked / period)[:, 0, 0]

    def at(angle: float) -> float:
        return function(complex(loop.response(angle / period)[0, 0, 0]))

    heights = np.array([function(complex(value)) for value in responses])
    roots = [float(angle) for angle in looked[heights == 0.0]]
    for k in np.flatnonzero(heights[:-1] * heights[1:] < 0.0):
        root = float(brentq(at, looked[k], looked[k + 1], xtol=1e-14, rtol=1e-13))
        if abs(at(root)) < REAL * (
            1.0 + abs(loop.response(root / period)[0, 0, 0])
        ):  # and not a pole, where it jumps
            roots.append(root)
    return np.array(sorted(roots)) / period


def sensitivity(loop: Lti) -> Lti:
    """1/(1 + L)."""
    inverse = 1.0 / (1.0 + loop.d[0, 0])
    return Lti(
        loop.a - inverse * loop.b @ loop.c,
        inverse * loop.b,
        -inverse * loop.c,
        np.array([[inverse]]),
        loop.period,
    )
