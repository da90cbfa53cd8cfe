"""Choice of the method by the decision scheme of figure 4.4 (assess/identifiability.py), applied to
the recorded motion.

    1  assess refuses the velocity by differentiation                                                             sines
    2  the efficient estimate (`least_squares`) and the robust one (`power_balance`) disagree by
    more than their
       intervals: friction is not viscous + Coulomb over all speeds, and the slow samples tell something else     prefer
                                                                                                                  power-balance
    3  else the efficient one, alone                                                                              prefer
                                                                                                                  least-squares
    4  of 2 or 3, with the terms that the simulation asks for, and of output error: the best by what
    its model
       predicts of strokes that it has not seen; the preferred one stays within a tenth
       (`comparison`)
    5  assess gives the inertia to the weak form, and 1 to 4 do not give it: its value is the weak
    form's

Step 2 is Hausman's test, read off intervals. Viscous friction, and an offset that the bench does
not declare, are dropped where strokes that the fit has not seen are predicted no worse without
them. Steps 2 and 3 apply to strokes of any other form too.
"""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Quantity
from frictool.identify.assess.assessment import WANTED
from frictool.identify.assess.assessment_inputs import AssessmentInputs
from frictool.identify.assess.identifiability import Identifiability, verdict
from frictool.identify.assess.recorded_motion import recorded_facts
from frictool.identify.estimators.load_search import with_found_loads
from frictool.identify.estimators.power_balance import by_speed
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.measurement_faults import refuse_self_explained
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.slip_fit import weighted_fit

DROPPABLE = ("viscous", "offset")
ONLY_OFFSET = LoadTerms(("offset",))  # nothing that the method of sines does not know


def auto(records: list[MotionRecord], bench: Bench, settings: IdentificationSettings) -> SlidingFit:
    """Inertia, viscous, Coulomb and offset by the method that suits the records. Raises
    UnusableLogs where nothing moves enough."""
    declared = bench.load is not None and "offset" in bench.load.terms
    droppable = tuple(name for name in DROPPABLE if name != "offset" or not declared)
    if any(record.velocity is not None for record in records):
        return _differentiated(
            records, bench, settings, droppable
        )  # what a measured velocity tells, no encoder decides
    bench = with_found_loads(records, bench, settings)
    facts = recorded_facts(records, bench)
    inertia, friction = (
        decide_identifiability("inertia", facts),
        decide_identifiability("viscous", facts),
    )
    weak = _weak(records, bench, settings) if inertia.method == "weak" else None
    if friction.method == "sines" and bench.load in (None, ONLY_OFFSET):
        try:
            known = bench if weak is None else with_inertia(bench, weak.parameters["inertia"])
            fit = replace(run("sines", records, known, settings), method="sines", why=friction.why)
            return fit if weak is None else joined(fit, weak, inertia.why)
        except UnusableLogs:
            pass  # no strokes of several speeds: least squares averages over windows what it can
    fit = _differentiated(records, bench, settings, droppable)
    return fit if weak is None or "inertia" in fit.parameters else joined(fit, weak, inertia.why)


def decide_identifiability(parameter: str, facts: AssessmentInputs) -> Identifiability:
    """`assess`'s verdict at the precision that it wants, or else at one that is better than what
    the bench knows (4.2.1)."""
    known = facts.known.get(parameter, 1.0)
    first = verdict(parameter, facts, min(WANTED, known))
    return first if first.identifiable else verdict(parameter, facts, known)


def _weak(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit | None:
    """The weak form, where it gives the inertia."""
    try:
        fit = run("weak", records, bench, settings)
    except UnusableLogs:
        return None
    inertia = fit.parameters.get("inertia")
    return fit if inertia is not None and inertia.low > 0.0 and np.isfinite(inertia.high) else None


def inertia_over_position(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit | None:
    """The weak form where it sees that friction varies with the position, and gives the inertia all
    the same."""
    fit = _weak(records, bench, settings)
    return fit if fit is not None and fit.details["position_order"] > 0 else None


def with_inertia(bench: Bench, found: Interval) -> Bench:
    """The bench that knows the inertia as it was found."""
    inertia = Quantity(found.value, found.low, found.high, bench.mechanics.inertia.unit)
    return msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, inertia=inertia)
    )


def joined(fit: SlidingFit, weak: SlidingFit, why: str) -> SlidingFit:
    """`fit` with the inertia of the weak form."""
    refused = {name: reason for name, reason in fit.refused.items() if name != "inertia"}
    parameters = {"inertia": weak.parameters["inertia"], **fit.parameters}
    details = {
        **fit.details,
        "window": weak.details["window"],
        "position_order": weak.details["position_order"],
    }
    shape = f"; {weak.why}" if weak.why else ""
    return replace(
        fit,
        parameters=parameters,
        refused=refused,
        details=details,
        why=f"{fit.why}. inertia by weak: {why}{shape}",
    )


def _differentiated(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    droppable: tuple[str, ...],
) -> SlidingFit:
    """Steps 2 to 4."""
    efficient = weighted_fit(
        records, bench, settings, lambda rows: np.ones(rows.velocity.size), droppable
    )
    robust = weighted_fit(records, bench, settings, by_speed)
    apart = disagreement(efficient, robust)
    if apart is None:
        why = "equal weights and weights by speed agree within their intervals: friction is viscous and Coulomb at all speeds used"
        fits = [replace(efficient, method="least-squares", why=why)]
    else:
        why = f"{apart} with equal weights is outside what weights by speed give: friction differs at low speed, where samples count less"
        fits = [
            replace(robust, method="power-balance", why=why),
            replace(efficient, method="least-squares", why=why),
        ]
    refuse_self_explained(
        fits[0], records
    )  # after a choice by simulation, `refusals` could not recognise a computed effort
    from frictool.identify.estimators.method_comparison import ComparedData, best_by_prediction

    return best_by_prediction(ComparedData(records, bench, settings, fits))


def disagreement(one: SlidingFit, other: SlidingFit) -> str | None:
    """The first parameter of friction whose intervals have nothing in common, for people; None
    where all agree."""
    for name in ("viscous", "coulomb"):
        a, b = one.parameters.get(name), other.parameters.get(name)
        if a is not None and b is not None and (a.low > b.high or b.low > a.high):
            return f"{name} {a.value:.4g}"
    return None
