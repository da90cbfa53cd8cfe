"""Identification of breakaway from ramps, and of friction that varies with position."""

from __future__ import annotations

import math
from dataclasses import replace

from frictool.documents.laws import Laws
from frictool.documents.quantity import si_unit
from frictool.identify import methods
from frictool.identify.axis_logs import AxisLogs
from frictool.identify.breakaway.breakaway import Breakaway, breakaway
from frictool.identify.breakaway.friction_map import breakaway_laws, friction_map
from frictool.identify.breakaway.onset_detection import FEWEST_ONSETS, find_onsets
from frictool.identify.breakaway.stribeck_velocity import StribeckFall, StribeckVelocityRange
from frictool.identify.estimators.auto import inertia_over_position
from frictool.identify.fit_result import SlidingFit, UnusableLogs
from frictool.identify.interval_checks import below_coulomb
from frictool.identify.orientation import opposite_signs
from frictool.identify.outcome import Outcome, accept, bench_interval, sliding_intervals
from frictool.identify.ramp_load import ramp_load

NO_RAMPS = "no log of breakaway ramps was provided"
MAP_HIDES_OFFSET = (
    "friction over position is fitted for each direction, and the offset cannot be separated from "
    "half the difference between the directions; the bench's value is used"
)
POSITION_HIDES_INERTIA = (
    "acceleration and friction both vary along a stroke, and this method cannot separate them; "
    "the bench's value is used; try --method auto or weak"
)


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
                f"{record.name} has no position, from which the time of a breakaway is computed"
            )
    identified = sliding.identified
    axis = sliding_intervals(sliding.from_logs, logs.bench)
    confidence = logs.settings.confidence
    load = ramp_load(logs, sliding)
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

    If the breakaway varies with position, a friction map replaces viscous friction, Coulomb
    friction and offset, which were fitted under the assumption of constant friction. If the sliding
    logs cannot determine a map, only the breakaway depends on position.
    """
    ramp, fit, laws = outcome.ramp, outcome.fit, outcome.laws
    if ramp is None or (ramp.by_position is None and ramp.rising is None):
        return outcome
    # a load or friction by direction, which the map does not model
    unmapped = laws is not None and (laws.load or laws.backward)
    if ramp.by_position is None or unmapped:
        return _with_laws(logs, outcome, ramp, laws)
    why = None
    if fit is not None:
        outcome, why = _inertia_over_position(logs, outcome, fit)
    axis = sliding_intervals(outcome.from_logs, logs.bench)
    axis["offset"] = bench_interval(logs.bench, "offset")
    try:
        mapped = friction_map(logs.sliding, logs.ramps, ramp, axis, logs.bench, logs.settings)
    except UnusableLogs:
        return _with_laws(logs, outcome, ramp, None)
    refused = mapped.fit.refused
    if "offset" not in mapped.fit.parameters:
        refused = {"offset": MAP_HIDES_OFFSET, **refused}
    accepted = accept(mapped.fit.parameters, logs.bench, refused)
    fit = replace(mapped.fit, why=why)
    outcome = outcome.without("viscous", "coulomb", "offset").merge(replace(accepted, fit=fit))
    return _with_laws(logs, outcome, mapped.ramp, fit.laws)


def _with_laws(logs: AxisLogs, outcome: Outcome, ramp: Breakaway, sliding: Laws | None) -> Outcome:
    laws = breakaway_laws(ramp, logs.bench, sliding)
    return outcome.merge(Outcome({"breakaway": ramp.parameter}, ramp=ramp, laws=laws))


def _inertia_over_position(
    logs: AxisLogs, outcome: Outcome, fit: SlidingFit
) -> tuple[Outcome, str | None]:
    """Replace an inertia that was fitted under the assumption of constant friction.

    With method `auto`, the weak form fits the inertia together with friction that varies with
    position, if the logs allow this. Otherwise, the inertia is refused. The returned text says why
    the methods were chosen, or is None.
    """
    if fit.details.get("position_order"):
        return outcome, fit.why
    if "inertia" in fit.parameters:
        outcome = outcome.merge(Outcome(refused={"inertia": POSITION_HIDES_INERTIA}))
    weak = (
        inertia_over_position(logs.sliding, logs.bench, logs.settings)
        if logs.method == methods.DEFAULT
        else None
    )
    if weak is None:
        return outcome, None
    accepted = accept({"inertia": weak.parameters["inertia"]}, logs.bench)
    why = f"friction by sines and ramps. inertia by weak: {weak.why}"
    return outcome.without("inertia").merge(accepted), why


def without_impossible_breakaway(outcome: Outcome) -> Outcome:
    """Return the outcome; refuse a constant breakaway below Coulomb friction."""
    identified, ramp = outcome.identified, outcome.ramp
    if (
        ramp is None
        or ramp.by_position is not None
        or not {"breakaway", "coulomb"} <= identified.keys()
    ):
        return outcome
    impossible = below_coulomb(identified["breakaway"], identified["coulomb"])
    return outcome.merge(Outcome(refused={} if impossible is None else {"breakaway": impossible}))
