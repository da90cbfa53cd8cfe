"""Choice of the next commissioning step from the bench, the specification and the logs so far.

    logs so far               next step
    none                      ramps: direction, encoder, breakaway; strokes if the offset of the
                              bench or logs moves the axis with the drive at 0
    ramps without breakaway   strokes, then ramps again, at most MOST_RAMPS times
    ramps                     strokes: friction and inertia, unless no strokes are safe
    strokes without result    strokes with other reversals; after MOST_STROKES logs, no test
    strokes that narrow nothing     no test; the logs show an effect that the model lacks
    ramps, or strokes         search for a controller that meets the specification
        for all plants        steps, to validate the model; commissioning is complete
        for the logs' intervals only    no test; the bench's ranges are too wide for any controller
        for exact values only           strokes again, with half of the interval widths
        for no plant          no test; no controller meets the specification

A stroke is a motion between two reversals. A ramp is a slow rise of the drive until the axis moves.
The indented rows are the results of the search: the plants for which a controller exists. In the
search, a parameter that the strokes do not determine has the range of the bench.

Each test respects the limits of the bench for all parameter values within the a-priori ranges. The
test is therefore safe before any parameter is identified. After a log, identified intervals replace
the bench's ranges in the design of the next test.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.missing_effects import refuse_sensor_lag
from frictool.documents.model import Model
from frictool.documents.name_list import listed
from frictool.documents.quantity import si_unit
from frictool.errors import EXIT_NO, EXIT_NO_SOLUTION, NoSolutionError
from frictool.identify.axis_logs import SLIDING_LOG
from frictool.identify.excite.breakaway_ramps import (
    breakaway_range,
    may_move_freely,
    never_at_rest,
)
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.excite.precise_strokes import (
    PreciseTest,
    PrecisionRequest,
)
from frictool.identify.from_logs import IdentifiedModel, identify
from frictool.identify.identification import Identification, NothingIdentified
from frictool.identify.model_document import model_of
from frictool.identify.orientation import OPPOSITE
from frictool.identify.promise_comparison import shown_effects
from frictool.logs.log import Log
from frictool.plan.contained_motion import ContainedDesign
from frictool.plan.controller_search import SearchAnswer
from frictool.plan.narrowed_model import (
    bench_for_test,
    exact_model,
    narrowed_bench,
    narrowed_model,
)
from frictool.plan.rehearsed_test import rehearsed_ramps, rehearsed_strokes
from frictool.simulate.default_servo import FEEDFORWARD, feedforward

FIRST_RAMPS = 0.1  # requested half width of the breakaway's interval, relative to the breakaway
FIRST_STROKES = 0.05  # requested half widths of friction and inertia, relative to their values
FALLBACK_DURATION = 30.0  # s, duration of the strokes if no strokes reach FIRST_STROKES
FINER = 0.5  # half width requested from a repeated test, relative to the reached one
# least half width without a useful log, relative to the half width with this log
LEAST_GAIN = math.sqrt(1.0 / FINER)
SLIDING = ("inertia", "viscous", "coulomb")
NO_RAMPS = (
    "strokes show friction, inertia and offset; ramps are impossible, because the offset in "
    "bench.yaml exceeds the breakaway and moves the axis while the drive is 0"
)
LOADED = (
    "strokes show friction, inertia and load; no ramps yet, because spring or gravity "
    "(load.terms, load.most) may exceed the breakaway, and move the axis while the drive is 0 (an "
    "arm falls)"
)
MOST_RAMPS = 2  # largest number of tests of drive ramps
MOST_STROKES = 2  # logs of motion after which no further strokes are planned, if they gave no gain


@dataclass(frozen=True)
class ReachedPrecision:
    """Identified value of a parameter and half width of its interval, in SI units."""

    parameter: str
    value: float
    half_width: float
    unit: str

    @property
    def share(self) -> float | None:
        """Return the half width divided by |value|; None if the value is 0."""
        return self.half_width / abs(self.value) if self.value else None


@dataclass(frozen=True)
class PlanStep:
    """Next step of a commissioning.

    - name: name of the step: `breakaway`, `friction and inertia`, `finer`, `validation`,
      `direction`, `unexplained`, `ranges` or `impossible`
    - why: reason for the step, as text
    - test: test to play on the bench; None if the step has no test
    - reached: precision of each identified parameter
    - model: model identified from all logs; None if no parameter is identified
    - enough: True if a controller meets the specification for every plant that the model allows;
      `why` names the position steps for which this is true
    - exit_code: exit code of `frictool plan`
    - warnings: warnings of the identification
    - doubts: parameters whose interval, according to a warning, may not contain the true value; the
      plan does not use this interval
    """

    name: str
    why: str
    test: PreciseTest | None = None
    reached: tuple[ReachedPrecision, ...] = ()
    model: Model | None = None
    enough: bool = False
    exit_code: int = 0
    warnings: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()


# searches for a controller of a model that meets the specification
Judge = Callable[[Model], SearchAnswer]


def next_step(
    bench: Bench, logs: Sequence[Log], answer_of: Judge, narrow: bool = False
) -> PlanStep:
    """Return the next step of a commissioning.

    Parameters
    ----------
    bench
        Bench with its a-priori ranges and limits.
    logs
        All logs so far, in any order.
    answer_of
        Function that searches for a controller for a model, and returns the result of the search.
    narrow
        True to design the controller for the intervals of the logs and not for the bench's ranges.
        This is permissible if the ranges describe only the uncertainty before a measurement. It is
        not permissible if they describe changes over the product's life.

    Returns
    -------
    PlanStep
        The step, with its test and the precision reached.

    Raises
    ------
    NoSolutionError
        If the bench allows no test, or if its position sensor has a lag.
    """
    refuse_sensor_lag(bench, "plan rehearses tests and designs controllers")
    if not logs:
        if may_move_freely(bench):
            return _strokes(bench, LOADED)
        impossible = never_at_rest(bench)
        return _ramps(bench) if impossible is None else _strokes(bench, NO_RAMPS)
    warnings: list[str] = []
    try:
        outcome = identify(logs, bench, tell=warnings.append)
    except NothingIdentified as error:
        step = _unidentified(bench, error)
        result = error.result
    else:
        step = _identified(bench, logs, _without_doubts(outcome), answer_of, narrow)
        result = outcome.result
    return replace(
        step, warnings=(*warnings, *result.warnings, *step.warnings), doubts=tuple(result.doubts)
    )


def _unidentified(bench: Bench, error: NothingIdentified) -> PlanStep:
    if OPPOSITE in str(error):
        return PlanStep("direction", f"{error}, or check the wiring", exit_code=EXIT_NO)
    return _strokes(bench, f"no parameter is identified yet ({error})", error.result)


def _without_doubts(outcome: IdentifiedModel) -> IdentifiedModel:
    """Return the outcome in which a parameter with a doubt has the interval of the bench."""
    if not outcome.result.doubts:
        return outcome
    result, model = outcome.result.without_doubts(), outcome.model
    settled = model_of(result, model.bench, model.provenance)
    return replace(
        outcome,
        result=result,
        model=structs.replace(
            model,
            parameters=settled.parameters,
            not_identified=settled.not_identified,
            laws=settled.laws,
        ),
    )


def _identified(
    bench: Bench, logs: Sequence[Log], outcome: IdentifiedModel, answer_of: Judge, narrow: bool
) -> PlanStep:
    """Return the next commissioning step if the logs identify at least one parameter."""
    model = outcome.model
    reached = _reached(outcome)
    known = {one.parameter for one in reached}
    # an axis with little friction may coast so far that its ramps show too few breakaways
    ramps = sum("reference" not in log.main.signals for log in logs)
    if (
        "ramp" not in outcome.result.kinds.values()
        and "breakaway" not in known
        and ramps < MOST_RAMPS
        and _rests(bench, model)
    ):
        return _ramps(bench, reached)
    untested = None
    if not known.intersection(SLIDING):
        why = f"not identified yet ({_refusals(outcome.result, SLIDING)})"
        try:
            return _strokes(bench_for_test(bench, model), why, outcome.result, reached)
        except NoSolutionError as error:
            untested = str(error)
    return _designed(bench, logs, outcome, answer_of, narrow, untested)


def _rests(bench: Bench, model: Model) -> bool:
    """Return True if no load in the logs or in the bench moves the axis at a drive of 0."""
    narrowed = narrowed_bench(bench, model)
    load = None if model.laws is None else model.laws.load
    if load is None or (load.gravity is None and load.stiffness is None):
        return never_at_rest(narrowed) is None and not may_move_freely(narrowed)
    if load.total is None:
        return False
    most = max(-load.total.least.interval[0], load.total.largest.interval[1])
    return most <= breakaway_range(narrowed)[0]


def _no_gain(bench: Bench, logs: Sequence[Log], outcome: IdentifiedModel) -> str:
    """Return why another test of strokes is useless, or "" if a log of strokes was useful.

    For each log of strokes, the identification is repeated without this log. A log is useful if,
    without it, a half width is more than LEAST_GAIN times as large, or a parameter is not
    identified. The result is also empty if there are fewer than MOST_STROKES logs of strokes.
    """
    kinds, known = outcome.result.kinds, outcome.result.identified
    strokes = [log for log in logs if kinds.get(log.source) == SLIDING_LOG]
    if len(strokes) < MOST_STROKES:
        return ""
    for left_out in strokes:
        try:
            others = identify([log for log in logs if log is not left_out], bench).result.identified
        except NothingIdentified:
            return ""
        for name in SLIDING:
            if name in known and (
                name not in others or others[name].half_width > LEAST_GAIN * known[name].half_width
            ):
                return ""
    reached = ", ".join(
        f"{one.parameter} +-{100.0 * one.share:.2g} %"
        for one in _reached(outcome)
        if one.parameter in SLIDING and one.share
    )
    return (
        f"{len(strokes)} logs of strokes are hardly more precise than {len(strokes) - 1} "
        f"({reached}), so that another test would not narrow the intervals{_causes(outcome)}"
    )


def _causes(outcome: IdentifiedModel) -> str:
    """Return a text that names the effects in the logs, and advises how to examine one of them."""
    effects = shown_effects(outcome.result)
    fit = outcome.result.fit
    settle = next((one.settle for one in fit.explanations), "") if fit is not None else ""
    return (f"; the logs show {listed(effects)}" if effects else "") + (
        f"; {settle}" if settle else ""
    )


def _refusals(result: Identification, names: Sequence[str]) -> str:
    reasons: dict[str, list[str]] = {}
    for name in names:
        reasons.setdefault(result.refused.get(name, "no log shows it"), []).append(name)
    return "; ".join(f"{', '.join(group)}: {reason}" for reason, group in reasons.items())


def _ramps(bench: Bench, reached: tuple[ReachedPrecision, ...] = ()) -> PlanStep:
    try:
        test = rehearsed_ramps(bench, PrecisionRequest({"breakaway": FIRST_RAMPS}))
    except NoSolutionError:
        sequence = excite("breakaway", bench, ExcitationSettings())
        test = PreciseTest(sequence, {}, {})
    why = (
        "slow ramps show the breakaway and the signs of drive and encoder; the drive returns to 0 "
        "as soon as the axis moves. Logs do not show an error of the drive's constant, which "
        "scales all parameters by the same factor"
    )
    return PlanStep("breakaway", why, test, reached)


def _strokes(
    bench: Bench,
    why: str,
    result: Identification | None = None,
    reached: tuple[ReachedPrecision, ...] = (),
) -> PlanStep:
    played = 0 if result is None else list(result.kinds.values()).count(SLIDING_LOG)
    if played >= MOST_STROKES:
        why = (
            f"{why}; {played} logs of motion did not change this: remove the cause and start again"
        )
        return PlanStep("unexplained", why, None, reached, exit_code=EXIT_NO)
    known = bench.mechanics
    wanted = {name: FIRST_STROKES for name in SLIDING if getattr(known, name).value > 0.0}
    longest = 2.0 * FALLBACK_DURATION
    request = PrecisionRequest(wanted, longest=longest, seed=played, laws=_over_position(result))
    try:
        test = rehearsed_strokes(bench, request)
    except NoSolutionError:
        test = rehearsed_strokes(bench, replace(request, duration=FALLBACK_DURATION))
    return PlanStep("friction and inertia", why, _compensated(test, bench), reached)


def _over_position(result: Identification | None) -> Laws | None:
    """Return the friction over position that the logs show, for simulations; None without it."""
    laws = None if result is None else result.laws
    return None if laws is None or laws.position is None else Laws(position=laws.position)


def _compensated(test: PreciseTest, bench: Bench) -> PreciseTest:
    """Add the feedforward effort for inertia and friction of `bench` to the test's columns."""
    sequence = test.sequence
    effort = feedforward(bench, sequence.as_log("test"))
    assert effort is not None
    compensated = replace(
        sequence,
        columns={**sequence.columns, FEEDFORWARD: effort},
        units={**sequence.units, FEEDFORWARD: si_unit("effort", bench.axis)},
        rule=f"{sequence.rule}, and adds the effort `{FEEDFORWARD}`",
    )
    return replace(test, sequence=compensated)


