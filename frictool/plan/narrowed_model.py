"""Bench and model whose a-priori ranges are replaced by the intervals from logs."""

from __future__ import annotations

from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.quantity import FROM_LOGS, Quantity

NARROWED = ("inertia", "viscous", "coulomb", "breakaway", "offset")


def narrowed_bench(bench: Bench, model: Model) -> Bench:
    """Return the bench with its a-priori ranges replaced by the intervals from the logs."""
    from_logs = {
        name: Quantity(one.value, low=one.interval[0], high=one.interval[1], unit=one.unit)
        for name in NARROWED
        if (one := getattr(model.parameters, name)).source in FROM_LOGS
    }
    return structs.replace(bench, mechanics=structs.replace(bench.mechanics, **from_logs))


def narrowed_model(model: Model) -> Model:
    """Return the model with a narrowed bench, so that all its plants agree with the logs."""
    return structs.replace(model, bench=narrowed_bench(model.bench, model))


def exact_model(model: Model) -> Model:
    """Return the narrowed model, in which identified parameters have a value but no interval."""
    exact = {
        name: structs.replace(one, low=one.value, high=one.value)
        for name in NARROWED
        if (one := getattr(model.parameters, name)).source == "identified"
    }
    parameters = structs.replace(model.parameters, **exact)
    return narrowed_model(structs.replace(model, parameters=parameters))
