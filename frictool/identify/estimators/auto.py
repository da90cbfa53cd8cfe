"""Choice of the identification method from the recorded motion (thesis, figure 4.4).

The sliding parameters are inertia, viscous friction, Coulomb friction and offset. A search first
determines which loads and disturbing effects the logs support (`explanation_search`). The following
steps fit the sliding parameters together with these loads and effects.

1. If the differentiated velocity is too inaccurate (`assess/identifiability.py`), the method of
   sines is used, and steps 2 to 4 are skipped, with two exceptions: the method of sines gives no
   finite intervals; or the intervals of least squares overlap the intervals of the sines, and are
   less than half as wide.
2. If the intervals of `least_squares` and `power_balance` do not overlap, friction at low speed is
   not the sum of viscous and Coulomb friction, and `power_balance` is preferred.
3. Otherwise `least_squares` is preferred.
4. The preferred method is compared with the other method of steps 2 and 3 and with output error:
   each method predicts strokes that its fit did not use (`method_comparison`). The preferred method
   is used if its prediction error is at most a tenth larger than the smallest one.
5. If these steps do not identify the inertia, or if the encoder's noise decreases their inertia and
   the weak form gives a narrower interval, the weak form estimates the inertia, provided that
   `assess` proposes this method. If no step gives an inertia with a finite interval, output error
   estimates the inertia.

If the bench declares no loads, the Stribeck curve is fitted to the parts at constant speed
(`stribeck_curve`) in two cases: if these parts are more than 70 % of the motion, or if the above
steps do not identify Coulomb friction, as in a staircase of speeds with one stroke in each
direction. If the above steps identify the inertia, the curve is fitted with this inertia. The
result of the above steps is used instead of the curve if friction does not fall with speed, and if
these steps identify viscous and Coulomb friction. Unlike the curve, this result also uses the
samples near the reversals.

Viscous friction is set to 0 if this does not worsen the prediction of strokes that the fit did not
use. An offset that the bench does not declare is set to 0 under the same condition.
"""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.assess.assessment import WANTED
from frictool.identify.assess.assessment_inputs import AssessmentInputs
from frictool.identify.assess.identifiability import (
    STROKE_MEANS,
    WEAK_FORM,
    Identifiability,
    verdict,
)
from frictool.identify.assess.recorded_motion import recorded_facts
from frictool.identify.estimators.explanation_search import search_explanations
from frictool.identify.estimators.power_balance import POWER_BALANCE, by_speed
from frictool.identify.estimators.stribeck_curve import runs_prevail
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.fixed_parameter_refit import bench_with_inertia, refit
from frictool.identify.interval_checks import why_uninformative
from frictool.identify.measurement_faults import refuse_self_explained
from frictool.identify.methods import REFERENCE, IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.effects import declared_effects
from frictool.identify.rows.load_terms import ONLY_OFFSET
from frictool.identify.rows.slip_fit import weighted_fit

STRIBECK_CURVE = "stribeck-curve"
FAR = 0.5  # ratio of half widths, least squares to sines, below which least squares are used
WEAK_DETAILS = ("window", "position_order")
DROPPABLE = ("viscous", "offset")


def auto(records: list[MotionRecord], bench: Bench, settings: IdentificationSettings) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset by the most suitable method.

    The module docstring states how the method is chosen. Raises UnusableLogs if the records have
    too few samples of sliding motion.
    """
    measured = any(record.velocity is not None for record in records)
    undeclared = bench.load in (None, ONLY_OFFSET)
    if not undeclared or measured:
        return _of_strokes(records, bench, settings)
    if runs_prevail(records):
        try:
            return _of_runs(records, bench, settings)
        except UnusableLogs:
            return _of_strokes(records, bench, settings)  # too few parts at constant speed
    strokes = _of_strokes(records, bench, settings)
    if "coulomb" not in strokes.refused:
        return strokes
    try:
        return _of_runs(records, bench, settings, strokes)
    except UnusableLogs:
        return strokes


def _of_strokes(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    measured = any(record.velocity is not None for record in records)
    load, explanations = search_explanations(records, bench, settings)
    explained = bench if load is None else msgspec.structs.replace(bench, load=load)
    fit = _suitable(records, explained, settings)
    inertia = fit.parameters.get("inertia")
    unknown = "inertia" in fit.refused if inertia is None else not np.isfinite(inertia.half_width)
    if unknown and not measured:
        fit = _with_simulated_inertia(fit, records, explained, settings)
    return replace(fit, load=load, explanations=explanations)


def _with_simulated_inertia(
    fit: SlidingFit, records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return `fit` with the inertia estimated by output error, which needs no differentiation.

    The effort of disturbing effects, which the simulation lacks, widens the interval of the
    inertia. An error of the simulated position may also look like a change of the inertia. For this
    error, a relative half width is added: the rms position error, divided by the rms part of the
    motion that only the inertia explains.

    `fit` is returned unchanged if this ratio is 1 or more, if the simulation fails or contradicts
    the friction of `fit`, or if the bench has a load.
    """
    effects = {effect.term for effect in declared_effects(bench)}
    if bench.load is not None and set(bench.load.terms) - effects - {"offset"}:
        return fit
    from frictool.identify.estimators.output_error import OUTPUT_ERROR, simulation_error

    try:
        plain = msgspec.structs.replace(bench, load=None)
        simulated = simulation_error(records, plain, settings, ())
    except UnusableLogs:
        return fit
    motion = simulated.details.get("inertia_motion_rms", math.inf)
    share = simulated.details["residual_rms"] / motion if motion > 0.0 else math.inf
    if share >= 1.0 or disagreement(fit, simulated) is not None:
        return fit
    inertia = simulated.parameters["inertia"]
    half = math.hypot(inertia.half_width, share * inertia.value)
    wider = {**simulated.parameters, "inertia": Interval.around(inertia.value, half)}
    simulated = replace(simulated, parameters=wider)
    return joined(fit, simulated, OUTPUT_ERROR, "the encoder hides the acceleration")


