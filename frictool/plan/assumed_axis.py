"""Model of an axis with assumed parameters, for the simulation of a test."""

from __future__ import annotations

from collections.abc import Mapping

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.model import Model, Parameters
from frictool.documents.provenance import provenance_of_call
from frictool.documents.quantity import Estimate
from frictool.identify.model_document import unit_of


def assumed_axis(bench: Bench, values: Mapping[str, float], laws: Laws | None = None) -> Model:
    """Return the model of an axis on the bench with the parameters `values` [SI] and `laws`."""
    parameters = Parameters(
        **{
            name: Estimate(value, value, value, unit_of(name, bench), source="assumed")
            for name, value in values.items()
        }
    )
    return Model(
        format="model/1",
        name=bench.name,
        axis=bench.axis,
        law=parameters.law,
        method="none",
        confidence=0.95,
        bench=bench,
        parameters=parameters,
        provenance=provenance_of_call("frictool.plan.assumed_axis"),
        not_identified={},
        laws=laws,
    )
