"""Resonances of a model as a filter H(s), H(0) = 1, between the drive's effort and the axis.

documents/resonances.py defines the document.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.resonances import Oscillation, Resonances
from frictool.plant.lti import Lti, gain


def resonance_filters(resonances: Resonances) -> tuple[Lti, ...]:
    """Return the filter with nominal frequencies and, if there are intervals, two more filters.

    The second filter has the low end of every frequency interval, the third the high end.
    """
    filters = [_filter(resonances, None)]
    if any(one.interval_rad_s is not None for one in (*resonances.poles, *resonances.zeros)):
        filters += [_filter(resonances, 0), _filter(resonances, 1)]
    return tuple(filters)


def _filter(resonances: Resonances, end: int | None) -> Lti:
    below = [_pair(one, end) for one in resonances.poles] + _reals(resonances.real_poles_rad_s)
    above = [_pair(one, end) for one in resonances.zeros] + _reals(resonances.real_zeros_rad_s)
    whole = gain(1.0, 0.0)
    for denominator in below:
        fitting = next(
            (k for k, numerator in enumerate(above) if len(numerator) <= len(denominator)), None
        )
        whole = _series(
            whole, _section(np.ones(1) if fitting is None else above.pop(fitting), denominator)
        )
    if above:  # a pair of zeros needs a section with a pair of poles
        raise ValueError("resonances: a pair of zeros needs a pair of poles")
    return whole


def _pair(one: Oscillation, end: int | None) -> np.ndarray:
    w = one.rad_s if end is None or one.interval_rad_s is None else one.interval_rad_s[end]
    return np.array([1.0 / w**2, 2.0 * one.damping / w, 1.0])


def _reals(frequencies: tuple[float, ...]) -> list[np.ndarray]:
    factors = [np.array([1.0 / w, 1.0]) for w in frequencies]
    return [
        np.polymul(*factors[k : k + 2]) if len(factors[k : k + 2]) == 2 else factors[k]
        for k in range(0, len(factors), 2)
    ]


def _section(numerator: np.ndarray, denominator: np.ndarray) -> Lti:
    n = len(denominator) - 1
    top = np.concatenate([np.zeros(n + 1 - len(numerator)), numerator]) / denominator[0]
    below = denominator / denominator[0]
    direct = top[0]
    rest = top[1:] - top[0] * below[1:]
    scale = abs(below[-1]) ** (1.0 / n)  # s in units of the section's frequency
    powers = scale ** np.arange(1, n + 1)
    a = np.zeros((n, n))
    a[0] = -below[1:] / powers * scale
    a[np.arange(1, n), np.arange(n - 1)] = scale
    b = np.zeros((n, 1))
    b[0, 0] = scale
    return Lti(a, b, (rest / powers)[None, :], np.array([[direct]]), 0.0)


def _series(first: Lti, second: Lti) -> Lti:
    n, m = first.order, second.order
    a = np.block([[first.a, np.zeros((n, m))], [second.b @ first.c, second.a]])
    b = np.vstack([first.b, second.b @ first.d])
    return Lti(a, b, np.hstack([second.d @ first.c, second.c]), second.d @ first.d, 0.0)
