"""The model document of an identification: what no log gave carries the bench's interval, or else
an assumption, and says which."""

from __future__ import annotations

from dataclasses import replace

from msgspec.structs import replace as with_fields

from frictool.documents.bench import Bench
from frictool.documents.model import Fit as FitSummary
from frictool.documents.model import Model, Parameters
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Estimate, Quantity, si_unit
from frictool.identify.fit_result import CURVE, DIMENSIONS, PARAMETERS
from frictool.identify.identification import Identification, NothingIdentified

BREAKAWAY_RATIO, LARGEST_BREAKAWAY_RATIO = (
    1.1,
    1.5,
)  # over Coulomb friction where nothing is known: beta of table 4.8; of table 4.1


def model_of(result: Identification, bench: Bench, provenance: Provenance) -> Model:
    """`model.yaml` of `result`, the bench copied verbatim."""
    estimates = {name: _estimate(name, result, bench) for name in PARAMETERS if name != "breakaway"}
    estimates["breakaway"] = _breakaway(result, bench, estimates["coulomb"])
    estimates |= {
        name: _estimate(name, result, bench) for name in CURVE if name in result.identified
    }
    fit = result.fit
    summary = None if fit is None else FitSummary(fit.force_error, fit.condition, fit.samples)
    return Model(
        format="model/1",
        name=bench.name,
        axis=bench.axis,
        law="stribeck" if "stribeck_velocity" in estimates else "coulomb",
        method=result.method,
        confidence=result.confidence,
        bench=bench,
        parameters=Parameters(**estimates),
        provenance=provenance,
        not_identified=result.refused,
        fit=summary,
        laws=result.laws,
    )


def bench_model(refused: NothingIdentified, bench: Bench, provenance: Provenance) -> Model:
    """Return the model that holds the bench's values only, with the reason."""
    model = model_of(replace(refused.result, identified={}, laws=None, fit=None), bench, provenance)
    return with_fields(model, bench_values_only=str(refused))


def unit_of(name: str, bench: Bench) -> str:
    """The SI unit of a parameter on this axis."""
    return si_unit(DIMENSIONS[name], bench.axis)


def _estimate(name: str, result: Identification, bench: Bench) -> Estimate:
    found = result.identified.get(name)
    if found is not None:
        return Estimate(
            found.value, found.low, found.high, unit_of(name, bench), source="identified"
        )
    known: Quantity | None = getattr(bench.mechanics, name)
    if known is None:
        return Estimate(
            0.0, unit=unit_of(name, bench), source="assumed"
        )  # only the offset: the bench has to give the others
    return Estimate(known.value, known.low, known.high, unit_of(name, bench), source="bench")


def _breakaway(result: Identification, bench: Bench, coulomb: Estimate) -> Estimate:
    """Identified, else the bench's, else what Coulomb friction lets expect: 1 to 1.5 times its
    interval."""
    if "breakaway" in result.identified or bench.mechanics.breakaway is not None:
        return _estimate("breakaway", result, bench)
    low, high = coulomb.interval
    return Estimate(
        BREAKAWAY_RATIO * coulomb.value,
        low,
        LARGEST_BREAKAWAY_RATIO * high,
        unit_of("breakaway", bench),
        source="assumed",
    )
