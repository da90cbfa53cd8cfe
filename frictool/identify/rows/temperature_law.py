"""Friction over temperature from the fitted effect `temperature`.

The regression gives the slope c of a friction F over temperature, at the reference temperature. The
model document contains the relative slope c/F. The interval of c/F includes the uncertainty of F:
with the half widths c_h of c and F_h of F, the half width of c/F is sqrt(c_h^2 + (c F_h/F)^2)/F.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import FrictionOverTemperature, Laws, TemperatureChange
from frictool.documents.quantity import Quantity, Span
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.effects import TEMPERATURE, TEMPERATURE_NAMES, missing_temperature

LEAST_RANGE = 5.0  # K, least range of temperatures over which a change of friction is fitted


def temperatures(records: Sequence[MotionRecord]) -> FrictionOverTemperature | None:
    """Return the reference and the range of the records' temperatures.

    Return None if there are no records, or if a record has no temperature.
    """
    measured = [one.temperature for one in records if one.temperature is not None]
    if not measured or len(measured) < len(records):
        return None
    low = min(float(one.values.min()) for one in measured)
    high = max(float(one.values.max()) for one in measured)
    reference = measured[0].reference  # the same for all logs of the axis
    span = Span(min(low, reference), max(high, reference), "degC")
    return FrictionOverTemperature(Quantity(reference, unit="degC"), span)


def varies(law: FrictionOverTemperature | None) -> bool:
    """Return whether the temperature range of `law` is large enough to fit a change of friction."""
    return law is not None and law.over.high - law.over.low >= LEAST_RANGE


def refuse_unknown_temperature(records: Sequence[MotionRecord], bench: Bench) -> None:
    """Raise UnusableLogs if the records cannot show the declared effect `temperature`.

    The effect needs a temperature in every record, and a range of at least LEAST_RANGE.
    """
    if bench.load is None or TEMPERATURE not in bench.load.terms or not records:
        return
    for record in records:
        if record.temperature is None:
            raise UnusableLogs(missing_temperature(record))
    law = temperatures(records)
    if law is not None and not varies(law):
        low, high = law.over.low, law.over.high
        raise UnusableLogs(
            f"the temperature varies by {high - low:.3g} K ({low:.4g} to {high:.4g} degC), and "
            f"the effect temperature needs {LEAST_RANGE:g} K; add a log at another temperature"
        )


def with_temperature_law(fit: SlidingFit, records: Sequence[MotionRecord]) -> SlidingFit:
    """Add a law of friction over temperature to a fit that contains the effect `temperature`."""
    law = temperatures(records)
    slope, dry, curvature = (fit.effects.get(name) for name in TEMPERATURE_NAMES)
    if law is None or (slope is None and dry is None):
        return fit
    law = msgspec.structs.replace(
        law,
        viscous=_change(fit.parameters.get("viscous"), slope, curvature),
        coulomb=_change(fit.parameters.get("coulomb"), dry, None),
    )
    return replace(fit, laws=msgspec.structs.replace(fit.laws or Laws(), temperature=law))


def with_reference(laws: Laws | None, records: Sequence[MotionRecord]) -> Laws | None:
    """Return the laws, with the reference temperature of the records added.

    The laws are returned unchanged if they already contain a temperature, or if a record has no
    temperature.
    """
    law = temperatures(records)
    if law is None or (laws is not None and laws.temperature is not None):
        return laws
    return msgspec.structs.replace(laws or Laws(), temperature=law)


def _change(
    level: Interval | None, slope: Interval | None, curvature: Interval | None
) -> TemperatureChange | None:
    if level is None or slope is None or level.value <= 0.0 or not np.isfinite(slope.half_width):
        return None
    return TemperatureChange(
        _relative(slope, level).estimate("change per kelvin", "rotary"),
        None
        if curvature is None
        else _relative(curvature, level).estimate("change per square kelvin", "rotary"),
    )


def _relative(change: Interval, level: Interval) -> Interval:
    value = change.value / level.value
    half = float(np.hypot(change.half_width, value * level.half_width)) / level.value
    return Interval.around(value, half)
