"""Estimation of the sliding parameters of an axis from its logs of motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from frictool.adapters.parameter_intervals import relative
from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.axis_logs import AxisLogs
from frictool.identify.coast_down import coast_down
from frictool.identify.estimators.output_error import OUTPUT_ERROR
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit, UnusableLogs
from frictool.identify.fit_warnings import DOUBTFUL_FORCE_ERROR
from frictool.identify.fixed_parameter_refit import fixed_parameters, refit
from frictool.identify.force_error import force_error, nearest_values, predicted_by_position
from frictool.identify.interval_checks import NEVER_NEGATIVE, contradicts
from frictool.identify.measurement_faults import refuse_self_explained
from frictool.identify.methods import METHODS, run
from frictool.identify.orientation import undriven
from frictool.identify.outcome import Outcome, accept, sliding_intervals
from frictool.identify.unmodelled_effects import WidenedFit, widened

NO_SLIDING = "no log of sliding motion was provided"
OTHER_UNIT = 10.0  # force error above which the bench's values are far too large for the effort
LARGEST_FORCE_ERROR = 0.5  # a quarter of the effort's mean square is then unexplained


def sliding_fit(logs: AxisLogs) -> SlidingFit:
    """Fit the sliding logs with the requested method, and compute the force error.

    Raises
    ------
    UnusableLogs
        If no fit is possible, or if the force error exceeds LARGEST_FORCE_ERROR.
    """
    if not logs.sliding:
        raise UnusableLogs(logs.unmeasured or NO_SLIDING)
    if logs.drive_off:
        return coast_down(logs.sliding, logs.rows, logs.bench, logs.settings)
    fit = run(logs.method, logs.sliding, logs.bench, logs.settings)
    fit = replace(fit, method=fit.method or logs.method)
    if fit.method != OUTPUT_ERROR:  # it examines the regression from which its search starts
        refuse_self_explained(fit, logs.sliding)
    fit = with_force_error(fit, logs, fit.parameters)
    error = unexplained(logs, fit, fit.parameters)
    if error is not None:
        for record in logs.sliding:
            reason = undriven(record, logs.bench, logs.settings.confidence)
            if reason is not None:
                raise UnusableLogs(reason)
        raise UnusableLogs(
            f"the model does not explain the effort: force error {100 * error:.3g} % "
            f"(allowed: at most {100 * LARGEST_FORCE_ERROR:g} %); {_advice(logs, fit, error)}"
        )
    return fit


def _advice(logs: AxisLogs, fit: SlidingFit, error: float) -> str:
    """Return advice for a `fit` that does not explain the effort; `error` is its force error."""
    if error > OTHER_UNIT and not fit.parameters.keys() >= set(SLIDING):
        return (
            "the effort is far too small for the bench's values; check the unit in "
            f"columns.{logs.bench.actuator.drive}"
        )
    load = predicted_by_position(logs.rows)
    if load is not None and load < LARGEST_FORCE_ERROR:
        return (
            f"a load over the position predicts all but {100 * load:.2g} % (contact, stop?): "
            "log only positions without it"
        )
    return "check that effort and position are from the same test"


def settled(logs: AxisLogs, fit: SlidingFit) -> tuple[Outcome, WidenedFit]:
    """Return the accepted parameters of `fit`, and the final fit with widened intervals.

    The final fit is a second fit, in which the refused parameters have their values in the model
    (`fixed_parameter_refit.py`). If the second fit does not explain the effort, or refuses a
    parameter that `fit` identifies, a value of the bench contradicts the log. The final fit is then
    `fit`, and a refused parameter keeps its fitted value if this value is in the bench's range.
    There is no second fit if no refused parameter can be fixed, if nothing but an offset is
    identified, or if the method fits a curve of friction over speed.
    """
    wider = with_unmodelled_effects(logs, fit)
    outcome = accept(wider.fit.parameters, logs.bench, wider.fit.refused)
    vague = {n: reason for n, reason in outcome.refused.items() if n not in wider.fit.refused}
    wider = wider.with_advice(vague)
    outcome = outcome.merge(Outcome(refused=wider.refusals(vague), narrowed=outcome.narrowed))
    outcome = outcome.merge(Outcome(refused=_needless_contradictions(logs, wider.fit)))
    outcome = replace(outcome, fit=wider.fit, laws=wider.fit.laws)
    fixed = fixed_parameters(wider.fit, outcome, logs.bench)
    final = METHODS[fit.method or logs.method].whole_curve
    if final or not outcome.identified.keys() - {"offset"} or not fixed:
        return outcome, wider
    try:
        again = with_unmodelled_effects(
            logs, refit(logs.sliding, logs.bench, logs.settings, wider.fit, fixed)
        )
    except UnusableLogs:
        return _with_fitted_values(outcome, wider.fit, fixed, logs.bench), wider
    reasons = {n: reason for n, reason in again.fit.refused.items() if n not in outcome.refused}
    others = {n: one for n, one in outcome.identified.items() if n not in SLIDING}
    accepted = accept(again.fit.parameters, logs.bench, reasons)
    merged = replace(outcome, identified=others).merge(accepted)
    merged = replace(merged, fit=again.fit, laws=again.fit.laws)
    if (
        outcome.identified.keys() - merged.identified.keys()
        or unexplained(logs, again.fit, merged.from_logs) is not None
    ):
        return _with_fitted_values(outcome, wider.fit, fixed, logs.bench), wider
    return merged, replace(again, spring=wider.spring, advice=wider.advice)


def _needless_contradictions(logs: AxisLogs, fit: SlidingFit) -> dict[str, str]:
    """Return a reason for each parameter that contradicts the bench without a better model.

    If effects were removed from the effort, a parameter may follow from a wrong effect, such as
    friction that changes along the log in place of friction that falls with speed. The model
    contains no effects. An interval that does not overlap the bench's range therefore needs a model
    that is more accurate than the model with the nearest value of this range.
    """
    reasons = dict[str, str]()
    if not fit.effects or fit.force_error is None:
        return reasons
    for name in NEVER_NEGATIVE:
        known: Quantity | None = getattr(logs.bench.mechanics, name, None)
        interval = fit.parameters.get(name)
        if known is None or interval is None or not contradicts(interval, known):
            continue
        low, high = known.interval
        end = low if interval.high < low else high
        try:
            again = refit(
                logs.sliding, logs.bench, logs.settings, fit, {name: Interval(end, end, end)}
            )
        except UnusableLogs:
            continue
        error = with_force_error(again, logs, again.parameters).force_error
        if error is not None and error <= fit.force_error:
            reasons[name] = (
                f"the log's interval [{interval.low:.4g}, {interval.high:.4g}] lies outside the "
                f"bench's [{low:.4g}, {high:.4g}], with which the model is as accurate; record "
                "faster motions"
            )
    return reasons


def _with_fitted_values(
    outcome: Outcome, fit: SlidingFit, fixed: Mapping[str, Interval], bench: Bench
) -> Outcome:
    """Return the outcome in which refused parameters have their fitted values.

    A fitted value is used only if it is within the parameter's range in `fixed`; its interval is
    then this range.
    """
    ranges = {}
    for name, known in fixed.items():
        value = fit.parameters[name].value
        if known.low <= value <= known.high:
            ranges[name] = _in_range(value, known.low, known.high, bench)
    return replace(outcome, narrowed={**ranges, **outcome.narrowed})


def with_unmodelled_effects(logs: AxisLogs, fit: SlidingFit) -> WidenedFit:
    """Return the fit with intervals widened for disturbing effects that the model lacks.

    The intervals do not change in two cases: the drive was off, so that the effort does not show
    the effects; or the method serves for comparison only and has a large force error, of which
    `fit_warnings` warns.
    """
    doubtful = (fit.force_error or 0.0) > DOUBTFUL_FORCE_ERROR
    if logs.drive_off or (doubtful and METHODS[logs.method].comparison):
        return WidenedFit(fit)
    return widened(fit, logs.sliding, logs.bench, logs.settings.confidence)


def any_negative(fit: SlidingFit | None) -> bool:
    """Return True if the fit has a negative value of a parameter that cannot be negative."""
    return fit is not None and any(
        name in NEVER_NEGATIVE and interval.value < 0.0 for name, interval in fit.parameters.items()
    )


def with_force_error(
    fit: SlidingFit, logs: AxisLogs, from_logs: Mapping[str, Interval]
) -> SlidingFit:
    """Add the force error of the model to the fit, unless the drive was off.

    The model has the parameters `from_logs`; all other parameters have the values in bench.yaml.
    """
    if logs.drive_off:
        return fit
    error = force_error(logs.rows, _values(logs, from_logs), fit.laws)
    return replace(fit, force_error=error)


def unexplained(logs: AxisLogs, fit: SlidingFit, from_logs: Mapping[str, Interval]) -> float | None:
    """Return the force error if no values within the bench's ranges explain the effort, else None.

    The parameters `from_logs` have the values of the logs. Each other parameter has the value
    within its range in bench.yaml that minimises the force error. Return None if the drive was off.
    """
    if logs.drive_off:
        return None
    values = nearest_values(
        logs.rows, _values(logs, from_logs), fit.laws, _ranges(logs.bench, from_logs)
    )
    error = force_error(logs.rows, values, fit.laws)
    return error if error is not None and error > LARGEST_FORCE_ERROR else None


def _values(logs: AxisLogs, from_logs: Mapping[str, Interval]) -> dict[str, float]:
    intervals = {**sliding_intervals(from_logs, logs.bench), **from_logs}
    return {name: interval.value for name, interval in intervals.items()}


def _ranges(bench: Bench, from_logs: Mapping[str, Interval]) -> dict[str, tuple[float, float]]:
    """Return the ranges in bench.yaml of the sliding parameters that are not in `from_logs`."""
    known = {name: getattr(bench.mechanics, name) for name in SLIDING if name not in from_logs}
    return {name: one.interval for name, one in known.items() if one is not None}


def explained(logs: AxisLogs, outcome: Outcome) -> Outcome:
    """Add the force error to the outcome, and refuse parameters that do not explain the effort.

    If values in bench.yaml cause a force error above LARGEST_FORCE_ERROR, each parameter that is
    not identified gets the value within its range in bench.yaml that minimises the force error. If
    the force error is still above LARGEST_FORCE_ERROR, all sliding parameters are refused.
    """
    assert outcome.fit is not None
    fit = with_force_error(outcome.fit, logs, outcome.from_logs)
    outcome = replace(outcome, fit=fit)
    if fit.force_error is None or fit.force_error <= LARGEST_FORCE_ERROR:
        return outcome
    error = unexplained(logs, fit, outcome.from_logs)
    if error is None:
        ranges = _ranges(logs.bench, outcome.from_logs)
        values = nearest_values(logs.rows, _values(logs, outcome.from_logs), fit.laws, ranges)
        moved = {
            name: _in_range(values[name], low, high, logs.bench)
            for name, (low, high) in ranges.items()
            if low < high
        }
        outcome = replace(outcome, narrowed={**outcome.narrowed, **moved})
        return replace(outcome, fit=with_force_error(fit, logs, outcome.from_logs))
    reason = (
        "with values in the bench's ranges for the other parameters, the model does not explain "
        f"the effort: force error {100 * error:.3g} % (allowed: at most "
        f"{100 * LARGEST_FORCE_ERROR:g} %)"
    )
    lost = [name for name in SLIDING if name in outcome.from_logs]
    return outcome.merge(Outcome(refused=dict.fromkeys(lost, reason)))


def _in_range(value: float, low: float, high: float, bench: Bench) -> Interval:
    """Return the interval of a value within the range [low, high] of a parameter in bench.yaml."""
    low, high = relative(low, high, bench.actuator.constant)
    return Interval(value, min(low, value), max(high, value))
