"""Design of tests that reach a requested precision in rehearsals.

The result is the shortest test with the precision, or the most precise test of a given duration.
`precise_strokes` and `precise_ramps` design a test from the Cramér-Rao bound. `identify` reports
wider intervals than this bound; rehearsals of the test measure the ratio of the two for each
parameter. The design is repeated with the measured ratios until the upper bound of every half width
is within the request.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from frictool.documents.bench import Bench
from frictool.errors import NoSolutionError
from frictool.identify.excite.breakaway_ramps import breakaway_range
from frictool.identify.excite.precise_ramps import precise_ramps
from frictool.identify.excite.precise_strokes import (
    PreciseTest,
    PrecisionRequest,
    bench_value,
    precise_strokes,
)
from frictool.identify.excite.precision_remedies import remedies
from frictool.plan.rehearsal import HalfWidthSample, rehearse

ROUNDS = 6  # designs of a test
# largest increase of a factor in one round, and the increase after a refusal
LARGEST_STEP = 2.0
RESERVE = 1.05  # factor on a measured width, so that the rounds end
SHORTER = 0.7  # half width relative to the request, below which the next round asks for less
Design = Callable[[Bench, PrecisionRequest], PreciseTest]
Progress = Callable[[str], None]


def rehearsed_strokes(
    bench: Bench, request: PrecisionRequest, progress: Progress = lambda step: None
) -> PreciseTest:
    """Return a test of strokes whose rehearsals reach the requested precision.

    Parameters
    ----------
    bench
        Bench whose limits the test respects on every axis within the a-priori intervals.
    request
        Requested precision of each sliding parameter; other parameters are ignored.
    progress
        Function that is called with a label before each round of rehearsals.

    Returns
    -------
    PreciseTest
        Reference of the position loop, and the half width to expect for each parameter. If
        `request.duration` is set, a half width may be larger than requested, and a parameter that a
        rehearsal did not identify has no half width.

    Raises
    ------
    NoSolutionError
        If no test within the limits reaches the precision. The message names the limit.
    """
    return _rehearsed(precise_strokes, bench, request, bench_value, progress)


def rehearsed_ramps(
    bench: Bench, request: PrecisionRequest, progress: Progress = lambda step: None
) -> PreciseTest:
    """Return ramps whose rehearsals reach the requested precision of the breakaway.

    `rehearsed_strokes` explains parameters, result and errors; the sequence is a command of the
    drive.
    """
    expected = breakaway_range(bench)[1]
    return _rehearsed(precise_ramps, bench, request, lambda *_: expected, progress)


def _rehearsed(
    design: Design,
    bench: Bench,
    request: PrecisionRequest,
    value_of: Callable[[Bench, str], float],
    progress: Progress,
) -> PreciseTest:
    """Return the shortest of at most ROUNDS tests whose rehearsals reach the precision."""
    kept: PreciseTest | None = None
    attempt = request
    for number in range(1, ROUNDS + 1):
        try:
            test = design(bench, attempt)
        except NoSolutionError:
            if kept is None:
                raise
            break
        progress(f"rehearsing a test of {test.sequence.duration:.3g} s (round {number})")
        wanted = {
            name: request.wanted[name] * value_of(bench, name)
            if request.duration is None
            else math.inf
            for name in test.half_widths
        }
        sample = rehearse(test.sequence, bench, wanted, request.noise, request.seed)
        if request.duration is not None or _largest(sample, wanted) <= 1.0:
            # this sample selected the test, which biases it; further axes are drawn
            again = rehearse(test.sequence, bench, wanted, request.noise, request.seed + 1)
            sample = {name: one.joined(again[name]) for name, one in sample.items()}
        reached = {name: one.upper for name, one in sample.items()}
        if request.duration is not None:
            return _promising(test, reached)
        ratio = {name: reached[name] / wanted[name] for name in wanted}
        if max(ratio.values()) <= 1.0:
            if kept is None or test.sequence.duration < kept.sequence.duration:
                kept = _promising(test, reached)
            if max(ratio.values()) >= SHORTER:
                break
        elif kept is not None:
            break
        spare = {name: wanted[name] / half for name, half in test.half_widths.items()}
        attempt = replace(attempt, factors=_corrected(attempt, ratio, spare))
    if kept is None:
        raise NoSolutionError(_shortfall(bench, attempt, test, sample, wanted))
    return kept


def _largest(sample: Mapping[str, HalfWidthSample], wanted: Mapping[str, float]) -> float:
    return max(one.upper / wanted[name] for name, one in sample.items())


def _corrected(
    attempt: PrecisionRequest, ratio: Mapping[str, float], spare: Mapping[str, float]
) -> dict[str, float]:
    """Return the expected ratio of reported to designed half width for the next round.

    - ratio: upper bound of the half width in the rehearsals, divided by the requested half width
    - spare: requested half width divided by the half width of the design, which may be smaller
    """
    return {
        name: attempt.factor(name) * spare[name] * min(RESERVE * one, LARGEST_STEP)
        for name, one in ratio.items()
    }


def _promising(test: PreciseTest, widths: Mapping[str, float]) -> PreciseTest:
    """Return the test with the finite ones of `widths` as its promised half widths."""
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
    """Return a message with the missed precisions, and the changes that would reach them."""
    missed = []
    for name, one in sample.items():
        if one.refusals:
            missed.append(
                f"`identify` refuses {name} in {len(one.refusals)} of "
                f"{len(one.refusals) + len(one.widths)} rehearsals ({one.refusals[0]})"
            )
        elif one.upper > wanted[name]:
            share = 100.0 * request.wanted[name]
            reached = share * one.upper / wanted[name]
            missed.append(f"{name} {reached:.3g} % (wanted {share:.3g} %)")
    duration = test.sequence.duration
    changes = remedies(bench, request, None) if set(sample) != {"breakaway"} else []
    return "; ".join(
        [f"rehearsals of a test of {duration:.3g} s miss: {', '.join(missed)}", *changes]
    )
