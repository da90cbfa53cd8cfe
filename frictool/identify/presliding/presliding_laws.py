"""Fit of all presliding laws to one set of loops, and choice of the best law."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import msgspec

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.presliding import Contact, MaxwellSlip, Preisach, Presliding
from frictool.documents.quantity import Estimate, si_unit
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.presliding.elasto_plastic import elasto_plastic
from frictool.identify.presliding.loops import PreslidingLoops, find_loops
from frictool.identify.presliding.lugre import lugre
from frictool.identify.presliding.maxwell import MaxwellFit, maxwell
from frictool.identify.presliding.path_fit import PreslidingFit
from frictool.identify.presliding.preisach import EverettTable, preisach

T = TypeVar("T", PreslidingFit, MaxwellFit, EverettTable)
LARGEST_ERROR = 0.1  # largest error on branches outside the fit, relative to the breakaway


def presliding(
    records: list[MotionRecord],
    breakaway: Interval,
    inertia: float,
    bench: Bench,
    confidence: float,
) -> Presliding:
    """Return the presliding laws, fitted to effort loops in which the axis never slips.

    - breakaway: interval of the breakaway, N m | N
    - inertia: inertia of the axis, kg m^2 | kg

    Raises UnusableLogs if the loops determine no law.
    """
    loops = find_loops(records, breakaway)
    fits: dict[str, Any] = {}
    refused: dict[str, str] = {}
    for name, law in LAWS.items():
        try:
            fits[name] = _checked(law.fit(loops, confidence))
        except UnusableLogs as error:
            refused[name] = str(error)
    errors = {name: fit.held_out for name, fit in fits.items() if LAWS[name].predicts}
    if not errors:
        reasons = "; ".join(
            f"{name}: {refused[name]}" for name, law in LAWS.items() if law.predicts
        )
        raise UnusableLogs(
            f"no law of presliding fits these loops (the axis must not slip): {reasons}"
        )
    best: Any = min(errors, key=lambda name: errors[name])
    stiffness, limit = fits[best].stiffness, fits[best].limit
    if limit is None:
        limit = Interval(
            breakaway.value / stiffness.value,
            breakaway.low / stiffness.high,
            breakaway.high / stiffness.low,
        )
    return Presliding(
        best,
        limit.estimate("position", bench.axis),
        stiffness.estimate("stiffness", bench.axis),
        breakaway.estimate("effort", bench.axis),
        refused=refused,
        **{name: LAWS[name].document(fit, inertia, bench) for name, fit in fits.items()},
    )


def _checked(fit: T) -> T:
    if isinstance(fit, PreslidingFit | MaxwellFit) and fit.held_out > LARGEST_ERROR:
        raise UnusableLogs(
            f"the force error on branches that the fit did not use is {100.0 * fit.held_out:.3g} % "
            f"of the breakaway (allowed: at most {100 * LARGEST_ERROR:g} %)"
        )
    if isinstance(fit, MaxwellFit) and not (fit.limit.low > 0.0 and fit.stiffness.low > 0.0):
        raise UnusableLogs(
            f"the presliding distance z_max is not determined: its interval [{fit.limit.low:.3g}, "
            f"{fit.limit.high:.3g}] rad or m contains zero; record more loops"
        )
    return fit


def _contact(fit: PreslidingFit, inertia: float, bench: Bench) -> Contact:
    stiffness = fit.stiffness
    start = Estimate(
        2.0 * math.sqrt(inertia * stiffness.value),
        unit=si_unit("viscous", bench.axis),
        source="assumed",
    )
    elastic = (
        fit.parameters[1].estimate("position", bench.axis) if len(fit.parameters) > 1 else None
    )
    return Contact(
        stiffness.estimate("stiffness", bench.axis), start, fit.force_error, fit.held_out, elastic
    )


def _maxwell(fit: MaxwellFit, inertia: float, bench: Bench) -> MaxwellSlip:
    force, low, high = (
        tuple(getattr(one, name) for one in fit.force) for name in ("value", "low", "high")
    )
    displacement = tuple(float(d) for d in fit.displacement)
    return MaxwellSlip(
        fit.stiffness.estimate("stiffness", bench.axis),
        displacement,
        force,
        low,
        high,
        fit.force_error,
        fit.held_out,
    )


def _preisach(fit: EverettTable, inertia: float, bench: Bench) -> Preisach:
    table, half = (
        tuple(tuple(float(x) for x in row) for row in matrix)
        for matrix in (fit.everett, fit.half_width)
    )
    return Preisach(
        fit.limit.estimate("position", bench.axis),
        fit.saturation.estimate("effort", bench.axis),
        table,
        half,
    )


class PreslidingLaw(NamedTuple):
    """Functions for a presliding law.

    - fit: function of loops and confidence that returns the fitted law
    - document: function of fitted law, inertia and bench that returns the law for the model
      document
    - predicts: True if the law can predict branches that the fit did not use. Among these laws, the
      law with the smallest prediction error is the best.
    """

    fit: Callable[[PreslidingLoops, float], Any]
    document: Callable[[Any, float, Bench], Any]
    predicts: bool = True


LAWS = {
    "lugre": PreslidingLaw(lugre, _contact),
    "elasto_plastic": PreslidingLaw(elasto_plastic, _contact),
    "maxwell_slip": PreslidingLaw(maxwell, _maxwell),
    "preisach": PreslidingLaw(preisach, _preisach, predicts=False),
}


def with_presliding(model: Model, records: list[MotionRecord]) -> Model:
    """Return the model with presliding laws, or with the reason why no law was fitted."""
    today = model.parameters
    breakaway = Interval(today.breakaway.value, *today.breakaway.interval)
    try:
        return msgspec.structs.replace(
            model,
            presliding=presliding(
                records, breakaway, today.inertia.value, model.bench, model.confidence
            ),
        )
    except UnusableLogs as error:
        return msgspec.structs.replace(
            model, not_identified={**model.not_identified, "presliding": str(error)}
        )
