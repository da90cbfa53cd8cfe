"""Fit of all presliding laws to one set of loops, and choice of the best law."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

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
LARGEST_ERROR = 0.1  # largest error of a law on unseen branches, relative to the breakaway


def presliding(
    records: list[MotionRecord],
    breakaway: Interval,
    inertia: float,
    bench: Bench,
    confidence: float,
) -> Presliding:
    """Return the presliding laws of loops that never slip.

    The breakaway is in N m | N. Raises UnusableLogs if the loops determine no law.
    """
    loops = find_loops(records, breakaway)
    refused: dict[str, str] = {}
    one = _tried("lugre", lugre, loops, confidence, refused)
    two = _tried("elasto_plastic", elasto_plastic, loops, confidence, refused)
    three = _tried("maxwell_slip", maxwell, loops, confidence, refused)
    four = _tried("preisach", preisach, loops, confidence, refused)
    errors = {
        name: fit.held_out
        for name, fit in (("lugre", one), ("elasto_plastic", two), ("maxwell_slip", three))
        if fit is not None
    }
    if not errors:
        reasons = "; ".join(
            f"{name}: {reason}" for name, reason in refused.items() if name != "preisach"
        )
        raise UnusableLogs(
            f"no law of presliding suits these loops (does the axis slip in them?): {reasons}"
        )
    # one of the three laws of the document
    law: Any = min(errors, key=lambda name: errors[name])
    if law == "maxwell_slip":
        assert isinstance(three, MaxwellFit)
        stiffness, limit = three.stiffness, three.limit
    else:
        fit = one if law == "lugre" else two
        assert isinstance(fit, PreslidingFit)
        stiffness = fit.parameters[0]
        limit = Interval(
            breakaway.value / stiffness.value,
            breakaway.low / stiffness.high,
            breakaway.high / stiffness.low,
        )
    return Presliding(
        law,
        _estimate(limit, "position", bench),
        _estimate(stiffness, "stiffness", bench),
        _estimate(breakaway, "effort", bench),
        None if one is None else _contact(one, inertia, bench),
        None if two is None else _contact(two, inertia, bench),
        None if three is None else _maxwell(three, bench),
        None if four is None else _preisach(four, bench),
        refused,
    )


def _tried(
    name: str,
    method: Callable[[PreslidingLoops, float], T],
    loops: PreslidingLoops,
    confidence: float,
    refused: dict[str, str],
) -> T | None:
    """Return the result of the method, or None with the reason added to `refused`."""
    try:
        found = method(loops, confidence)
    except UnusableLogs as error:
        refused[name] = str(error)
        return None
    if isinstance(found, PreslidingFit | MaxwellFit) and found.held_out > LARGEST_ERROR:
        refused[name] = (
            f"on branches not seen it is off by {100.0 * found.held_out:.3g} % of the breakaway "
            f"(allowed: {100 * LARGEST_ERROR:g} %)"
        )
        return None
    if isinstance(found, MaxwellFit) and not (found.limit.low > 0.0 and found.stiffness.low > 0.0):
        refused[name] = (
            f"z_max is not told: its interval [{found.limit.low:.3g}, {found.limit.high:.3g}] "
            "reaches zero"
        )
        return None
    return found


def _contact(fit: PreslidingFit, inertia: float, bench: Bench) -> Contact:
    stiffness = fit.parameters[0]
    start = Estimate(
        2.0 * math.sqrt(inertia * stiffness.value),
        unit=si_unit("viscous", bench.axis),
        source="assumed",
    )
    elastic = _estimate(fit.parameters[1], "position", bench) if len(fit.parameters) > 1 else None
    return Contact(
        _estimate(stiffness, "stiffness", bench), start, fit.force_error, fit.held_out, elastic
    )


def _maxwell(found: MaxwellFit, bench: Bench) -> MaxwellSlip:
    force, low, high = (
        tuple(getattr(one, name) for one in found.force) for name in ("value", "low", "high")
    )
    displacement = tuple(float(d) for d in found.displacement)
    return MaxwellSlip(
        _estimate(found.stiffness, "stiffness", bench),
        displacement,
        force,
        low,
        high,
        found.force_error,
        found.held_out,
    )


def _preisach(found: EverettTable, bench: Bench) -> Preisach:
    table, half = (
        tuple(tuple(float(x) for x in row) for row in matrix)
        for matrix in (found.everett, found.half_width)
    )
    return Preisach(
        _estimate(found.limit, "position", bench),
        _estimate(found.saturation, "effort", bench),
        table,
        half,
    )


def _estimate(found: Interval, dimension: str, bench: Bench) -> Estimate:
    return Estimate(
        found.value, found.low, found.high, si_unit(dimension, bench.axis), source="identified"
    )


def with_presliding(model: Model, records: list[MotionRecord]) -> Model:
    """Return the model with presliding laws, or with the reason why there are none."""
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