def _suitable(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    declared = bench.load is not None and "offset" in bench.load.terms
    droppable = tuple(name for name in DROPPABLE if name != "offset" or not declared)
    if any(record.velocity is not None for record in records):
        # a measured velocity does not depend on an encoder
        return _differentiated(records, bench, settings, droppable)
    facts = recorded_facts(records, bench)
    inertia = decide_identifiability("inertia", facts)
    friction = decide_identifiability("viscous", facts)
    weak = _weak(records, bench, settings) if inertia.method == WEAK_FORM else None
    if friction.method == STROKE_MEANS and bench.load in (None, ONLY_OFFSET):
        try:
            known = bench if weak is None else bench_with_inertia(bench, weak.parameters["inertia"])
            fit = replace(
                run(STROKE_MEANS, records, known, settings), method=STROKE_MEANS, why=friction.why
            )
            certain = all(np.isfinite(one.half_width) for one in fit.parameters.values())
            if certain and (
                fit.laws is not None or not _more_precise(records, bench, settings, fit)
            ):
                return fit if weak is None else joined(fit, weak, WEAK_FORM, inertia.why)
        except UnusableLogs:
            pass  # not enough strokes or speeds: least squares average over windows instead
    fit = _differentiated(records, bench, settings, droppable)
    own = fit.parameters.get("inertia")
    lost = 0.0 if own is None else fit.attenuation * own.value
    if weak is None or (
        own is not None
        and (lost == 0.0 or own.half_width + lost <= weak.parameters["inertia"].half_width)
    ):
        return fit
    friction_fit = _at_inertia(fit, weak.parameters["inertia"], records, bench, settings)
    return joined(friction_fit, weak, WEAK_FORM, inertia.why)


def _at_inertia(
    fit: SlidingFit,
    inertia: Interval,
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
) -> SlidingFit:
    """Fit the parameters of `fit` again, with the inertia fixed at `inertia`.

    The encoder's noise makes the inertia in `fit` too small, which shifts the other parameters. If
    the new fit fails, `fit` is returned.
    """
    try:
        known = refit(records, bench, settings, fit, {"inertia": inertia})
    except UnusableLogs:
        return fit
    return replace(known, refused=fit.refused | known.refused, details=fit.details, fixed=fit.fixed)


def _more_precise(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings, means: SlidingFit
) -> bool:
    """Return True if the intervals by least squares overlap those of `means`, and are narrower.

    `means` is a fit by the method of sines. The intervals of viscous and Coulomb friction are
    compared. An interval by least squares must be narrower than FAR times the interval of `means`.
    """
    efficient = run(REFERENCE, records, bench, settings)
    narrower = all(
        name in efficient.parameters
        and efficient.parameters[name].half_width < FAR * means.parameters[name].half_width
        for name in ("viscous", "coulomb")
        if name in means.parameters
    )
    return narrower and disagreement(efficient, means) is None


def _of_runs(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    strokes: SlidingFit | None = None,
) -> SlidingFit:
    """Return a Stribeck curve fitted to the parts at constant speed, or the fit of whole strokes.

    `strokes` is the fit of whole strokes (`_of_strokes`), or None if this fit is still to be
    computed. The fit of whole strokes is returned if inertia, viscous friction and Coulomb friction
    are fitted, the interval of the inertia is informative (`why_uninformative`), and friction does
    not fall with speed. Otherwise, the curve is fitted with the inertia of `strokes` if the
    interval of this inertia is informative, else with the inertia in bench.yaml. Raises
    UnusableLogs if the parts do not determine a curve.
    """
    why = (
        "most of the motion consists of runs at constant speed"
        if strokes is None
        else "runs at constant speed determine friction although there are few reversals"
    )
    curve = run(STRIBECK_CURVE, records, bench, settings)
    curve = replace(curve, method=STRIBECK_CURVE, why=f"{why}, which do not show the inertia")
    try:
        strokes = strokes or _of_strokes(records, bench, settings)
    except UnusableLogs:
        return curve
    inertia = strokes.parameters.get("inertia")
    known = why_uninformative("inertia", inertia, bench.mechanics.inertia) if inertia else ""
    if inertia is None or known is not None:
        return curve
    falls = curve.laws is not None or "stribeck_velocity" in curve.refused
    if not falls and {"viscous", "coulomb"} <= strokes.parameters.keys():
        return strokes
    curve = run(STRIBECK_CURVE, records, bench_with_inertia(bench, inertia), settings)
    curve = replace(curve, method=STRIBECK_CURVE, why=why)
    return joined(curve, strokes, strokes.method or REFERENCE, "it follows from the reversals")


def decide_identifiability(parameter: str, facts: AssessmentInputs) -> Identifiability:
    """Return whether, how precisely and by which method the logs can identify a parameter.

    The required relative half width is the smaller of WANTED and the relative half width in
    bench.yaml (1 if bench.yaml states no interval). If the logs cannot reach this precision, the
    half width in bench.yaml is required instead.
    """
    known = facts.known.get(parameter, 1.0)
    first = verdict(parameter, facts, min(WANTED, known))
    return first if first.identifiable else verdict(parameter, facts, known)


def _weak(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit | None:
    """Return the fit by the weak form if its inertia has a positive, finite interval, else None."""
    try:
        fit = run(WEAK_FORM, records, bench, settings)
    except UnusableLogs:
        return None
    inertia = fit.parameters.get("inertia")
    return fit if inertia is not None and inertia.low > 0.0 and np.isfinite(inertia.high) else None


def inertia_over_position(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit | None:
    """Return the weak-form fit if it contains an inertia and friction over position, else None."""
    fit = _weak(records, bench, settings)
    return fit if fit is not None and fit.details["position_order"] > 0 else None


def joined(fit: SlidingFit, other: SlidingFit, method: str, why: str) -> SlidingFit:
    """Return `fit` with the inertia of `other`, a fit by `method`; the text `why` is the reason."""
    refused = {name: reason for name, reason in fit.refused.items() if name != "inertia"}
    inertia = {"inertia": other.parameters["inertia"]}
    details = {name: other.details[name] for name in WEAK_DETAILS if name in other.details}
    shape = f"; {other.why}" if other.why else ""
    return replace(
        fit,
        parameters=inertia | fit.parameters | inertia,
        refused=refused,
        attenuation=other.attenuation,
        details={**fit.details, **details},
        why=f"{fit.why}. inertia by {method}: {why}{shape}",
    )


def _differentiated(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    droppable: tuple[str, ...],
) -> SlidingFit:
    efficient = weighted_fit(
        records, bench, settings, lambda rows: np.ones(rows.velocity.size), droppable
    )
    robust = weighted_fit(records, bench, settings, by_speed)
    apart = disagreement(efficient, robust)
    if apart is None:
        why = "least squares with equal weights and with weights by speed agree"
        fits = [replace(efficient, method=REFERENCE, why=why)]
    else:
        why = (
            f"a fit with equal weights gives {apart}, outside the interval of the fit with weights "
            "by speed: at low speed, friction is not the sum of viscous and Coulomb friction"
        )
        fits = [
            replace(robust, method=POWER_BALANCE, why=why),
            replace(efficient, method=REFERENCE, why=why),
        ]
    # after the comparison of methods, a computed effort could no longer be recognised
    refuse_self_explained(fits[0], records)
    from frictool.identify.estimators.method_comparison import ComparedData, best_by_prediction

    return best_by_prediction(ComparedData(records, bench, settings, fits))


def disagreement(one: SlidingFit, other: SlidingFit) -> str | None:
    """Return name and value of the first parameter on which two fits disagree, as text.

    Two fits disagree if their intervals of viscous or of Coulomb friction do not overlap. The text
    contains the value in `one`. Return None if the fits agree.
    """
    for name in ("viscous", "coulomb"):
        a, b = one.parameters.get(name), other.parameters.get(name)
        if a is not None and b is not None and (a.low > b.high or b.low > a.high):
            return f"{name} {a.value:.4g}"
    return None
