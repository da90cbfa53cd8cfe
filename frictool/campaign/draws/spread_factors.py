"""Factors of a scenario's `spread`; the name of a factor is its key in the file."""

from __future__ import annotations

from collections.abc import Iterator

from frictool.campaign.draws.factor_space import Factor, Kind
from frictool.documents.scenario import Scenario
from frictool.documents.spread import (
    CountBand,
    FactorBand,
    FrequencyBand,
    GainBand,
    InstantBand,
    LastingBand,
    Spread,
    SpreadFault,
)

START, WITHIN_COUNT, WEAR, TEMPERATURE = (
    "spread.start",
    "spread.within_count",
    "spread.wear",
    "spread.temperature",
)
NOWHERE = float("nan")  # nominal value of a factor that is only in `spread`
Band = FactorBand | InstantBand | LastingBand | GainBand | CountBand | FrequencyBand
OF_FAULT = {
    "lost_counts": "lost counts",
    "encoder_stuck": "encoder stuck",
    "encoder_invalid": "encoder invalid",
    "drive_offset": "offset of the drive's sensor",
    "drive_gain": "gain error of the drive's sensor",
}


def spread_factors(scenario: Scenario) -> Iterator[Factor]:
    """Yield the factors of `spread`, including constant factors, but no plant parameters."""
    spread = scenario.spread or Spread()
    if spread.start is not None:
        nominal = NOWHERE if scenario.start is None else scenario.start.value
        yield Factor(
            START, spread.start.low, spread.start.high, spread.start.unit, "start", nominal, "start"
        )
    if spread.within_count:
        yield Factor(WITHIN_COUNT, 0.0, 1.0, "1", "start within a count", NOWHERE, "start")
    if spread.wear is not None:
        yield Factor(
            WEAR,
            spread.wear.low,
            spread.wear.high,
            "1",
            "wear: factor on dry friction",
            1.0,
            "wear",
        )
    if spread.temperature is not None:
        cold, hot = spread.temperature.cold, spread.temperature.hot
        if cold != hot:
            yield Factor(
                TEMPERATURE, 0.0, 1.0, "1", "temperature (0 cold, 1 hot)", NOWHERE, "temperature"
            )
    for index, fault in enumerate(spread.sensor_faults):
        yield from _of_fault(
            fault,
            fault_key(index),
            _numbered(OF_FAULT[fault.kind], [one.kind for one in spread.sensor_faults], index),
        )
    for index, one in enumerate(spread.disturbances):
        key = disturbance_key(index)
        label = _numbered(one.kind, [other.kind for other in spread.disturbances], index)
        yield Factor(
            f"{key}.effort",
            one.effort.low,
            one.effort.high,
            one.effort.unit,
            f"{label}: effort",
            0.0,
            "load",
        )
        yield _band(f"{key}.at_s", one.at_s, "s", f"{label}: begin", "load")
        if one.duration_s is not None:
            yield _band(f"{key}.duration_s", one.duration_s, "s", f"{label}: duration", "load")
        if one.frequency_hz is not None:
            yield _band(
                f"{key}.frequency_hz", one.frequency_hz, "Hz", f"{label}: frequency", "load"
            )


def fault_key(index: int) -> str:
    """Return the key of the sensor fault `index` in the scenario."""
    return f"spread.sensor_faults[{index}]"


def disturbance_key(index: int) -> str:
    """Return the key of the disturbance `index` in the scenario."""
    return f"spread.disturbances[{index}]"


def _of_fault(fault: SpreadFault, key: str, label: str) -> Iterator[Factor]:
    if fault.counts is not None:
        yield Factor(
            f"{key}.counts",
            fault.counts.low,
            fault.counts.high,
            "1",
            label,
            0.0,
            "sensor",
            whole=True,
        )
    if fault.offset is not None:
        yield Factor(
            f"{key}.offset",
            fault.offset.low,
            fault.offset.high,
            fault.offset.unit,
            label,
            0.0,
            "sensor",
        )
    if fault.gain_error is not None:
        yield _band(f"{key}.gain_error", fault.gain_error, "1", label, "sensor", 0.0)
    yield _band(f"{key}.at_s", fault.at_s, "s", f"{label}: begin", "sensor")
    if fault.lasts_s is not None:
        yield _band(f"{key}.lasts_s", fault.lasts_s, "s", f"{label}: duration", "sensor")


def _band(
    name: str, band: Band, unit: str, label: str, kind: Kind, nominal: float = NOWHERE
) -> Factor:
    return Factor(name, band.low, band.high, unit, label, nominal, kind)


def _numbered(label: str, kinds: list[str], index: int) -> str:
    return (
        label
        if kinds.count(kinds[index]) == 1
        else f"{label} {kinds[: index + 1].count(kinds[index])}"
    )