def _designed(
    bench: Bench,
    logs: Sequence[Log],
    outcome: IdentifiedModel,
    answer_of: Judge,
    narrow: bool,
    untested: str | None,
) -> PlanStep:
    """Return the next commissioning step, after a search for a controller.

    untested: reason why no test of strokes is possible, or None.
    """
    model = outcome.model
    reached = _reached(outcome)
    known = {one.parameter for one in reached}
    missing = [name for name in SLIDING if name not in known]
    unseen = f"; not identified, range of the bench: {', '.join(missing)}" if missing else ""
    left = narrowed_model(model) if narrow else model
    refusal, steps, narrower, doubt, extrapolated = answer_of(left)
    first = f", first {narrower}," if narrower else ""
    if not refusal:
        test, advice = _validation(bench_for_test(bench, model))
        on = f", with {steps}" if steps else ""
        why = f"`synth` meets this specification for every possible plant{on}; {advice}{unseen}"
        step = PlanStep("validation", why, test, reached, left, enough=not doubt)
        if extrapolated:
            step = replace(step, warnings=(extrapolated,))
        if doubt:
            step = replace(step, why=f"undecided: {doubt}; {why}", exit_code=EXIT_NO)
        return step
    if not narrow and not answer_of(narrowed_model(model)).refusal:
        why = (
            "a controller exists for the identified intervals, but not for the ranges of the "
            f"bench ({refusal}); narrow the ranges in `mechanics` of the bench{first} or "
            f"use --narrow, unless the product needs these ranges{unseen}"
        )
        return PlanStep("ranges", why, None, reached, model, exit_code=EXIT_NO)
    if answer_of(exact_model(model)).refusal:
        why = f"no controller is found even for exact parameters: {refusal}{unseen}"
        return PlanStep("impossible", why, None, reached, model, exit_code=EXIT_NO_SOLUTION)
    widest = f"; first narrow {narrower}" if narrower else ""
    wide = f"no controller for such wide intervals ({refusal}){widest}"
    useless = _no_gain(bench, logs, outcome)
    if useless:
        why = f"{wide}; {useless}{unseen}"
        return PlanStep("unexplained", why, None, reached, model, exit_code=EXIT_NO)
    # a test that fell short of FIRST_STROKES was precise enough in its simulations
    wanted = {
        one.parameter: FINER * min(one.share, FIRST_STROKES)
        for one in reached
        if one.parameter in SLIDING and one.share
    } | {name: FIRST_STROKES for name in missing if getattr(bench.mechanics, name).value > 0.0}
    try:
        if untested is not None:
            raise NoSolutionError(untested)
        finer = bench_for_test(bench, model)
        played = list(outcome.result.kinds.values()).count(SLIDING_LOG)
        request = PrecisionRequest(wanted, seed=played, laws=_over_position(outcome.result))
        test = _compensated(rehearsed_strokes(finer, request), finer)
    except NoSolutionError as error:
        why = f"{wide}; no test narrows them: {error}{_causes(outcome)}{unseen}"
        return PlanStep("impossible", why, None, reached, model, exit_code=EXIT_NO_SOLUTION)
    why = f"{wide}; a controller exists for exact values{unseen}"
    return PlanStep("finer", why, test, reached, model)


def _validation(bench: Bench) -> tuple[PreciseTest | None, str]:
    """Return a test of position steps (None if impossible), and advice on the validation."""

    def steps(usable: Bench) -> PreciseTest:
        return PreciseTest(excite("steps", usable, ExcitationSettings()), {}, {})

    try:
        test = ContainedDesign.of(bench).test(steps)
    except NoSolutionError as error:
        return None, f"validate the model with your own motion, because no steps are safe ({error})"
    return _compensated(test, bench), "validate the model"


def _reached(outcome: IdentifiedModel) -> tuple[ReachedPrecision, ...]:
    return tuple(
        ReachedPrecision(
            name, one.value, one.half_width, getattr(outcome.model.parameters, name).unit
        )
        for name, one in outcome.result.identified.items()
        if getattr(outcome.model.parameters, name, None) is not None
    )
