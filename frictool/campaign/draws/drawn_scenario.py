"""Scenario of one draw; its simulation repeats the trial of this draw bit for bit."""

from __future__ import annotations

import math
from collections.abc import Mapping

import msgspec

from frictool.campaign.draws.factor_space import FactorSpace
from frictool.campaign.draws.sampling import noise_seed
from frictool.campaign.draws.spread_factors import (
    START,
    TEMPERATURE,
    WEAR,
    WITHIN_COUNT,
    disturbance_key,
    fault_key,
)
from frictool.documents.conditions import Disturbance, DriftPoint, Drifts, SensorFault
from frictool.documents.quantity import Quantity
from frictool.documents.scenario import Scenario
from frictool.documents.spread import Spread
from frictool.typing import Vector

Values = Mapping[str, float]


def scenario_of(
    base: Scenario, space: FactorSpace, values: Vector, noise: tuple[int, int], step: float
) -> Scenario:
    """Return the scenario of one draw with the factor values `values` (d,) in SI.

    `base`: scenario of the campaign.
    `noise`: (seed of the campaign, index of the draw), from which the seed of the noise follows.
    `step`: encoder step [rad | m].
    """
    spread = base.spread or Spread()
    at = dict(zip(space.names, map(float, values), strict=True))
    drawn = {
        name: Quantity(value=span.low, unit=span.unit) for name, span in spread.parameters.items()
    }  # including factors with low equal to high
    drawn |= {
        factor.name: Quantity(value=at[factor.name], unit=factor.unit)
        for factor in space.factors
        if factor.kind == "plant"
    }
    return msgspec.structs.replace(
        base,
        start=_start(base, spread, at, step),
        variants="given",
        plants=None,
        given={**base.given, **drawn},
        seed=noise_seed(*noise) if base.drive_noise > 0.0 else base.seed,
        disturbances=(*base.disturbances, *_disturbances(spread, at)),
        drifts=_drifts(base.drifts, spread, at),
        sensor_faults=(*base.sensor_faults, *_faults(spread, at)),
        spread=None,
    )


def nominal_of(base: Scenario) -> Scenario:
    """Return the scenario without `spread`, for the nominal plant changed by `base.given`."""
    return msgspec.structs.replace(
        base, variants="given" if base.given else "nominal", plants=None, spread=None
    )


def _start(base: Scenario, spread: Spread, at: Values, step: float) -> Quantity | None:
    start = base.start
    if spread.start is not None:
        start = Quantity(value=at.get(START, spread.start.low), unit=spread.start.unit)
    if start is not None and WITHIN_COUNT in at:
        return Quantity(
            value=(math.floor(start.value / step) + at[WITHIN_COUNT]) * step, unit=start.unit
        )
    return start


def _drifts(drifts: Drifts | None, spread: Spread, at: Values) -> Drifts | None:
    factors = {"friction": 1.0, "viscous": 1.0, "constant": 1.0}
    if spread.wear is not None:
        factors["friction"] = at.get(WEAR, spread.wear.low)
    if spread.temperature is not None:
        part = at.get(TEMPERATURE, 0.0)
        cold = spread.temperature.cold
        hot = spread.temperature.hot
        factors["viscous"] = cold.viscous + part * (hot.viscous - cold.viscous)
        factors["constant"] = cold.constant + part * (hot.constant - cold.constant)
    nominal = drifts or Drifts()
    scaled = Drifts(
        **{name: _scaled(getattr(nominal, name), factor) for name, factor in factors.items()}
    )
    return None if scaled == Drifts() else scaled


def _scaled(points: tuple[DriftPoint, ...], factor: float) -> tuple[DriftPoint, ...]:
    if factor == 1.0:
        return points
    return tuple(
        DriftPoint(point.at_s, factor * point.factor) for point in points or (DriftPoint(0.0, 1.0),)
    )


def _faults(spread: Spread, at: Values) -> list[SensorFault]:
    faults = []
    for index, fault in enumerate(spread.sensor_faults):
        key = fault_key(index)
        begin = at.get(f"{key}.at_s", fault.at_s.low)
        until = (
            None if fault.lasts_s is None else begin + at.get(f"{key}.lasts_s", fault.lasts_s.low)
        )
        if fault.counts is not None:
            counts = int(at.get(f"{key}.counts", fault.counts.low))
            if counts != 0:
                faults.append(SensorFault("lost_counts", begin, counts=counts))
        elif fault.offset is not None:
            offset = Quantity(
                value=at.get(f"{key}.offset", fault.offset.low), unit=fault.offset.unit
            )
            faults.append(SensorFault("drive_offset", begin, until, offset=offset))
        elif fault.gain_error is not None:
            faults.append(
                SensorFault(
                    "drive_gain",
                    begin,
                    until,
                    gain_error=at.get(f"{key}.gain_error", fault.gain_error.low),
                )
            )
        else:
            faults.append(SensorFault(fault.kind, begin, until))
    return faults


def _disturbances(spread: Spread, at: Values) -> list[Disturbance]:
    disturbances = []
    for index, one in enumerate(spread.disturbances):
        key = disturbance_key(index)
        lasts = None if one.duration_s is None else at.get(f"{key}.duration_s", one.duration_s.low)
        turns = (
            None
            if one.frequency_hz is None
            else at.get(f"{key}.frequency_hz", one.frequency_hz.low)
        )
        effort = Quantity(value=at.get(f"{key}.effort", one.effort.low), unit=one.effort.unit)
        disturbances.append(
            Disturbance(
                one.kind, effort, at.get(f"{key}.at_s", one.at_s.low), lasts, turns, on=one.on
            )
        )
    return disturbances
