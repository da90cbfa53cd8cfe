"""Published values of the eight loops of table 5.1, and the same values of a simulation."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from frictool.typing import Vector
from studies.table_5_1.reference_loops import LIMITER, PERIOD, SMOOTH, cascade_step, pid_step

ZONE, TOLERANCE = 0.05, 0.02
FIGURES = ("overshoot_percent", "response_95_s", "static_error_m", "amplitude_m", "period_s")


class Loop(NamedTuple):
    """Loop with its published values, in the order of FIGURES.

    "inf": the loop never settles. "nan": there is no limit cycle.
    """

    step: Callable[[float], Vector]
    printed: tuple[str, str, str, str, str]


def _rests(overshoot: str, response: str, error: str) -> tuple[str, str, str, str, str]:
    return overshoot, response, error, "0", "nan"


LOOPS = {
    "pid": Loop(pid_step, ("46.5", "inf", "0.085", "0.084", "35.9")),
    "pid_limiter": Loop(lambda s: pid_step(s, limiter=LIMITER), _rests("0", "2.99", "0.0198")),
    "pi_p": Loop(cascade_step, ("27.5", "1.38", "0.003", "0.0031", "4.18")),
    "pi_root": Loop(
        lambda s: cascade_step(s, root_gain=math.sqrt(2.0)), _rests("0", "1.22", "0.003")
    ),
    "smooth_limiter": Loop(lambda s: pid_step(s, SMOOTH, LIMITER), _rests("0", "3.85", "0.020")),
    "smooth_limiter_virtual": Loop(
        lambda s: pid_step(s, SMOOTH, LIMITER, virtual=1.0), _rests("0", "2.54", "0.020")
    ),
    "smooth_root": Loop(
        lambda s: cascade_step(s, SMOOTH, math.sqrt(0.2)), _rests("0", "3.47", "0.000")
    ),
    "smooth_root_virtual": Loop(
        lambda s: cascade_step(s, SMOOTH, math.sqrt(2.2)), _rests("2.3", "1.13", "0.015")
    ),
}


def figures(positions: Vector) -> dict[str, float]:
    """Return FIGURES of a hold (n,) [m] after a step of 1 m.

    Response: time from which |e| stays within 5 % of the step; infinite if |e| exceeds it in the
    second half of the hold. Static error: largest |e| of the second half. Limit cycle: half of the
    peak-to-peak value in the second half, and the mean time between upward crossings of the mean
    level.
    """
    tail = positions[positions.size // 2 :]
    outside = np.flatnonzero(np.abs(positions - 1.0) > ZONE)
    last = int(outside[-1])
    low, high = float(np.min(tail)), float(np.max(tail))
    above = tail > 0.5 * (low + high)
    upward = np.flatnonzero(above[1:] & ~above[:-1])
    return {
        "overshoot_percent": 100.0 * max(0.0, float(np.max(positions)) - 1.0),
        "response_95_s": PERIOD * (last + 1) if last < positions.size // 2 else math.inf,
        "static_error_m": max(abs(low - 1.0), abs(high - 1.0)),
        "amplitude_m": 0.5 * (high - low),
        "period_s": PERIOD * float(np.mean(np.diff(upward))) if upward.size > 1 else math.nan,
    }


def deviation(found: float, printed: str) -> float:
    """Return the deviation relative to the printed value.

    The deviation is 0 if both values are infinite, NaN or 0, and infinite if only one of them is.
    """
    known = float(printed)
    if found == known or (math.isnan(found) and math.isnan(known)):
        return 0.0
    difference = found - known
    return difference / known if known != 0.0 and math.isfinite(difference) else math.inf


def is_printed_so(found: float, printed: str) -> bool:
    """Return True if the value, rounded to the printed decimals, equals the printed value."""
    decimals = len(printed.partition(".")[2])
    return (
        math.isfinite(found)
        and math.isfinite(float(printed))
        and "." in printed
        and f"{found:.{decimals}f}" == printed
    )


def missed(found: dict[str, float], printed: tuple[str, ...]) -> list[str]:
    """Return the names of the values that differ from the printed ones by more than 2 %.

    A value that rounds to the printed value does not differ; "0.003" is exact to 17 % only.
    """
    named = zip(FIGURES, printed, strict=True)
    return [
        name
        for name, known in named
        if abs(deviation(found[name], known)) > TOLERANCE and not is_printed_so(found[name], known)
    ]
