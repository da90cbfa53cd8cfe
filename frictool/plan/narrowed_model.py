"""Bench and model in which intervals from logs replace the a-priori ranges."""

from __future__ import annotations

from typing import TypeVar

from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.laws import Gravity, Load, Ripple
from frictool.documents.model import Model
from frictool.documents.quantity import FROM_LOGS, Estimate, Quantity
from frictool.identify.model_document import BREAKAWAY_RATIO, LARGEST_BREAKAWAY_RATIO

Term = TypeVar("Term", Gravity, Ripple)

NARROWED = ("inertia", "viscous", "coulomb", "breakaway", "offset")


def narrowed_bench(bench: Bench, model: Model) -> Bench:
    """Return the bench with its a-priori ranges replaced by the intervals from the logs."""
    from_logs = {
        name: Quantity(one.value, low=one.interval[0], high=one.interval[1], unit=one.unit)
        for name in NARROWED
        if (one := getattr(model.parameters, name)).source in FROM_LOGS
    }
    return structs.replace(bench, mechanics=structs.replace(bench.mechanics, **from_logs))


def bench_for_test(bench: Bench, model: Model) -> Bench:
    """Return the narrowed bench for the design of a test.

    If the logs show the breakaway and not the Coulomb friction, the range of the Coulomb friction
    is limited: from the breakaway divided by LARGEST_BREAKAWAY_RATIO to the breakaway.
    """
    narrowed = narrowed_bench(bench, model)
    known, breakaway = narrowed.mechanics.coulomb, model.parameters.breakaway
    if breakaway.source not in FROM_LOGS or model.parameters.coulomb.source in FROM_LOGS:
        return narrowed
    low = max(known.interval[0], breakaway.interval[0] / LARGEST_BREAKAWAY_RATIO)
    high = min(known.interval[1], breakaway.interval[1])
    if low >= high:
        return narrowed  # the bench contradicts this ratio
    value = min(max(breakaway.value / BREAKAWAY_RATIO, low), high)
    coulomb = Quantity(value, low=low, high=high, unit=known.unit)
    return structs.replace(narrowed, mechanics=structs.replace(narrowed.mechanics, coulomb=coulomb))


def narrowed_model(model: Model) -> Model:
    """Return the model with a narrowed bench, so that all its plants agree with the logs."""
    return structs.replace(model, bench=narrowed_bench(model.bench, model))


def exact_model(model: Model) -> Model:
    """Return the model with exact values, from the logs or the bench, in place of intervals.

    The load over the position has exact values, too. If neither the logs nor the bench state the
    breakaway, its assumed value is used.
    """
    exact = {
        name: structs.replace(one, low=one.value, high=one.value)
        for name in NARROWED
        if (one := getattr(model.parameters, name)).source in (*FROM_LOGS, "bench")
        or name == "breakaway"
    }
    mechanics = {name: Quantity(one.value, unit=one.unit) for name, one in exact.items()}
    bench = structs.replace(
        model.bench, mechanics=structs.replace(model.bench.mechanics, **mechanics)
    )
    parameters = structs.replace(model.parameters, **exact)
    laws = model.laws
    if laws is not None and laws.load is not None:
        laws = structs.replace(laws, load=_exact_load(laws.load))
    return structs.replace(model, parameters=parameters, bench=bench, laws=laws)


def _exact_load(load: Load) -> Load:
    return Load(
        None if load.stiffness is None else _exact_value(load.stiffness),
        None if load.gravity is None else _exact(load.gravity),
        None if load.ripple is None else _exact(load.ripple),
        tuple(map(_exact, load.harmonics)),
    )


def _exact(term: Term) -> Term:
    return structs.replace(term, sine=_exact_value(term.sine), cosine=_exact_value(term.cosine))


def _exact_value(one: Estimate) -> Estimate:
    return structs.replace(one, low=one.value, high=one.value)
