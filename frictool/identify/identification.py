"""Identification of sliding parameters from logs of motion, and of the breakaway from ramps.

For each parameter that is not identified, the result states the reason.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import NamedTuple

import msgspec

from frictool.documents.bench import Bench
from frictool.documents.laws import Backward, Laws
from frictool.documents.quantity import Span
from frictool.errors import EXIT_NO, EXIT_NO_SOLUTION
from frictool.identify import methods
from frictool.identify.axis_logs import LOOKS_SLIDING, SLIDING_LOG, AxisLogs, sort_logs
from frictool.identify.breakaway.rate_table import BreakawayOverRate
from frictool.identify.breakaway_parameters import (
    NO_RAMPS,
    impossible_breakaway,
    with_breakaway,
    with_varying_breakaway,
    without_impossible_breakaway,
)
from frictool.identify.fit_result import (
    CURVE,
    PARAMETERS,
    SLIDING,
    Interval,
    SlidingFit,
    UnusableLogs,
)
from frictool.identify.fit_warnings import (
    asymmetry_warnings,
    contradiction_warnings,
    doubt_warnings,
    extrapolated_spring_warnings,
    load_warnings,
    local_ramp_warnings,
    logged_positions,
    mixed_onset_warnings,
    rejected_onset_warnings,
    replacement_warnings,
    reversal_notes,
    short_stroke_warnings,
    unstable_load_warnings,
)
from frictool.identify.fitted_lag import fitted_lag
from frictool.identify.interval_checks import NEVER_NEGATIVE, below_coulomb
from frictool.identify.load_kink import LoadKink
from frictool.identify.log_disagreement import pooling_warnings
from frictool.identify.measurement_faults import commanded, one_sided_effort
from frictool.identify.method_check import method_warnings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.orientation import negative_effort, reversed_sign
from frictool.identify.outcome import Outcome, accept
from frictool.identify.regression.term_selection import WORTH
from frictool.identify.rows.effects import DELAY
from frictool.identify.rows.load_terms import ONLY_OFFSET
from frictool.identify.rows.temperature_law import with_reference
from frictool.identify.sliding_parameters import (
    NO_SLIDING,
    any_negative,
    explained,
    settled,
    sliding_fit,
)
from frictool.identify.total_load import total_load
from frictool.identify.unmodelled_effects import WidenedFit

# `identify_records` raises NothingIdentified if none of these parameters is identified
PHYSICAL = frozenset(NEVER_NEGATIVE)
ORDER = (*PARAMETERS, *CURVE)  # order of parameters in a model and its views


@dataclass(frozen=True, kw_only=True)
class Identification(Outcome):
    """Outcome of the identification of one axis, with data for the model and its views.

    - confidence: confidence of every interval, 0 to 1
    - kinds: kind of each log (`sliding` or `ramp`), by the name of the log
    - warnings: warnings about the logs or the result
    - doubts: warnings that the interval of an identified parameter may not contain the true value,
      by parameter
    - notes: texts on effects that the model lacks, but that the intervals include
    - over_rate: breakaway as a function of the ramp's rate (rise of the effort per second); None
      without a table of breakaways
    - logged: range of the positions of the sliding logs, rad | m; None without a sliding fit, or
      without a measured position
    - kink: kink (abrupt change) of the load, on one side of which the model is valid; None without
      a kink
    """

    method: str
    confidence: float
    kinds: dict[str, str]
    warnings: tuple[str, ...] = ()
    doubts: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    over_rate: BreakawayOverRate | None = None
    logged: Span | None = None
    kink: LoadKink | None = None

    def with_table(self, over_rate: BreakawayOverRate, bench: Bench) -> Identification:
        """Return the identification with the breakaway from the table `over_rate`."""
        outcome = Outcome(self.identified, self.refused, narrowed=self.narrowed)
        outcome = outcome.merge(accept({"breakaway": over_rate.interval}, bench))
        coulomb = outcome.identified.get("coulomb")
        impossible = None if coulomb is None else below_coulomb(over_rate.interval, coulomb)
        if impossible is not None:
            outcome = outcome.merge(Outcome(refused={"breakaway": impossible}))
        ordered = {name: outcome.identified[name] for name in ORDER if name in outcome.identified}
        return replace(
            self,
            identified=ordered,
            refused=outcome.refused,
            narrowed=outcome.narrowed,
            over_rate=over_rate,
        )

    def without_doubts(self) -> Identification:
        """Return the identification in which the parameters with doubts are refused."""
        laws = self.laws
        if "breakaway" in self.doubts and laws is not None:
            backward = msgspec.structs.replace(laws.backward or Backward(), breakaway=None)
            laws = msgspec.structs.replace(
                laws, position=None, backward=None if backward == Backward() else backward
            )
            laws = None if laws == Laws() else laws
        return replace(self, **vars(self.merge(Outcome(refused=self.doubts))) | {"laws": laws})


class NothingIdentified(UnusableLogs):
    """Error: the logs give neither inertia nor friction; `result` contains the reasons.

    The message states the most frequent reason. If there are several reasons, the message also
    names the parameters that have this reason, and the number of the other parameters. `exit_code`
    is 1 if no fit was possible, and 4 if a fit gave neither inertia nor friction or if position and
    drive have opposite signs.
    """

    def __init__(self, result: Identification, exit_code: int = EXIT_NO) -> None:
        self.result = result
        self.exit_code = exit_code
        reasons = self.reasons
        reason = max(reasons, key=lambda one: len(reasons[one]), default="")
        others = sum(map(len, reasons.values())) - len(reasons.get(reason, ()))
        super().__init__(
            f"{', '.join(reasons[reason])}: {reason} (others: {others})" if others else reason
        )

    @property
    def reasons(self) -> dict[str, list[str]]:
        """Return a mapping from each reason to the names of the parameters refused for it.

        A missing log is a reason only if there is no other reason.
        """
        reasons = _by_reason(self.result.refused)
        for missing in (NO_RAMPS, NO_SLIDING):
            if len(reasons) > 1:
                reasons.pop(missing, None)
        return reasons


def _by_reason(refused: Mapping[str, str]) -> dict[str, list[str]]:
    grouped: dict[str, list[str]] = {}
    for name in PARAMETERS:
        if name in refused:
            grouped.setdefault(refused[name], []).append(name)
    return grouped


def identify_records(
    records: Sequence[MotionRecord],
    ramps: Sequence[MotionRecord],
    bench: Bench,
    method: str,
    settings: methods.IdentificationSettings,
) -> Identification:
    """Identify the axis of `bench` from records of sliding motion and of breakaway ramps.

    For each record in `records`, the kind is detected: sliding motion or ramps. The records in
    `ramps` are ramps.

    Raises
    ------
    NothingIdentified
        If the records give neither inertia nor friction, or if position and drive have opposite
        signs.
    LogError
        If a log occurs twice, or cannot come from this axis.
    """
    estimate = _estimate(sort_logs(records, ramps, bench, method, settings))
    if bench.load is None and estimate.has_load and estimate.varies:
        # during slip, friction over position that differs between the directions resembles a load
        without_load = msgspec.structs.replace(bench, load=ONLY_OFFSET)
        try:
            other = _estimate(sort_logs(records, ramps, without_load, method, settings))
        except NothingIdentified:
            other = estimate
        if other.force_error < WORTH * estimate.force_error:
            estimate = other
    logs, free, outcome, wider = estimate
    outcome = without_impossible_breakaway(outcome, bench)
    if logs.kink is not None:
        outcome = outcome.merge(Outcome(refused={"load": logs.kink.shown(bench)}))
    ordered = {name: outcome.identified[name] for name in ORDER if name in outcome.identified}
    suspects = _suspects(logs, outcome, wider)
    outcome = replace(outcome, identified=ordered, laws=with_reference(outcome.laws, logs.sliding))
    sliding = [one for one in records if logs.kinds[one.name] == SLIDING_LOG]
    logged = None if outcome.fit is None else logged_positions(sliding, bench)
    result = Identification(
        **vars(outcome),
        method=method if outcome.fit is None else outcome.fit.method or method,
        confidence=settings.confidence,
        kinds=logs.kinds,
        warnings=(
            *(one for one in logs.warnings if outcome.ramp or not one.endswith(LOOKS_SLIDING)),
            *_warnings(logs, free, outcome, logged),
            *dict.fromkeys(chain.from_iterable(suspects.values())),
            *(() if wider is None else dict.fromkeys(wider.warnings(outcome.identified))),
        ),
        doubts={name: texts[0] for name, texts in suspects.items() if texts and name in ordered},
        notes=(
            *(() if wider is None else wider.notes(outcome.identified)),
            *reversal_notes(outcome.ramp, logs.bench),
        ),
        logged=logged,
        kink=logs.kink,
    )
    if PHYSICAL & outcome.identified.keys():
        return result
    raise _nothing_physical(logs, result)


class _Estimate(NamedTuple):
    """Estimate of all parameters.

    - logs: logs of the axis; the records of ramps state the effort of the fitted load
    - free: fit of the sliding logs in which no parameter is fixed at its value in the bench
    - wider: fit of `outcome`, with intervals widened for disturbing effects that the model lacks
    """

    logs: AxisLogs
    free: SlidingFit | None
    outcome: Outcome
    wider: WidenedFit | None

    @property
    def has_load(self) -> bool:
        """Return True if the sliding logs show a load over position."""
        return self.outcome.laws is not None and self.outcome.laws.load is not None

    @property
    def varies(self) -> bool:
        """Return True if the ramps show a breakaway that varies with position."""
        return self.outcome.ramp is not None and self.outcome.ramp.by_position is not None

    @property
    def force_error(self) -> float:
        """Return the force error of the model, or inf if it is unknown."""
        fit = self.outcome.fit
        return math.inf if fit is None or fit.force_error is None else fit.force_error


def _estimate(logs: AxisLogs) -> _Estimate:
    """Estimate all parameters.

    If the load has a kink, only the samples on one side of the kink are used. Raises
    NothingIdentified if position and drive of a sliding log have opposite signs, or if the fit
    fails and the position alone explains the effort.
    """
    free = None
    wider = None
    failure = ""
    try:
        free = sliding_fit(logs)
    except UnusableLogs as error:
        failure = str(error)
    lag = None
    if free is not None and not logs.drive_off:
        lag = fitted_lag(free, logs.sliding, logs.bench, logs.settings.confidence)
    if free is not None and lag is not None:
        try:
            return _with_lag(_estimate(logs.sensed(lag.value)), free, lag)
        except NothingIdentified:
            pass  # too few samples remain; the first fit includes the lag to first order
    kink = logs.find_kink(None if free is None else free.load)
    if kink is not None:
        return _estimate(logs.on_one_side(kink))
    outcome = Outcome(refused=dict.fromkeys(SLIDING, failure))
    if free is not None:
        try:
            outcome, wider = settled(logs, free)
        except UnusableLogs as error:
            outcome = Outcome(refused=dict.fromkeys(SLIDING, str(error)))
    doubtful = not {"viscous", "coulomb"} <= outcome.identified.keys() or any_negative(outcome.fit)
    if doubtful and not logs.drive_off:
        reason = None if PHYSICAL & outcome.identified.keys() else commanded(logs.sliding)
        reason = reason or reversed_sign(logs.sliding, logs.bench, logs.settings)
        if reason is not None:
            raise _without_any(logs, reason)
    outcome = _with_total_load(logs, outcome)
    logs = logs.with_load(outcome.laws)
    outcome = with_varying_breakaway(logs, with_breakaway(logs, outcome))
    if outcome.fit is not None:
        outcome = replace(outcome, fit=replace(outcome.fit, laws=outcome.laws))
        outcome = explained(logs, outcome)
    return _Estimate(logs, free, outcome, wider)


def _with_lag(estimate: _Estimate, first: SlidingFit, lag: Interval) -> _Estimate:
    """Return the estimate with the fitted `lag` as an effect, and with a warning of this lag.

    The warning says that the model lacks the lag. `first` is the fit before the lag was fitted; its
    explanation of the delay is kept.
    """
    fit = estimate.outcome.fit
    if fit is None:
        return estimate
    late = Interval(-lag.value, -lag.high, -lag.low)
    kept = [one for one in first.explanations if one.name == DELAY]
    kept += [one for one in fit.explanations if one.name != DELAY]
    stated = replace(fit, effects={**fit.effects, DELAY: late}, explanations=tuple(kept))
    text = (
        f"the position follows the effort with a lag of {1e3 * lag.value:.3g} ms, which the model "
        "lacks; state it in encoder.time_constant_s (sensor) or "
        "actuator.loop_time_constant_s (drive)"
    )
    wider = estimate.wider
    if wider is not None:
        cautions = (*wider.cautions, *((name, text) for name in PARAMETERS))
        wider = replace(wider, cautions=cautions)
    return estimate._replace(outcome=replace(estimate.outcome, fit=stated), wider=wider)


def _with_total_load(logs: AxisLogs, outcome: Outcome) -> Outcome:
    """Return the outcome with the interval of the total load, if it is known, in its load law.

    The interval is unknown if the drive was off, or if a kink of the load separates the samples of
    the fit from a part of the travel.
    """
    offset, fit, laws = outcome.identified.get("offset"), outcome.fit, outcome.laws
    if offset is None or fit is None or laws is None or laws.load is None:
        return outcome
    if logs.drive_off or logs.kink is not None:
        return outcome
    total = total_load(fit, offset, logs.sliding, logs.bench, logs.settings.confidence)
    load = msgspec.structs.replace(laws.load, total=total)
    return replace(outcome, laws=msgspec.structs.replace(laws, load=load))


def _suspects(logs: AxisLogs, outcome: Outcome, wider: WidenedFit | None) -> dict[str, list[str]]:
    """Return the warnings that an interval may not contain the true value, by parameter."""
    fit = outcome.fit
    impossible = impossible_breakaway(outcome, logs.bench)
    short = [] if fit is None else short_stroke_warnings(fit, logs.sliding)
    doubts = {} if wider is None else wider.doubts(outcome.identified)
    return {
        "breakaway": [
            *load_warnings(outcome.ramp, logs.bench),
            *local_ramp_warnings(outcome.ramp, fit, logs.sliding, logs.bench),
            *mixed_onset_warnings(outcome.ramp, logs.bench),
            *asymmetry_warnings(outcome.ramp, fit, logs.bench),
            *([f"breakaway: {impossible}"] if impossible else []),
        ],
        **{name: [*short, *doubts.get(name, ())] for name in SLIDING},
    }


def _warnings(
    logs: AxisLogs, free: SlidingFit | None, outcome: Outcome, logged: Span | None
) -> list[str]:
    warnings = contradiction_warnings(outcome.identified, logs.bench)
    warnings += rejected_onset_warnings(outcome.ramp)
    fit = outcome.fit
    if fit is None or free is None:
        return warnings
    warnings += [
        *replacement_warnings(free, fit, outcome.identified),
        *([] if logs.drive_off else doubt_warnings(fit, logs.method)),
        *unstable_load_warnings(fit, logs.sliding, logs.bench),
        *extrapolated_spring_warnings(fit, logged, logs.bench),
        *pooling_warnings(logs.sliding, logs.bench, logs.settings, free, outcome.identified),
    ]
    if logs.method != methods.DEFAULT and not logs.drive_off:
        warnings += method_warnings(logs.sliding, logs.rows, logs.bench, logs.settings, fit)
    return warnings


def _nothing_physical(logs: AxisLogs, result: Identification) -> NothingIdentified:
    powered = [] if logs.drive_off else logs.sliding
    reason = negative_effort([*powered, *logs.ramps], logs.bench, result.confidence)
    reason = reason or one_sided_effort(powered)
    if reason is not None:
        return _without_any(logs, reason)
    refused = dict(result.refused)
    if "offset" in result.identified:
        offset = result.identified["offset"].value
        refused["offset"] = f"the fit gives {offset:.4g} and neither inertia nor friction"
    exit_code = EXIT_NO if result.fit is None else EXIT_NO_SOLUTION
    return NothingIdentified(
        replace(result, identified={}, narrowed={}, refused=refused), exit_code
    )


def _without_any(logs: AxisLogs, reason: str) -> NothingIdentified:
    result = Identification(
        refused=dict.fromkeys(PARAMETERS, reason),
        method=logs.method,
        confidence=logs.settings.confidence,
        kinds=logs.kinds,
        warnings=logs.warnings,
    )
    return NothingIdentified(result, EXIT_NO_SOLUTION)
