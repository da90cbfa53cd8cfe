"""Design of strokes: the shortest test for a precision, or the most precise for a duration."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.errors import NoSolutionError
from frictool.identify.assess.weak_form_precision import weak_deviation
from frictool.identify.excite.bench_limits import BenchLimits, check_reference, limits_of
from frictool.identify.excite.cramer_rao import SLIDING, PlannedStroke
from frictool.identify.excite.excitation_sequence import (
    LONGEST,
    ExcitationSequence,
    check_samples,
    reference_sequence,
)
from frictool.identify.excite.half_sines import Motion, joined, reachable_speed
from frictool.identify.excite.sines import SPREAD
from frictool.identify.excite.stroke_candidates import (
    EFFECTS,
    StrokeCandidate,
    stroke_candidates,
    worst_axis,
    worst_sensing,
)
from frictool.identify.excite.stroke_design import StrokeProgram, best_within, shortest
from frictool.identify.excite.stroke_profile import unit_profile
from frictool.typing import Vector

CONFIDENCE = 0.95  # confidence of the promised intervals
QUANTILE = float(scipy.special.ndtri(0.5 + 0.5 * CONFIDENCE))
# half width by `identify`, divided by the half width of least squares over windows; this value is
# used until a simulation has determined the ratio
EXPECTED_FACTOR = 1.3
PAUSE = 0.1  # s, duration of one pause
KIND = "strokes"
# largest number of times that the variance limits are corrected by the ratio of expected deviation
# to Cramér-Rao bound
CORRECTIONS = 8
MORE = 1.02  # factor on this ratio, so that the corrections end


@dataclass(frozen=True)
class PrecisionRequest:
    """Requested precision of a test.

    - wanted: requested half width of the 95 % interval of each parameter, relative to the value in
      bench.yaml
    - duration: duration of the most precise test, s; None to design the shortest test
    - longest: longest allowed duration of the shortest test, s
    - noise: standard deviation of the noise on the measured drive, A | V; None for 0.2 % of the
      drive's limit
    - seed: seed of the random reversal positions
    - robust: True for two additional requirements: the strokes must separate the effects EFFECTS
      from inertia and friction, and no parameter may be much less precise than the others
    - factors: for each parameter, ratio of the half width that `identify` reports to the computed
      half width; EXPECTED_FACTOR for a parameter that is not a key
    - laws: friction laws of earlier logs, such as friction that varies with position, for
      simulations of the test; None if no log shows them
    """

    wanted: Mapping[str, float]
    duration: float | None = None
    longest: float = LONGEST
    noise: float | None = None
    seed: int = 0
    robust: bool = True
    factors: Mapping[str, float] = field(default_factory=dict)
    laws: Laws | None = None

    def factor(self, name: str) -> float:
        """Return the entry of a parameter in `factors`, or EXPECTED_FACTOR if there is no entry."""
        return self.factors.get(name, EXPECTED_FACTOR)

    @property
    def effects(self) -> tuple[str, ...]:
        """Return the effects that the strokes must separate from inertia and friction."""
        return EFFECTS if self.robust else ()

    @property
    def targets(self) -> dict[str, float]:
        """Return the relative half widths for which the test is designed.

        If `robust` is False, these are the requested half widths. Otherwise, the target of a
        parameter is the geometric mean of its requested half width and the smallest requested half
        width: if one parameter were much less precise, its error would disturb the others.
        """
        targets = self.only(SLIDING)
        if not self.robust or not targets:
            return targets
        highest = min(targets.values())
        return {name: math.sqrt(part * highest) for name, part in targets.items()}

    def only(self, names: tuple[str, ...]) -> dict[str, float]:
        """Return the requested precisions of the parameters `names`."""
        return {name: part for name, part in self.wanted.items() if name in names}


@dataclass(frozen=True)
class PreciseTest:
    """Test, with the precision to expect, in SI units.

    - sequence: reference or drive command of the test
    - half_widths: half width of the interval of each parameter that `identify` is expected to
      report
    - bounds: half width of each parameter at the Cramér-Rao bound
    """

    sequence: ExcitationSequence
    half_widths: dict[str, float]
    bounds: dict[str, float]


def bench_value(bench: Bench, name: str) -> float:
    """Return the value of a parameter in bench.yaml, to which relative precisions refer.

    Raises
    ------
    NoSolutionError
        If the value is 0 or absent.
    """
    known = getattr(bench.mechanics, name)
    if known is None or known.value == 0.0:
        raise NoSolutionError(
            f"{name}: a relative precision needs a value of mechanics.{name} other than 0; "
            f"found: {'none' if known is None else '0'}"
        )
    return abs(float(known.value))


def precise_strokes(bench: Bench, request: PrecisionRequest) -> PreciseTest:
    """Design a test of strokes that gives parameters with a requested precision.

    Parameters
    ----------
    bench
        Bench; the test respects its limits for all values within the a-priori intervals.
    request
        Requested precisions of inertia, viscous friction, Coulomb friction and offset; precisions
        of other parameters are ignored.

    Returns
    -------
    PreciseTest
        Reference of the position loop, and the half widths to expect. If `request.duration` is set,
        these half widths may be wider than requested.

    Raises
    ------
    NoSolutionError
        If no test within the limits reaches the precision. The message names the limit.
    """
    candidates = stroke_candidates(bench, request.noise, request.effects)
    wanted = stroke_program(bench, request, candidates)
    program = wanted
    times = np.zeros(program.duration.size)
    for _ in range(CORRECTIONS):
        before = times
        times = _repetitions(bench, request, program)
        if request.duration is not None and np.array_equal(before, times):
            break
        bound = np.sqrt(program.variances(times))
        expected = _expected_deviation(bench, request, candidates, times)
        if request.duration is None and np.all(expected**2 <= wanted.limit):
            break
        loss = np.where(np.isfinite(wanted.limit), np.maximum(expected / bound, 1.0), 1.0)
        program = replace(program, limit=wanted.limit / (MORE * loss) ** 2)
    else:
        if request.duration is None:
            raise _unreachable(bench, request, None)
    limits = limits_of(bench)
    check_samples(float(times @ program.duration), bench.sample_period_s)
    motion = stroke_motion(candidates, times, limits, bench.sample_period_s, request.seed)
    check_reference(limits, *motion)
    names = [SLIDING[row] for row in program.requested]
    least = np.sqrt(_without_effects(bench, request, program).variances(times))
    bounds = dict(zip(names, (QUANTILE * least[program.requested]).tolist(), strict=True))
    half_widths = {
        name: QUANTILE * request.factor(name) * float(expected[SLIDING.index(name)])
        for name in names
    }
    sequence = reference_sequence(KIND, bench, motion, _figures(half_widths, program, times))
    return PreciseTest(sequence, half_widths, bounds)


def _repetitions(bench: Bench, request: PrecisionRequest, program: StrokeProgram) -> Vector:
    if request.duration is None:
        times = shortest(program)
        needed = None if times is None else float(times @ program.duration)
        if times is None or needed is None or needed > request.longest:
            raise _unreachable(bench, request, needed)
        return times
    times = best_within(program, request.duration)
    if times is None:
        raise NoSolutionError(
            f"time: no test of {request.duration:.4g} s determines "
            f"{', '.join(request.only(SLIDING))}; the shortest stroke forward and back takes "
            f"{float(program.duration[:-1].min()):.3g} s; raise --duration"
        )
    return times


def _expected_deviation(
    bench: Bench, request: PrecisionRequest, candidates: list[StrokeCandidate], times: Vector
) -> Vector:
    """Return the standard deviations (p,) of a fit over smoothing windows; 0 for loads."""
    strokes = [
        replace(one.stroke, times=float(count))
        for one, count in zip(candidates, times[:-1], strict=True)
        if count
    ]
    sensing = worst_sensing(bench, request.noise)
    deviation, _ = weak_deviation(strokes, worst_axis(bench, request.effects), sensing)
    size = candidates[0].information.shape[0]
    return np.concatenate((deviation, np.zeros(max(0, size - deviation.size))))[:size]


def _without_effects(
    bench: Bench, request: PrecisionRequest, program: StrokeProgram
) -> StrokeProgram:
    size = program.limit.size - len(worst_axis(bench, request.effects).effects)
    return replace(
        program, information=program.information[:, :size, :size], limit=program.limit[:size]
    )


def stroke_program(
    bench: Bench, request: PrecisionRequest, candidates: list[StrokeCandidate]
) -> StrokeProgram:
    """Return the convex program for `candidates`, with a pause as the last candidate.

    Raises
    ------
    NoSolutionError
        If a precision is requested for a parameter of which the bench states no value.
    """
    size = candidates[0].information.shape[0]
    limit = np.full(size, math.inf)
    for name, part in request.targets.items():
        half = part * bench_value(bench, name)
        limit[SLIDING.index(name)] = (half / (QUANTILE * request.factor(name))) ** 2
    actuator = bench.actuator
    rms = actuator.rms_limit.value / actuator.limit.value if actuator.rms_limit else math.inf
    return StrokeProgram(
        np.array([*(one.information for one in candidates), np.zeros((size, size))]),
        np.array([*(one.duration for one in candidates), PAUSE]),
        np.array([*(one.mean_square for one in candidates), 0.0]),
        limit,
        rms,
    )


def stroke_motion(
    candidates: list[StrokeCandidate],
    times: Vector,
    limits: BenchLimits,
    period: float,
    seed: int,
) -> Motion:
    """Return the motion in which each of the k candidates is repeated.

    `times` (k + 1,) contains the number of repetitions of each candidate, then the number of
    pauses. The pauses are spread evenly. The ends of the strokes vary at random by up to SPREAD
    times the candidate's `reach`, so that the encoder errors differ between strokes.
    """
    draw = np.random.default_rng(seed)
    middle = 0.5 * (limits.low + limits.high) if math.isfinite(limits.travel) else 0.0
    order = sorted(
        (one for one, count in zip(candidates, times[:-1], strict=True) for _ in range(int(count))),
        key=lambda one: (-one.reach, -one.stroke.speed),
    )
    pauses = np.diff(np.floor(times[-1] * np.arange(len(order) + 1) / len(order)))

    def turn(one: StrokeCandidate, side: float) -> float:
        return middle + side * (0.5 - SPREAD * draw.uniform(0.0, 1.0)) * one.reach

    here = turn(order[0], -1.0)
    parts: list[Motion] = []
    for one, rests in zip(order, pauses, strict=True):
        for side in (1.0, -1.0):
            end = turn(one, side)
            fastest = reachable_speed(limits, abs(end - here))
            # a stroke from a longer reach to a shorter one has the largest possible speed
            planned = abs(end - here) <= one.reach
            speed = min(one.stroke.speed, fastest) if planned else fastest
            parts.append(_part(here, end, speed, period))
            here = end
        if rests:
            still = np.zeros(round(rests * PAUSE / period))
            parts.append((still + here, still, still))
    return joined(parts, here)


def _part(start: float, end: float, speed: float, period: float) -> Motion:
    stroke = PlannedStroke(speed, abs(end - start))
    samples = max(2, math.ceil(stroke.duration / period))
    duration = samples * period
    advance, velocity, acceleration = unit_profile(np.arange(samples) / samples)
    distance = end - start
    return (
        start + distance * advance,
        distance / duration * velocity,
        distance / duration**2 * acceleration,
    )


def _figures(
    half_widths: Mapping[str, float], program: StrokeProgram, times: Vector
) -> dict[str, float]:
    square = float((times * program.duration) @ program.mean_square)
    return {
        **{f"promised_{name}": half for name, half in half_widths.items()},
        "strokes": 2.0 * float(times[:-1].sum()),
        "kinds_of_strokes": float(np.count_nonzero(times[:-1])),
        "largest_drive_rms_share": math.sqrt(square / float(times @ program.duration)),
    }


def _unreachable(bench: Bench, request: PrecisionRequest, needed: float | None) -> NoSolutionError:
    from frictool.identify.excite.precision_remedies import remedies

    wanted = ", ".join(f"{name}={100 * one:.3g}%" for name, one in request.only(SLIDING).items())
    limit = (
        f"time: {wanted} needs a test of {needed:.3g} s; allowed: at most {request.longest:.4g} s"
        if needed is not None
        else "travel: even strokes over the whole travel do not separate "
        f"{', '.join(request.only(SLIDING))}"
    )
    return NoSolutionError("; ".join([limit, *remedies(bench, request, needed)]))
