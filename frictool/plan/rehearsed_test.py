"""Design of tests that reach a requested precision in rehearsals.

The result is the shortest test that reaches the precision, or the most precise test of a given
duration. A rehearsal simulates a test and its identification (rehearsal.py). `precise_strokes` and
`precise_ramps` design a test from the Cramér-Rao bound. `identify` reports wider intervals than
this bound; for each parameter, rehearsals measure the ratio of the reported interval to the bound.
With the measured ratios, the design is repeated until the upper bound of every half width is at
most the requested half width.

A test is a mix of different strokes. An effect such as a delay widens the interval of a parameter
if the mix does not separate the effect from the parameter; repeating the strokes does not help. The
first mix that is tried is therefore robust: it separates a delay and a spring from the parameters,
and no parameter is much less precise than the others. If longer tests are not more precise, or gain
too little on the same simulated axes, the mix with the smallest Cramér-Rao bound is tried. If no
mix reaches the precision within the duration of
the default kind of test (`sines`), the default kind is rehearsed. If that test misses the
precision, too, longer mixes are designed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import limits_of
from frictool.identify.excite.breakaway_ramps import breakaway_range
from frictool.identify.excite.cramer_rao import SLIDING, cramer_rao
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.excite.precise_ramps import precise_ramps
from frictool.identify.excite.precise_strokes import (
    QUANTILE,
    PreciseTest,
    PrecisionRequest,
    bench_value,
    precise_strokes,
)
from frictool.identify.excite.precision_remedies import remedies
from frictool.identify.excite.sines import plan
from frictool.identify.excite.stroke_candidates import worst_axis, worst_sensing
from frictool.plan.contained_motion import ContainedDesign
from frictool.plan.rehearsal import NONE_BEFORE, HalfWidthSample, rehearse

ROUNDS = 6  # largest number of designs of a test
LARGEST_STEP = 2.0  # largest factor on the assumed half widths from one round to the next
# factor on the ratio of the reached to the requested half width, so that the rounds end
RESERVE = 1.05
LONGER = 2.0  # least duration of a test, relative to a test that missed the precision
CONFIRMATIONS = 2  # number of repetitions of the rehearsals, each with other axes
STALLS = 2  # number of tests that are longer, but not more precise, after which a mix is given up
# two tests are compared if the second is LENGTHENED times longer, and if they have COMMON simulated
# axes (one axis suffices for tests longer than the default kind, which have many strokes); a mix is
# given up if the longest allowed test would still exceed the requested half width by the factor
# HOPELESS
LENGTHENED, COMMON, HOPELESS = 1.5, 3, 1.25
NOTICEABLE = 0.9  # least ratio of two durations that are treated as equal
SHORTER = 0.7  # ratio of reached to requested half width below which a shorter test is tried
DEFAULT_KIND = "sines"  # kind of test in `excite` with which the designed tests are compared
Design = Callable[[Bench, PrecisionRequest], PreciseTest]
Progress = Callable[[str], None]


@dataclass(frozen=True)
class DesignRounds:
    """Result of the repeated design of a test; a round is one design with its rehearsals.

    - test: shortest test whose rehearsals reach the precision; None if no test does
    - attempt: request of the last round
    - refusal: reason why no test reaches the precision
    - ratio: ratio of reached to requested half width in the test that `refusal` describes
    """

    test: PreciseTest | None
    attempt: PrecisionRequest
    refusal: str = ""
    ratio: float = math.inf


@dataclass(frozen=True)
class MissedRound:
    """Test that missed the precision: duration [s], and half widths of its rehearsals."""

    duration: float
    sample: Mapping[str, HalfWidthSample]

    def extrapolated(self, earlier: MissedRound, name: str, longest: float, usual: float) -> float:
        """Return (half width of the longest allowed test) / (half width of this test).

        The squared half width is extrapolated as a + b/duration, from the median gain of the axes
        that both rounds simulated. The result is 0, a lower bound, if this test is not LENGTHENED
        times longer than the `earlier` one, if an axis was not identified, or if there are too few
        such axes: fewer than COMMON, or none if the `earlier` test is longer than `usual`.
        """
        if self.sample[name].refusals:
            return 0.0
        before, after = earlier.sample[name].widths, self.sample[name].widths
        common = min(len(before), len(after))
        fewest = 1 if earlier.duration >= usual else COMMON
        if common < fewest or self.duration < LENGTHENED * earlier.duration:
            return 0.0
        gain = float(np.median(np.log(before[:common]) - np.log(after[:common])))
        known = 1.0 / earlier.duration - 1.0 / self.duration
        further = 1.0 / self.duration - 1.0 / longest
        return math.sqrt(max(1.0 - max(math.expm1(2.0 * gain), 0.0) * further / known, 0.0))


def rehearsed_strokes(
    bench: Bench, request: PrecisionRequest, progress: Progress = lambda step: None
) -> PreciseTest:
    """Return a test of strokes that reaches the requested precision in simulations.

    Parameters
    ----------
    bench
        Bench. The test respects its limits for all parameter values within the a-priori
        intervals. For all these values, the axis also stays within the travel when the default
        position loop makes it follow the test.
    request
        Requested precision of inertia, viscous and Coulomb friction; other parameters are ignored.
    progress
        Function that is called with a label before each round of rehearsals.

    Returns
    -------
    PreciseTest
        Reference of the position loop, and the half width to expect for each parameter. If
        `request.duration` is set, a half width may be larger than requested, and a parameter that
        was not identified in a simulation has no half width. If the default kind of test reaches
        the precision, the test is not longer than the default kind.

    Raises
    ------
    NoSolutionError
        If no test within the limits reaches the precision. The message names the limit.
    """
    wanted = {name: part * bench_value(bench, name) for name, part in request.only(SLIDING).items()}
    trials = RehearsedTests(bench, request, wanted, progress)
    contained = ContainedDesign.of(bench)

    def strokes(_: Bench, attempt: PrecisionRequest) -> PreciseTest:
        return contained.test(lambda usable: precise_strokes(usable, attempt))

    if request.duration is not None:
        return trials.promised(strokes(bench, request))
    default = ContainedDesign.of(bench).test(lambda usable: default_test(usable, request))
    usual = default.sequence.duration
    trials = replace(trials, usual=usual)
    possible = all(default.bounds[name] <= half for name, half in wanted.items())
    attempts = [replace(request, robust=robust) for robust in (True, False)]
    for longest in dict.fromkeys((min(usual, request.longest), request.longest)):
        found: list[PreciseTest] = []
        missed: list[DesignRounds] = []
        for number, attempt in enumerate(attempts):
            if not found:
                rounds = trials.rounds(strokes, replace(attempt, longest=longest))
                attempts[number] = rounds.attempt
                missed.append(rounds)
                found += [rounds.test] if rounds.test is not None else []
        shorter = any(one.sequence.duration <= usual for one in found)
        if longest == usual and possible and not shorter:
            reached, _ = trials.rehearsed(default, "the default kind", screened=False)
            if trials.ratio(reached) <= 1.0:
                return _promising(default, reached)
        if found:
            return found[0]
    raise NoSolutionError(min(reversed(missed), key=lambda one: one.ratio).refusal)


def rehearsed_ramps(
    bench: Bench, request: PrecisionRequest, progress: Progress = lambda step: None
) -> PreciseTest:
    """Return ramps whose rehearsals reach the requested precision of the breakaway.

    The test is a command of the drive. `rehearsed_strokes` explains parameters, result and errors.
    """
    wanted = {"breakaway": request.wanted["breakaway"] * breakaway_range(bench)[1]}
    trials = RehearsedTests(bench, request, wanted, progress)
    if request.duration is not None:
        return trials.promised(precise_ramps(bench, request))
    rounds = trials.rounds(precise_ramps, request)
    if rounds.test is None:
        raise NoSolutionError(rounds.refusal)
    return rounds.test


def default_test(bench: Bench, request: PrecisionRequest) -> PreciseTest:
    """Return the default kind of test (`sines`) with Cramér-Rao bounds; half widths are empty.

    Raises NoSolutionError if the test exceeds a limit of the bench.
    """
    sequence = excite(DEFAULT_KIND, bench, ExcitationSettings(seed=request.seed))
    least = cramer_rao(
        plan(limits_of(bench)), worst_axis(bench), worst_sensing(bench, request.noise)
    )
    bounds = {name: QUANTILE * float(least[SLIDING.index(name)]) for name in request.only(SLIDING)}
    return PreciseTest(sequence, {}, bounds)


def rehearsed_default(
    bench: Bench, request: PrecisionRequest, progress: Progress = lambda step: None
) -> PreciseTest:
    """Return the default kind of test (`sines`) with the half widths that its rehearsals reach.

    The requested precisions are ignored. Arguments, errors and the meaning of the half widths are
    those of `rehearsed_strokes` with a requested duration.
    """
    default = default_test(bench, request)
    wanted = {name: bench_value(bench, name) for name in request.only(SLIDING)}
    free = replace(request, duration=default.sequence.duration)
    return RehearsedTests(bench, free, wanted, progress).promised(default)


@dataclass(frozen=True)
class RehearsedTests:
    """Rehearsals of the tests of one bench.

    - request: requested precision
    - wanted: requested half width of each parameter in SI units
    - progress: function that is called with a label before each round of rehearsals
    - usual: duration of the default kind of test, s; inf if it is unknown
    """

    bench: Bench
    request: PrecisionRequest
    wanted: Mapping[str, float]
    progress: Progress
    usual: float = math.inf

    def rounds(self, design: Design, attempt: PrecisionRequest) -> DesignRounds:
        """Try at most ROUNDS tests; return the shortest test whose rehearsals reach the precision.

        `attempt` is the request of the first round. If a test misses the precision, the next test
        is longer, else shorter. The rounds end after STALLS longer tests that are not more precise,
        or if the longest allowed test would not be precise enough (`MissedRound.extrapolated`). The
        refusal describes the most precise test.
        """
        last: PreciseTest | None = None
        kept: PreciseTest | None = None
        missed: MissedRound | None = None
        nearest: tuple[PreciseTest, Mapping[str, HalfWidthSample]] | None = None
        refusal = ""
        least = math.inf
        stalled = 0
        for number in range(1, ROUNDS + 1):
            try:
                test = _next_test(design, self.bench, attempt, last, shorter=kept is not None)
            except NoSolutionError as error:
                refusal = str(error)
                break
            if kept is not None and test.sequence.duration >= kept.sequence.duration:
                break  # no shorter test is possible
            reached, sample = self.rehearsed(test, f"round {number}")
            ratio = self.ratio(reached)
            if ratio <= 1.0:
                kept = _promising(test, reached)
                if ratio >= SHORTER or nearest is not None:
                    break
                factors = {name: attempt.factor(name) * RESERVE * ratio for name in self.wanted}
            else:
                if kept is not None:
                    break
                stalled = stalled + 1 if ratio >= least else 0
                this = MissedRound(test.sequence.duration, sample)
                hopeless = missed is not None and self._gains_too_little(
                    missed, this, reached, attempt.longest
                )
                missed = this
                if ratio < least or nearest is None:
                    nearest = test, sample
                least = min(ratio, least)
                if (
                    hopeless
                    or stalled == STALLS
                    or test.sequence.duration >= NOTICEABLE * attempt.longest
                ):
                    break
                # a bound of few half widths that all keep the limit says little about the next step
                spread = all(reached[k] <= self.wanted[k] or sample[k].exceeded for k in reached)
                largest = math.sqrt(LONGER) if spread else LARGEST_STEP
                factors = {
                    name: attempt.factor(name)
                    * min(max(RESERVE * (ratio if attempt.robust else one), 1.0), largest)
                    for name, half in self.wanted.items()
                    for one in [reached[name] / half]
                }
            last = test
            attempt = replace(attempt, factors=factors)
        if kept is None and nearest is not None:
            # the last attempt has the measured ratios, on which the remedies depend
            refusal = _shortfall(self.bench, attempt, *nearest, self.wanted)
        return DesignRounds(kept, attempt, refusal, least)

    def _gains_too_little(
        self, earlier: MissedRound, this: MissedRound, reached: Mapping[str, float], longest: float
    ) -> bool:
        return any(
            this.extrapolated(earlier, name, longest, self.usual) * reached[name] / half > HOPELESS
            for name, half in self.wanted.items()
        )

    def rehearsed(
        self, test: PreciseTest, label: str, screened: bool = True
    ) -> tuple[dict[str, float], dict[str, HalfWidthSample]]:
        """Return the upper bound of each half width, and the half widths of all rehearsals.

        The rehearsals are repeated with other axes. If `screened` is True, they are repeated only
        if the first rehearsals suggest that the test reaches the precision.
        """
        self.progress(f"simulating a test of {test.sequence.duration:.3g} s ({label})")
        free = self.request.duration is not None
        limits = {name: math.inf if free else half for name, half in self.wanted.items()}
        first, *others = range(self.request.seed, self.request.seed + 1 + CONFIRMATIONS)
        if not screened:
            sample = self._sample(test, limits, (first, *others))
        else:
            sample = self._sample(test, limits, (first,))
            if all(one.likely <= limits[name] for name, one in sample.items()):
                # the choice of the test depends on this sample and biases it; other axes are drawn
                sample = self._sample(test, limits, others, sample)
        return {name: one.upper for name, one in sample.items()}, sample

    def promised(self, test: PreciseTest) -> PreciseTest:
        """Return the test with upper bounds from rehearsals as its half widths."""
        return _promising(test, self.rehearsed(test, "round 1")[0])

    def ratio(self, reached: Mapping[str, float]) -> float:
        """Return the largest ratio of a reached half width to the requested half width."""
        return max(reached[name] / half for name, half in self.wanted.items())

    def _sample(
        self,
        test: PreciseTest,
        limits: Mapping[str, float],
        seeds: Sequence[int],
        before: Mapping[str, HalfWidthSample] = NONE_BEFORE,
    ) -> dict[str, HalfWidthSample]:
        request = self.request
        return rehearse(
            test.sequence, self.bench, limits, request.noise, seeds, request.laws, before
        )


def _next_test(
    design: Design,
    bench: Bench,
    attempt: PrecisionRequest,
    last: PreciseTest | None,
    shorter: bool,
) -> PreciseTest:
    if last is None:
        return design(bench, attempt)
    duration = last.sequence.duration
    length = duration / LONGER if shorter else min(LONGER * duration, attempt.longest)
    try:
        test = design(bench, attempt)
    except NoSolutionError:
        return design(bench, replace(attempt, duration=length))
    low, high = (length, NOTICEABLE * duration) if shorter else (NOTICEABLE * length, math.inf)
    if low <= test.sequence.duration <= high:
        return test
    return design(bench, replace(attempt, duration=length))


def _promising(test: PreciseTest, widths: Mapping[str, float]) -> PreciseTest:
    finite = {name: one for name, one in widths.items() if math.isfinite(one)}
    figures = {
        name: one for name, one in test.sequence.figures.items() if not name.startswith("promised_")
    }
    promised = {f"promised_{name}": one for name, one in finite.items()}
    sequence = replace(test.sequence, figures=promised | figures)
    bounds = {name: one for name, one in test.bounds.items() if name in finite}
    return PreciseTest(sequence, finite, bounds)


def _shortfall(
    bench: Bench,
    request: PrecisionRequest,
    test: PreciseTest,
    sample: Mapping[str, HalfWidthSample],
    wanted: Mapping[str, float],
) -> str:
    missed = []
    for name, one in sample.items():
        if one.refusals:
            missed.append(
                f"`identify` refuses {name} in {len(one.refusals)} of "
                f"{len(one.refusals) + len(one.widths)} simulations ({one.refusals[0]})"
            )
        elif one.upper > wanted[name]:
            share = 100.0 * request.wanted[name]
            reached = share * one.upper / wanted[name]
            missed.append(f"{name} {reached:.3g} % (wanted {share:.3g} %)")
    duration = test.sequence.duration
    changes = remedies(bench, request, None) if set(sample) != {"breakaway"} else []
    return "; ".join(
        [f"a test of {duration:.3g} s fails in simulations: {', '.join(missed)}", *changes]
    )
