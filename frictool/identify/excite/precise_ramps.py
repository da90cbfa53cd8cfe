"""Breakaway ramps that reach a requested precision in the shortest time.

An onset is the moment at which a ramp starts to move the axis. The estimated breakaway has two
errors. The first averages out over the onsets. The second is due to the range of the inertia in the
bench (assess/ramp_precision.py). Both errors grow with the rate of the ramps, whereas the duration
of a ramp decreases. The rate that gives the shortest test is searched on a grid.

The duration of a test counts all rows. The test contains SPARE times as many ramps as onsets, or
more for a slow axis, and each ramp rises to its top. In a real test, fewer rows are played, because
a ramp ends when the axis moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import NoSolutionError
from frictool.identify.assess.ramp_precision import ramp_precision
from frictool.identify.excite.bench_limits import BenchLimits, limits_of
from frictool.identify.excite.breakaway_ramps import (
    SEGMENTS,
    SPARE,
    breakaway_ramps,
    breakaway_range,
    effort_rate,
    ramp_duration,
    refuse_moving_load,
)
from frictool.identify.excite.excitation_sequence import ExcitationSequence, check_samples
from frictool.identify.excite.precise_strokes import QUANTILE, PreciseTest, PrecisionRequest
from frictool.typing import Vector

RATES = np.geomspace(0.02, 1.0, 35)  # relative to the rate of `excite --kind breakaway`
# least number of onsets in both directions together; `identify` needs 5, and may drop half of the
# onsets
FEWEST_ONSETS = 24


def precise_ramps(bench: Bench, request: PrecisionRequest) -> PreciseTest:
    """Design ramps that give the breakaway with a requested precision.

    Parameters
    ----------
    bench
        Bench; the test respects its limits for all values within the a-priori intervals.
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
    refuse_moving_load(bench)
    if request.duration is not None:
        check_samples(request.duration, bench.sample_period_s)
    design = _RampDesign(bench, request, effort_rate(bench) * RATES)
    written: dict[tuple[int, int], ExcitationSequence] = {}
    # for each rate, duration of the written test relative to the duration of SPARE ramps per onset;
    # above 1 if a slow axis needs more ramps, inf if the rate is impossible
    excess = np.ones(RATES.size)
    refusal = None
    while True:
        try:
            plan = design.best(excess)
        except NoSolutionError as error:
            raise refusal or error from None
        if plan[:2] in written:
            break
        if request.duration is None and plan.duration > request.longest:
            load = "lower load.most, " * (limits_of(bench).load > 0.0)
            raise NoSolutionError(
                f"time: breakaway={100 * request.wanted['breakaway']:.3g}% needs ramps of "
                f"{plan.duration:.3g} s; allowed: at most {request.longest:.4g} s; raise "
                f"--longest, {load}use a finer encoder, or narrow mechanics.inertia"
            )
        try:
            sequence = design.sequence(plan)
        except NoSolutionError as error:
            refusal = refusal or error
            excess[plan.number] = math.inf
            continue
        written[plan[:2]] = sequence
        excess[plan.number] = max(1.0, sequence.duration / plan.duration * excess[plan.number])
    sequence = written[plan[:2]]
    bound = QUANTILE * plan.deviation
    promised = request.factor("breakaway") * bound
    sequence.figures.update(promised_breakaway=promised, onsets=float(plan.onsets))
    return PreciseTest(sequence, {"breakaway": promised}, {"breakaway": bound})


class RampPlan(NamedTuple):
    """Rate and number of the ramps of a test.

    - number: index of the ramps' rate in the grid of rates
    - onsets: number of onsets in both directions together
    - duration: duration of the test, s
    - deviation: standard deviation of the mean breakaway, N m | N
    """

    number: int
    onsets: int
    duration: float
    deviation: float


@dataclass(frozen=True)
class _RampDesign:
    """Requested precision, and rates (n,) [N m/s | N/s] among which the best rate is searched."""

    bench: Bench
    request: PrecisionRequest
    rates: Vector

    def best(self, excess: Vector) -> RampPlan:
        """Return the shortest plan, or the most precise plan of the requested duration.

        excess: duration of the test divided by the total duration of its ramps, for each rate,
        (n,); inf for an impossible rate. A test has SPARE times as many ramps as onsets. Raises
        NoSolutionError if no rate is possible.
        """
        request = self.request
        half = request.wanted["breakaway"] * breakaway_range(self.bench)[1]
        limit = half / (QUANTILE * request.factor("breakaway"))
        each = SPARE * excess * ramp_duration(self.bench, self.rates)
        plans = []
        for index, (rate, lasting) in enumerate(zip(self.rates.tolist(), each, strict=True)):
            if math.isinf(lasting):
                continue
            if request.duration is None:
                common = self._deviation(rate, math.inf)
                onsets = _onsets(self._deviation(rate, 1.0), common, limit)
            else:
                onsets = 2.0 * math.floor(0.5 * request.duration / lasting)
            if FEWEST_ONSETS <= onsets < math.inf:
                deviation = self._deviation(rate, onsets)
                plans.append(RampPlan(index, int(onsets), float(onsets * lasting), deviation))
        if not plans:
            raise NoSolutionError(
                f"time: {FEWEST_ONSETS} ramps need {FEWEST_ONSETS * each.min():.3g} s; allowed: at "
                f"most {request.duration:.4g} s; raise --duration"
                if request.duration is not None
                else "resolution: the range of mechanics.inertia makes the onsets too uncertain at "
                "any ramp rate; identify the inertia first, or use a finer encoder"
            )
        shortest = request.duration is None
        return min(plans, key=lambda plan: plan.duration if shortest else plan.deviation)

    def sequence(self, plan: RampPlan) -> ExcitationSequence:
        """Return the sequence of a plan; raise NoSolutionError if the sequence exceeds a limit."""
        rounds = max(1, math.ceil(plan.onsets / (2 * SEGMENTS)))
        segments = math.ceil(plan.onsets / (2 * rounds))
        return breakaway_ramps(
            self.bench,
            _middle_part(limits_of(self.bench), segments),
            None,
            float(self.rates[plan.number]) / self.bench.actuator.constant.value,
            rounds,
            False,
            segments,
        )

    def _deviation(self, rate: float, onsets: float) -> float:
        known = self.bench.mechanics.inertia
        inertia = (known.interval[0], known.value, known.interval[1])
        step = self.bench.encoder.resolution
        return ramp_precision(rate, step, self.bench.sample_period_s, inertia, onsets).deviation


def _onsets(single: float, common: float, limit: float) -> float:
    """Return the smallest even number of onsets with a breakaway error of at most `limit`, or inf.

    `single` is the standard deviation of the breakaway from one onset. `common` is the part of
    `single` that does not average out over the onsets. Both have the unit of `limit`.
    """
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
