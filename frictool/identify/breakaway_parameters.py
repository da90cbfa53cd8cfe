"""Identification of breakaway from ramps, and of friction that varies with position."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.load_terms import Term
from frictool.documents.quantity import si_unit
from frictool.identify import methods
from frictool.identify.assess.identifiability import WEAK_FORM
from frictool.identify.axis_logs import AxisLogs
from frictool.identify.breakaway.breakaway import Breakaway, BreakawayOverPosition, breakaway
from frictool.identify.breakaway.friction_map import breakaway_laws, friction_map, shape_at
from frictool.identify.breakaway.onset_detection import (
    FEWEST_ONSETS,
    find_onsets,
    passages_of,
    returning_share,
)
from frictool.identify.breakaway.onset_load import joint_error, joint_errors
from frictool.identify.breakaway.stribeck_velocity import StribeckFall, StribeckVelocityRange
from frictool.identify.estimators.auto import inertia_over_position
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit, UnusableLogs
from frictool.identify.fit_warnings import cover_travel
from frictool.identify.fixed_parameter_refit import refit
from frictool.identify.interval_checks import below_coulomb
from frictool.identify.orientation import opposite_signs
from frictool.identify.outcome import Outcome, accept, bench_interval, sliding_intervals
from frictool.identify.ramp_load import ramp_load
from frictool.identify.regression.term_selection import WORTH
from frictool.identify.rows.effects import WHAT
from frictool.identify.rows.load_terms import ONLY_OFFSET
from frictool.identify.rows.position_orders import FITTED_ORDERS
from frictool.identify.rows.regression_samples import FEWEST_STROKES
from frictool.identify.sliding_parameters import with_force_error, with_unmodelled_effects

# largest permitted share of ramps after which an unknown load moves the axis back without drive
MOST_RETURNS = 0.5
NO_RAMPS = "no log of breakaway ramps was provided"
MAP_HIDES_OFFSET = (
    "friction over position is fitted for each direction, and the offset cannot be separated from "
    "half the difference between the directions; the bench's offset is used"
)
OVER_POSITION: tuple[Term, ...] = ("friction_over_position", "load_over_position")


def with_breakaway(logs: AxisLogs, sliding: Outcome) -> Outcome:
    """Return the outcome of the sliding logs, extended by the breakaway that the ramps show."""
    try:
        ramp = _breakaway(logs, sliding)
    except UnusableLogs as error:
        outcome = Outcome(refused={"breakaway": str(error)})
    else:
        shown = f"the breakaway is in [{ramp.interval.low:.4g}, {ramp.interval.high:.4g}]"
        outcome = (
            Outcome(refused={"breakaway": opposite_signs(logs.ramps, shown, logs.bench)})
            if ramp.interval.high < 0.0
            else accept({"breakaway": ramp.interval}, logs.bench)
        )
        outcome = replace(outcome, ramp=ramp)
    # the sliding logs may give a breakaway too, or say why they do not
    known = sliding.identified if logs.ramps else {**sliding.identified, **sliding.refused}
    if "breakaway" in known and "breakaway" not in outcome.identified:
        outcome = outcome.without("breakaway")
    return sliding.merge(outcome)


def _breakaway(logs: AxisLogs, sliding: Outcome) -> Breakaway:
    if not logs.ramps:
        raise UnusableLogs(logs.unused_ramps or NO_RAMPS)
    for record in logs.ramps:
        if record.velocity is not None:
            raise UnusableLogs(
                f"{record.name} has no position, from which the time of a breakaway is computed; "
                "log the position"
            )
    _refuse_returning(logs, sliding)
    identified = sliding.identified
    axis = sliding_intervals(sliding.from_logs, logs.bench)
    confidence = logs.settings.confidence
    load = ramp_load(logs, sliding)
    known = sliding.laws.load if sliding.laws is not None else None
    offset = axis["offset"]
    error = joint_error(known, offset.half_width)
    if error is not None and known is not None and known.total is not None:
        axis["offset"] = Interval.around(offset.value, 0.0)
        load = replace(load, errors=joint_errors(known.total.over, error))
    ramp = breakaway(logs.ramps, logs.bench, axis, confidence, _known_fall(sliding), load)
    if "offset" in identified or logs.bench.mechanics.offset is not None:
        return ramp
    if math.isnan(ramp.forward) or math.isnan(ramp.backward):
        onsets = [one for record in logs.ramps for one in find_onsets(record, logs.bench, axis)]
        forward = sum(one.direction > 0.0 for one in onsets)
        raise UnusableLogs(
            f"found {forward} breakaways forward, {len(onsets) - forward} backward, and no known "
            f"offset; needed: {FEWEST_ONSETS} in each direction, or mechanics.offset in the bench"
        )
    if min(ramp.forward, ramp.backward) <= 0.0:
        side = "forward" if ramp.forward <= 0.0 else "backward"
        unit = si_unit("effort", logs.bench.axis)
        raise UnusableLogs(
            f"the axis starts {side} although the drive opposes this motion with "
            f"{-min(ramp.forward, ramp.backward):.3g} {unit}: a load moves it; add a log of "
            "sliding, or state mechanics.offset in the bench"
        )
    return ramp


def _refuse_returning(logs: AxisLogs, sliding: Outcome) -> None:
    """Raise UnusableLogs if the axis moves back after most ramps, because of an unknown load.

    The load is known if it is part of the model, and if the sliding logs pass the median position
    of each log of ramps at least 2*FEWEST_STROKES times.
    """
    known = sliding.laws is not None and sliding.laws.load is not None
    unit = si_unit("position", logs.bench.axis)
    enough = 2 * FEWEST_STROKES
    for record in logs.ramps:
        share = returning_share(record, logs.bench)
        rest = float(np.median(record.position))
        passages = sum(passages_of(one, rest) for one in logs.sliding)
        if share > MOST_RETURNS and not (known and passages >= enough):
            raise UnusableLogs(
                f"after {100 * share:.3g} % of ramps, the axis returns to {rest:.3g} "
                f"{unit} without drive: a load exceeds the breakaway; log {enough} strokes through "
                "this position, or remove the load"
            )


def _known_fall(sliding: Outcome) -> StribeckVelocityRange | None:
    velocity = sliding.identified.get("stribeck_velocity")
    if velocity is None:
        return None
    exponent = (sliding.laws or Laws()).stribeck_exponent
    value, low, high = (
        StribeckFall(each, exponent) for each in (velocity.value, velocity.low, velocity.high)
    )
    return StribeckVelocityRange(value, (low, high), known=True)


def with_varying_breakaway(logs: AxisLogs, outcome: Outcome) -> Outcome:
    """Return the outcome with laws for a breakaway that varies with position or time at rest.

    If the breakaway varies with position, the sliding parameters that were fitted under the
    assumption of constant friction are replaced. There are two candidates: a regression with
    friction over position, and a friction map. A map is fitted only if the ramps cover at least
    half of the travel of the sliding logs. The map is used if its force error is noticeably smaller
    than that of the regression, or if there is no regression. In two cases, only the breakaway
    depends on position: there is no candidate; or the model has a load or friction by direction,
    which the map does not include.
    """
    ramp, fit, laws = outcome.ramp, outcome.fit, outcome.laws
    if ramp is None or (ramp.by_position is None and ramp.rising is None):
        return outcome
    # a load or friction by direction, which the map does not model
    unmapped = laws is not None and (laws.load or laws.backward)
    if ramp.by_position is None or unmapped:
        return _with_laws(logs, outcome, ramp, laws)
    regression = None
    if fit is not None:
        outcome, regression = _fitted_over_position(logs, outcome, fit, ramp.by_position)
    mapped = _mapped(logs, outcome, ramp) if cover_travel(ramp, logs.sliding) else None
    if regression is None:
        return mapped or _with_laws(logs, outcome, ramp, None)
    fitted = _with_laws(
        logs, _with_coulomb_of_ramps(logs, regression, ramp.by_position), ramp, None
    )
    if mapped is None or not _force_error(logs, mapped) < WORTH * _force_error(logs, fitted):
        return fitted
    return mapped


def _force_error(logs: AxisLogs, outcome: Outcome) -> float:
    assert outcome.fit is not None
    fit = replace(outcome.fit, laws=outcome.laws, force_error=None)
    error = with_force_error(fit, logs, outcome.from_logs).force_error
    return math.inf if error is None else error


def _mapped(logs: AxisLogs, outcome: Outcome, ramp: Breakaway) -> Outcome | None:
    """Return the outcome with the friction map, or None if the logs do not determine the map."""
    axis = sliding_intervals(outcome.from_logs, logs.bench)
    axis["offset"] = bench_interval(logs.bench, "offset")
    try:
        mapped = friction_map(logs.sliding, logs.ramps, ramp, axis, logs.bench, logs.settings)
    except UnusableLogs:
        return None
    refused = mapped.fit.refused
    if "offset" not in mapped.fit.parameters:
        refused = {"offset": MAP_HIDES_OFFSET, **refused}
    accepted = accept(mapped.fit.parameters, logs.bench, refused)
    fit = mapped.fit
    if outcome.fit is not None and "inertia" in outcome.identified:
        fit = replace(fit, why=outcome.fit.why, explanations=outcome.fit.explanations)
    outcome = outcome.without("viscous", "coulomb", "offset").merge(replace(accepted, fit=fit))
    return _with_laws(logs, outcome, mapped.ramp, fit.laws)


def _with_laws(logs: AxisLogs, outcome: Outcome, ramp: Breakaway, sliding: Laws | None) -> Outcome:
    laws = breakaway_laws(ramp, logs.bench, sliding)
    return outcome.merge(Outcome({"breakaway": ramp.parameter}, ramp=ramp, laws=laws))


def _over_position(fit: SlidingFit) -> bool:
    return not FITTED_ORDERS.keys().isdisjoint(fit.effects)


def _with_coulomb_of_ramps(logs: AxisLogs, outcome: Outcome, law: BreakawayOverPosition) -> Outcome:
    """Replace Coulomb friction by its mean over the positions of the ramps.

    The fit gives the mean over the samples in slip, which may be at other positions. The Coulomb
    friction is assumed to vary over the position in proportion to the breakaway.
    """
    coulomb = outcome.identified.get("coulomb")
    if coulomb is None or not logs.rows:
        return outcome
    position = np.concatenate([rows.position for rows in logs.rows])
    velocity = np.concatenate([rows.velocity for rows in logs.rows])
    ratio = float(np.mean(shape_at(position, velocity, law)))
    ends = (coulomb.value, coulomb.low, coulomb.high)
    return outcome.merge(Outcome({"coulomb": Interval(*(end / ratio for end in ends))}))


def _fitted_over_position(
    logs: AxisLogs, outcome: Outcome, fit: SlidingFit, law: BreakawayOverPosition
) -> tuple[Outcome, Outcome | None]:
    """Replace an inertia that was fitted under the assumption of constant friction.

    The inertial effort is the same function of the acceleration in both directions; friction
    changes its sign. The fit is therefore repeated with friction over position and, if the
    directions have different laws, with a load over position. With method `auto`, the inertia comes
    from the weak form if the weak form gives the narrower interval, or if the repeated fit gives no
    inertia. If the weak form gives no inertia, either, the inertia is refused.

    Return two outcomes. The first contains the new inertia, or its refusal. The second contains all
    parameters of the repeated fit; the second is None if the repeated fit gives no inertia, or if
    the inertia comes from the weak form.
    """
    if _over_position(fit):
        return outcome, outcome
    if fit.details.get("position_order") or "inertia" not in {*fit.parameters, *fit.refused}:
        return outcome, None
    terms = OVER_POSITION[:1] if law.common else OVER_POSITION
    declared = logs.bench.load or ONLY_OFFSET if fit.load is None else fit.load
    named = tuple(dict.fromkeys((*declared.terms, *terms)))
    load = msgspec.structs.replace(declared, terms=named)
    regression = None
    again = _refitted(logs, replace(fit, load=load), law)
    if again is not None:
        accepted = accept(again.parameters, logs.bench, again.refused)
        if "inertia" in accepted.identified:
            regression = outcome.without(*SLIDING).merge(replace(accepted, fit=again))
    weak = _weak_inertia(logs, outcome, replace(fit, load=load))
    if weak is not None:
        inertia = weak.identified["inertia"]
        if regression is None or inertia.half_width < regression.identified["inertia"].half_width:
            return weak, None
    if regression is not None:
        return regression, regression
    refused = {"inertia": _hidden_inertia(logs, fit)} if "inertia" in fit.parameters else {}
    return outcome.merge(Outcome(refused=refused)), None


def _weak_inertia(logs: AxisLogs, outcome: Outcome, fit: SlidingFit) -> Outcome | None:
    """Return the outcome with the inertia by the weak form, or None.

    The result is None in three cases: the method is not `auto`; `fit` contains effects other than
    friction over position, which the weak form lacks; the weak form identifies no inertia.
    """
    load = fit.load
    if logs.method != methods.DEFAULT or load is None or {*load.terms} - {"offset", *OVER_POSITION}:
        return None
    weak = inertia_over_position(logs.sliding, logs.bench, logs.settings)
    if weak is None:
        return None
    wider = with_unmodelled_effects(logs, replace(weak, method=WEAK_FORM, load=load))
    accepted = accept({"inertia": wider.fit.parameters["inertia"]}, logs.bench)
    if "inertia" not in accepted.identified:
        return None
    why = f"friction by sines and ramps. inertia by weak: {weak.why}"
    return outcome.without("inertia").merge(replace(accepted, fit=replace(fit, why=why)))


def _refitted(logs: AxisLogs, fit: SlidingFit, law: BreakawayOverPosition) -> SlidingFit | None:
    """Return a repeated fit with the load terms of `fit` and friction over position, or None.

    If the sliding logs stay within the positions of the ramps, the polynomial of the friction over
    position has the order of `law`. The intervals include effects that the model lacks. The result
    is None if the method cannot fit friction over position, or if the fit fails.
    """
    inside = all(
        law.low <= end <= law.high
        for record in logs.sliding
        for end in (np.min(record.position), np.max(record.position))
    )
    order = max(len(powers) for powers in law.powers) - 1 if inside else None
    name = fit.method or logs.method
    if logs.method == methods.DEFAULT and not _fits_effects(name):
        name = methods.REFERENCE
    if not _fits_effects(name):
        return None
    settings = replace(logs.settings, position_order=order)
    why = f"{name} with {WHAT[OVER_POSITION[0]]}, which the ramps show"
    try:
        again = refit(logs.sliding, logs.bench, settings, replace(fit, method=name), {})
    except UnusableLogs:
        return None
    return with_unmodelled_effects(logs, replace(again, why=why)).fit


def _fits_effects(method: str) -> bool:
    row = methods.METHODS[method]
    return row.load and row.known_terms is None


def _hidden_inertia(logs: AxisLogs, fit: SlidingFit) -> str:
    method = fit.method or logs.method
    advice = (
        "record more strokes over the same positions with different accelerations"
        if logs.method == methods.DEFAULT
        else "use --method auto"
    )
    return (
        f"friction varies along a stroke like the acceleration, and {method} does not separate "
        f"them; {advice}"
    )


def without_impossible_breakaway(outcome: Outcome, bench: Bench) -> Outcome:
    """Refuse a constant breakaway in the outcome if it is below Coulomb friction."""
    impossible = impossible_breakaway(outcome, bench)
    if not impossible or outcome.ramp is None or outcome.ramp.by_position is not None:
        return outcome
    return outcome.merge(Outcome(refused={"breakaway": impossible}))


def impossible_breakaway(outcome: Outcome, bench: Bench) -> str:
    """Return a message if the ramps give a breakaway below Coulomb friction, else "".

    The usual cause is a backlash that the bench does not state: the ramps then move only the motor.
    """
    identified = outcome.identified
    if outcome.ramp is None or not {"breakaway", "coulomb"} <= identified.keys():
        return ""
    impossible = below_coulomb(identified["breakaway"], identified["coulomb"]) or ""
    if impossible and bench.mechanics.backlash is None:
        impossible += "; if the axis has backlash, state mechanics.backlash"
    return impossible
