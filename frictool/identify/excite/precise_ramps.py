"""Breakaway ramps that reach a requested precision in the shortest time.

An onset is the moment at which a ramp starts to move the axis. The breakaway has two errors. The
first averages out over the onsets. The second is due to the range of the inertia
(assess/ramp_precision.py). Both errors grow with the rate of the ramps, whereas the duration of a
ramp decreases. The rate with the shortest test is searched on a grid.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import NoSolutionError
from frictool.identify.assess.ramp_precision import ramp_precision
from frictool.identify.excite.bench_limits import BenchLimits, limits_of
from frictool.identify.excite.breakaway_ramps import (
    SEGMENTS,
    breakaway_ramps,
    breakaway_range,
    effort_rate,
    ramp_pause,
)
from frictool.identify.excite.precise_strokes import QUANTILE, PreciseTest, PrecisionRequest

RATES = np.geomspace(0.02, 1.0, 35)  # relative to the rate of `excite --kind breakaway`
# least number of onsets in both directions together; `identify` needs 5, and may drop half
FEWEST_ONSETS = 24


def precise_ramps(bench: Bench, request: PrecisionRequest) -> PreciseTest:
    """Design ramps that give the breakaway with a requested precision.

    Parameters
    ----------
    bench
        Bench whose limits the test respects on every axis within the a-priori intervals.
    request
        Requested precision of the breakaway. If the request has a duration, the result is the most
        precise test of this duration.

    Returns
    -------
    PreciseTest
        Drive command with the rules of the ramps, and the half width to expect.

    Raises
    ------
    NoSolutionError
        If the precision needs more time than allowed, or if the ramps exceed a limit of the bench.
    """
    expected = breakaway_range(bench)[1]
    known = bench.mechanics.inertia
    inertia = (known.interval[0], known.value, known.interval[1])

    def deviation(rate: float, onsets: float) -> float:
        step = bench.encoder.resolution
        return ramp_precision(rate, step, bench.sample_period_s, inertia, onsets).deviation

    half = request.wanted["breakaway"] * expected
    factor = request.factor("breakaway")
    limit = half / (QUANTILE * factor)
    plans = []
    # of the fastest ramp, after which the axis coasts for longest
    pause = ramp_pause(bench, effort_rate(bench) / bench.actuator.constant.value)
    for rate in (effort_rate(bench) * RATES).tolist():
        lasting = expected / rate + pause
        common = deviation(rate, math.inf)
        if request.duration is None:
            onsets = _onsets(deviation(rate, 1.0), common, limit)
        else:
            onsets = 2.0 * math.floor(0.5 * request.duration / lasting)
        if FEWEST_ONSETS <= onsets < math.inf:
            plans.append((onsets * lasting, deviation(rate, onsets), rate, int(onsets)))
    if not plans:
        raise NoSolutionError(
            f"time: {FEWEST_ONSETS} ramps are not possible within the duration; raise --duration"
            if request.duration is not None
            else "resolution: the range of mechanics.inertia makes the onsets too uncertain at "
            "any ramp rate; identify the inertia first, or use a finer encoder"
        )
    shortest = min(plans, key=lambda plan: plan[0 if request.duration is None else 1])
    needed, reached, rate, onsets = shortest
    if request.duration is None and needed > request.longest:
        raise NoSolutionError(
            f"time: breakaway={100 * request.wanted['breakaway']:.3g}% needs ramps of "
            f"{needed:.3g} s; allowed: at most {request.longest:.4g} s; raise --longest, use a "
            "finer encoder, or narrow mechanics.inertia"
        )
    rounds = max(1, math.ceil(onsets / (2 * SEGMENTS)))
    segments = math.ceil(onsets / (2 * rounds))
    sequence = breakaway_ramps(
        bench,
        _middle_part(limits_of(bench), segments),
        None,
        rate / bench.actuator.constant.value,
        rounds,
        False,
        segments,
    )
    bound = QUANTILE * reached
    promised = factor * bound
    sequence.figures.update(promised_breakaway=promised, onsets=float(onsets))
    return PreciseTest(sequence, {"breakaway": promised}, {"breakaway": bound})


def _onsets(single: float, common: float, limit: float) -> float:
    """Return the least even number of onsets for a breakaway error of at most `limit`, or inf."""
    if common >= limit:
        return math.inf
    scatter = single**2 - common**2
    return max(FEWEST_ONSETS, 2.0 * math.ceil(0.5 * scatter / (limit**2 - common**2)))


def _middle_part(limits: BenchLimits, segments: int) -> BenchLimits:
    """Return limits that allow only the middle of the travel, long enough for `segments` ramps."""
    if math.isinf(limits.travel):
        return limits
    middle = 0.5 * (limits.low + limits.high)
    half = 0.5 * limits.travel * segments / SEGMENTS
    return replace(limits, low=middle - half, high=middle + half)
