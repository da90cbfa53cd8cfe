"""Gain, phase, delay and modulus margins of the sampled loop with one plant.

L(z) = C(z) P(z) z^-d is the loop gain of the controller C, the plant P and a delay of d samples,
and S = 1/(1 + L). The margins are the smallest changes for which L passes through -1:

    gain      k L = -1             factors k > 1 and k < 1, at the frequencies where L is real
                                   and negative
    phase     e^(-j phi) L = -1    at the frequencies where |L| = 1; phi of either sign
    delay     e^(-j w T) L = -1    additional lag only; exact for whole sample periods, else the
                                   usual continuous definition
    modulus   min |1 + L| = 1/max |S| (thesis 5.57), any combination of gain and phase

The frequencies are zeros of L(z) - L(1/z) and L(z) L(1/z) - 1 on the unit circle: generalised
eigenvalues, and sign changes on a grid. Each frequency is then refined by evaluating L.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.plant.lti import Lti, delay
from frictool.plant.root_search import sign_change
from frictool.typing import Vector
from frictool.verify.hinf_norm import norm

NEAR_CIRCLE = 1e-3  # distance from the unit circle within which an eigenvalue is examined
LOOKS = 1500  # points of the grid, over six decades below half the sampling frequency
NOTHING = 1e-9  # |L| below this value is treated as zero
REAL = 1e-6  # largest residual of the crossing condition, relative to |L| + 1


@dataclass(frozen=True)
class LoopMargins:
    """Margins of one loop; if the loop is unstable, `gain_up` is 1 and all others are 0.

    - gain_up: factor by which the gain may rise; inf if there is no limit
    - gain_down: factor in [0, 1) to which the gain may fall
    - phase: phase margin [rad]
    - delay: delay margin [s]
    - delay_samples: delay margin in sample periods
    - modulus: modulus margin min |1 + L|
    - crossing: highest frequency [rad/s] at which |L| = 1; NaN if |L| is never 1
    """

    gain_up: float
    gain_down: float
    phase: float
    delay: float
    delay_samples: float
    modulus: float
    crossing: float


def open_loop(controller: Lti, rates: AxisRates, lag: float, delay_samples: int) -> Lti:
    """Return the loop gain L from eta to the position with one plant.

    lag: time constant of the drive [s].
    """
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
    """Return the margins of the sampled loop with one plant.

    lag: time constant of the drive [s].
    """
    return loop_margins(open_loop(controller, rates, lag, delay_samples))


def loop_margins(loop: Lti) -> LoopMargins:
    """Return the margins of a sampled SISO loop gain `loop` with negative feedback."""
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
    """Return N = ||H_v/w||, the peak gain from the friction w in [-1, 1] to the speed.

    The unit of N is rad/s | m/s; N is inf for an unstable loop. Annex C (27) of the thesis
    concludes stability from N <= 1, because |sign(v)| <= 1. This conclusion needs
    |sign(v)| <= |v|/N, which is true only for speeds above N. N therefore shows only that friction
    cannot sustain an oscillation whose speed is always above N. Near v = 0, only a simulation can
    decide.
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
    """Return the angular frequencies [rad/s], up to pi/period, where the loop gain is real."""
    n = loop.order
    zero = np.zeros
    # state x of L(z), state p of L(1/z): z x = a x + b u,  p = z (a p + b u),  c x = c p
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
    """Return the angular frequencies [rad/s], below pi/period, where |loop gain| = 1."""
    n = loop.order
    zero = np.zeros
    a = loop.a
    b = loop.b
    c = loop.c
    d = loop.d
    # L(1/z) L(z) u = u with the state x of L(z) and the state p of L(1/z):
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
    """Return the angular frequencies in (0, pi/T) at which `function`(L) is zero.

    The zeros are searched near the eigenvalues of the pencil z e - m on the unit circle, and at
    sign changes of the function on a grid.
    """
    period = loop.period
    last = np.pi * (1.0 - 1e-9)
    values = scipy.linalg.eigvals(m, e)
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
        root = sign_change(at, float(looked[k]), float(looked[k + 1]))
        if abs(at(root)) < REAL * (
            1.0 + abs(loop.response(root / period)[0, 0, 0])
        ):  # excludes a pole, where the sign jumps
            roots.append(root)
    return np.array(sorted(roots)) / period


def sensitivity(loop: Lti) -> Lti:
    """Return the sensitivity 1/(1 + L) of the loop gain L = `loop`."""
    inverse = 1.0 / (1.0 + loop.d[0, 0])
    return Lti(
        loop.a - inverse * loop.b @ loop.c,
        inverse * loop.b,
        -inverse * loop.c,
        np.array([[inverse]]),
        loop.period,
    )
