"""Second fit, in which the refused parameters are fixed at the values that the model states.

A parameter is refused if the logs do not determine it. The model then contains a value from the
range in bench.yaml. This value may differ from the value of the first fit. The other parameters are
therefore fitted again with the refused parameter fixed at the model's value. Their intervals are
widened by the interval of the refused parameter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import msgspec

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify import methods
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit
from frictool.identify.motion_record import MotionRecord
from frictool.identify.outcome import Outcome
from frictool.identify.rows.load_terms import terms_of


def fixed_parameters(fit: SlidingFit, outcome: Outcome, bench: Bench) -> dict[str, Interval]:
    """Return the model's interval for each parameter that was fitted and then refused.

    This interval is the intersection of the range in bench.yaml and the logs' interval, or the
    range in bench.yaml if they do not overlap. Parameters that the motion cannot separate are
    excluded. An inertia that the encoder is too coarse to identify is excluded too, because its
    error hardly changes the other parameters.
    """
    # if Coulomb friction differs by direction, coulomb and offset are its mean and half difference
    split = bench.load is not None and "coulomb_by_direction" in bench.load.terms
    out = {}
    for name in SLIDING[:2] if split else SLIDING:
        known: Quantity | None = getattr(bench.mechanics, name)
        if (
            name in fit.parameters
            and name not in outcome.identified
            and known is not None
            and known.low is not None
        ):
            out[name] = outcome.narrowed.get(name) or Interval(known.value, *known.interval)
    return out


def refit(
    records: list[MotionRecord],
    bench: Bench,
    settings: methods.IdentificationSettings,
    fit: SlidingFit,
    fixed: Mapping[str, Interval],
) -> SlidingFit:
    """Repeat the fit of the parameters that are not in `fixed`, with the method and loads of `fit`.

    The values in `fixed` are not changed. A parameter that `auto` set to 0 stays 0. An inertia that
    `auto` took from another method is kept. Raises UnusableLogs if the method cannot use the
    records.
    """
    assert fit.method is not None
    fixed_settings = with_held(settings, fit, fixed)
    inertia = fit.parameters.get("inertia")
    row = methods.METHODS[fit.method]
    if row.known_inertia and inertia is not None and "inertia" not in fixed:
        bench = bench_with_inertia(bench, inertia)
    if fit.load is not None:
        bench = msgspec.structs.replace(bench, load=fit.load)
    again = row.refit(records, bench, fixed_settings, terms_of(fit.laws))
    kept = {"inertia": inertia} if inertia is not None and "inertia" not in fixed else {}
    parameters = {
        **kept,
        **{name: one for name, one in fixed_settings.fixed.items() if name not in fixed},
        **again.parameters,
    }
    details = {
        **fit.details,
        **again.details,
        **{f"fixed_{name}": interval.value for name, interval in fixed.items()},
    }
    return replace(
        again,
        parameters=parameters,
        details=details,
        method=fit.method,
        why=fit.why,
        tried=fit.tried,
        dropped=fit.dropped,
        fixed=dict(fixed),
        load=fit.load,
        explanations=fit.explanations,
    )


def with_held(
    settings: methods.IdentificationSettings, fit: SlidingFit, fixed: Mapping[str, Interval]
) -> methods.IdentificationSettings:
    """Return settings that fix the parameters in `fixed`, and those that `fit` set to 0."""
    dropped = {name: fit.parameters[name] for name in fit.dropped if name in fit.parameters}
    return replace(settings, fixed={**dropped, **fixed})


def bench_with_inertia(bench: Bench, inertia: Interval) -> Bench:
    """Return the bench with its inertia replaced by `inertia`."""
    known = Quantity(inertia.value, inertia.low, inertia.high, bench.mechanics.inertia.unit)
    mechanics = msgspec.structs.replace(bench.mechanics, inertia=known)
    return msgspec.structs.replace(bench, mechanics=mechanics)
