"""Clock offset between two instruments, from a quantity that both have recorded.

    y(u) = a + b x(u - tau) + e

x and y are the two records of the quantity. The clock of y, with the times u, leads the clock of x
by tau. a and b are the offset and the gain between the two sensors, and e is the residual. tau
minimises the sum of squares of e, with |tau| <= most.

Both signals are first smoothed in the same way. Without this smoothing, the estimate of tau would
be biased, because linear interpolation reduces the noise of x between the samples.

The variance of tau is computed from the slope s = b x', without the part that a and b can
compensate. Because e is not white, the variance also contains the autocovariance of s e, up to the
first lag k at which it is negative:

    var tau = sum_k sum_i (s e)_i (s e)_{i+k} / (sum_i s_i^2)^2
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from frictool.typing import Vector

FEWEST = 50  # least number of samples of y for which x is known at all allowed offsets
MOST = 20_000  # maximum number of samples; every n-th sample of a longer record is used
SMOOTHED = 2.0  # standard deviation of the smoothing, in samples of the slower signal
LEAST_EXPLAINED = 0.5  # least explained share of the variance of y
AS_GOOD = 1.5  # an offset fits equally well up to this multiple of the least sum of squares
NORMAL_95 = 1.96  # standard deviations of a 95 % interval


class ClockOffset(NamedTuple):
    """Estimated offset between two clocks, from a quantity that both instruments recorded.

    value: time in s by which the second clock leads the first.
    low, high: bounds in s of the 95 % confidence interval of `value`.
    explained: fraction of the second signal's variance that the shifted first signal explains, at
        most 1.
    """

    value: float
    low: float
    high: float
    explained: float


def clock_offset(t: Vector, x: Vector, u: Vector, y: Vector, most: float) -> ClockOffset:
    """Return the time by which the clock of y leads the clock of x, with its confidence interval.

    t, x: times (n,) in s of the first clock, and values (n,) of the quantity.
    u, y: times (m,) in s of the second clock, and values (m,) of the quantity.
    most: largest absolute offset in s.

    Raises ValueError if the signals do not determine the offset.
    """
    within = np.flatnonzero((u - most >= t[0]) & (u + most <= t[-1]))
    if within.size < FEWEST:
        raise ValueError(
            f"at offsets up to {most:g} s, only {within.size} samples overlap; at least {FEWEST} "
            "are needed"
        )
    within = within[:: -(-within.size // MOST)]
    steps = float(np.median(np.diff(t))), float(np.median(np.diff(u)))
    step = min(steps)
    width = SMOOTHED * max(steps)
    x, y = (
        scipy.ndimage.gaussian_filter1d(x, width / steps[0]),
        scipy.ndimage.gaussian_filter1d(y, width / steps[1]),
    )
    u = u[within]
    y = y[within] - y[within].mean()
    lags = np.linspace(-most, most, 2 * max(2, int(np.ceil(most / step))) + 1)

    def left(tau: float) -> float:
        return float(np.sum(_fit(t, x, u, y, tau)[1] ** 2))

    misfit = np.array([left(tau) for tau in lags])
    best = int(np.argmin(misfit))
    if best in (0, lags.size - 1):
        raise ValueError(
            f"the best offset, {lags[best]:.6g} s, is at the end of the allowed range; raise "
            "clock_estimate.most"
        )
    tau = float(
        scipy.optimize.minimize_scalar(
            left,
            bounds=(lags[best - 1], lags[best + 1]),
            method="bounded",
            options={"xatol": 1e-6 * step},
        ).x
    )
    explained = 1.0 - left(tau) / max(float(np.sum(y**2)), np.finfo(float).tiny)
    if explained < LEAST_EXPLAINED:
        raise ValueError(
            f"even at the best offset, {tau:.6g} s, the signals share only "
            f"{max(explained, 0.0):.0%} of their variance; name two channels of one quantity"
        )
    half = NORMAL_95 * _deviation(t, x, u, y, tau, width)
    _refuse_others(lags, misfit, best, max(half, 2.0 * step))
    if half > most / 2.0:
        raise ValueError(
            f"the offset of {tau:.6g} s is uncertain by {half:.2g} s; "
            f"allowed: at most {most / 2.0:g} s"
        )
    return ClockOffset(tau, tau - half, tau + half, explained)


def _fit(t: Vector, x: Vector, u: Vector, y: Vector, tau: float) -> tuple[float, Vector]:
    shifted = np.interp(u - tau, t, x)
    shifted -= shifted.mean()
    power = float(shifted @ shifted)
    gain = float(shifted @ y) / power if power > 0.0 else 0.0
    return gain, y - gain * shifted


def _deviation(t: Vector, x: Vector, u: Vector, y: Vector, tau: float, width: float) -> float:
    gain, error = _fit(t, x, u, y, tau)
    slope = (
        gain * (np.interp(u - tau + width, t, x) - np.interp(u - tau - width, t, x)) / (2.0 * width)
    )
    regressors = np.column_stack([np.ones(u.size), np.interp(u - tau, t, x)])
    slope -= regressors @ np.linalg.lstsq(regressors, slope, rcond=None)[0]
    score = slope * error
    total = covariance = float(score @ score)
    for lag in range(1, u.size // 4):
        covariance = float(score[lag:] @ score[:-lag])
        if covariance < 0.0:
            break
        total += 2.0 * covariance
    return float(np.sqrt(total)) / float(slope @ slope)


def _refuse_others(lags: Vector, misfit: Vector, best: int, near: float) -> None:
    """Raise ValueError if the best lag is not unique, for example in periodic motion."""
    inner = misfit[1:-1]
    minima = 1 + np.flatnonzero((inner <= misfit[:-2]) & (inner <= misfit[2:]))
    others = [
        at
        for at in minima
        if abs(lags[at] - lags[best]) > near and misfit[at] < AS_GOOD * misfit[best]
    ]
    if others:
        both = f"{lags[best]:.6g} s and {lags[others[0]]:.6g} s"
        raise ValueError(
            f"offsets of {both} fit equally well; lower clock_estimate.most below half a period of "
            "the motion"
        )
