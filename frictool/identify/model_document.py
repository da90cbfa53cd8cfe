"""Model document of an identification.

A parameter that is not identified has the interval in bench.yaml, possibly narrowed by the logs. If
bench.yaml states no interval, an interval is assumed. The key `source` of a parameter states the
origin of its interval.
"""

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
from frictool.identify.unmodelled_effects import SLOW_FRICTION

# assumed ratio of breakaway to Coulomb friction: expected value (beta of table 4.8) and upper
# bound (table 4.1)
BREAKAWAY_RATIO, LARGEST_BREAKAWAY_RATIO = (1.1, 1.5)


def model_of(result: Identification, bench: Bench, provenance: Provenance) -> Model:
    """Return the model document of an identification, with a copy of the bench."""
    estimates = {name: _estimate(name, result, bench) for name in PARAMETERS if name != "breakaway"}
    estimates["breakaway"] = _breakaway(result, bench, estimates["coulomb"])
    estimates |= {
        name: _estimate(name, result, bench) for name in CURVE if name in result.identified
    }
    fit = result.fit
    parameters = Parameters(**estimates)
    laws = result.laws
    if laws is not None and laws.load is not None and "offset" not in result.identified:
        laws = with_fields(laws, load=with_fields(laws.load, total=None))  # of the fitted offset
    summary = None if fit is None else FitSummary(fit.force_error, fit.condition, fit.samples)
    return Model(
        format="model/1",
        name=bench.name,
        axis=bench.axis,
        law=parameters.law,
        method=result.method,
        confidence=result.confidence,
        bench=bench,
        parameters=parameters,
        provenance=provenance,
        not_identified=dict(result.refused),
        fit=summary,
        laws=laws,
        logged_positions=None if bench.mechanics.travel is None else result.logged,
        valid_side=None if result.kink is None else result.kink.valid_side(bench.axis),
    )


def bench_model(refused: NothingIdentified, bench: Bench, provenance: Provenance) -> Model:
    """Return a model with the values in bench.yaml, and the reason why nothing was identified."""
    without = replace(refused.result, identified={}, laws=None, fit=None, kink=None)
    model = model_of(without, bench, provenance)
    return with_fields(model, bench_values_only=str(refused))


def unit_of(name: str, bench: Bench) -> str:
    """Return the SI unit of a parameter on the axis of `bench`."""
    return si_unit(DIMENSIONS[name], bench.axis)


def _estimate(name: str, result: Identification, bench: Bench) -> Estimate:
    interval = result.identified.get(name)
    if interval is not None:
        return interval.estimate(DIMENSIONS[name], bench.axis)
    inside = result.narrowed.get(name)
    if inside is not None:
        ends = inside.value, inside.low, inside.high
        return Estimate(*ends, unit_of(name, bench), source="log and bench")
    known: Quantity | None = getattr(bench.mechanics, name)
    if known is None:
        # only the offset can be missing: the bench always states the other parameters
        return Estimate(0.0, unit=unit_of(name, bench), source="assumed")
    return Estimate(known.value, known.low, known.high, unit_of(name, bench), source="bench")


def _breakaway(result: Identification, bench: Bench, coulomb: Estimate) -> Estimate:
    if "breakaway" in result.identified or bench.mechanics.breakaway is not None:
        return _estimate("breakaway", result, bench)
    low, high = coulomb.interval
    slow = None if result.fit is None else result.fit.details.get(SLOW_FRICTION)
    if slow is not None:  # the friction at low speed is below the fitted line
        low = max(min(low, slow - (coulomb.value - low)), 0.0)
    return Estimate(
        BREAKAWAY_RATIO * coulomb.value,
        low,
        LARGEST_BREAKAWAY_RATIO * high,
        unit_of("breakaway", bench),
        source="assumed",
    )
