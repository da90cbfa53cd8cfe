"""Check that a campaign can simulate every plant and scenario drawn from the scenario's `spread`.

The parameters of `spread` must exist and have suitable units. The start position must be within the
travel, and the events within the duration. The plants at both ends of each parameter range must be
possible; otherwise plants drawn near an end would fail.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from frictool.documents.controller import Controller
from frictool.documents.quantity import Quantity, factor_between, si_unit
from frictool.documents.scenario import Scenario
from frictool.documents.spread import Spread, SpreadDisturbance, SpreadFault
from frictool.errors import FrictoolError
from frictool.simulate.document_agreement import DocumentNames, refuse
from frictool.simulate.parameter_order import check_least
from frictool.simulate.scenario_limits import SAME_INSTANT, check_frequency
from frictool.simulate.scenario_plant_values import GIVEN
from frictool.simulate.simulated_plant import SimulatedPlant, V, VariedParameter


def check_spread(
    plant: SimulatedPlant[V],
    controller: Controller,
    scenario: Scenario,
    seconds: float,
    names: DocumentNames,
) -> None:
    """Raise DocumentError for the first key of `spread` that does not fit plant and scenario."""
    spread = scenario.spread or Spread()
    rig = plant.rig
    name = names.scenario
    _check_parameters(spread, plant.ranges(), names)
    _check_ends(plant, controller, scenario, spread, names)
    check_least(plant.ranges(), spread.parameters, scenario.given, names, drawn=True)
    if (
        spread.start is not None
        and rig.travel is not None
        and not (rig.travel.low <= spread.start.low <= spread.start.high <= rig.travel.high)
    ):
        start = f"found {spread.start.low:g} to {spread.start.high:g} {spread.start.unit}"
        refuse(
            name,
            "spread.start",
            f"{start}; allowed: the travel of the bench, {rig.travel.low:g} to {rig.travel.high:g}",
        )
    if spread.within_count and rig.resolution == 0.0:
        refuse(
            name,
            "spread.within_count",
            f"the sensor of {names.model} has no counts; remove the key",
        )
    for index, fault in enumerate(spread.sensor_faults):
        _check_times(fault, f"spread.sensor_faults[{index}]", seconds, rig.sample_period_s, name)
        if fault.offset is not None and scenario.drive != rig.drive:
            refuse(
                name,
                "drive",
                f"found {scenario.drive}; allowed: {rig.drive}, the drive of {names.model}",
            )
    for index, one in enumerate(spread.disturbances):
        key = f"spread.disturbances[{index}]"
        _check_times(one, key, seconds, rig.sample_period_s, name)
        wanted = si_unit("effort", rig.effort_axis)
        if one.on is None and one.effort.unit != wanted:
            refuse(
                name,
                f"{key}.effort.unit",
                f"found a multiple of {one.effort.unit}; allowed: {wanted} and its multiples",
            )
        if one.frequency_hz is not None:
            check_frequency(
                one.frequency_hz.high, rig.sample_period_s, f"{key}.frequency_hz.high", name
            )


def _check_parameters(
    spread: Spread, ranges: Mapping[str, VariedParameter], names: DocumentNames
) -> None:
    for parameter, span in spread.parameters.items():
        key = f"spread.parameters.{parameter}"
        if parameter not in ranges:
            refuse(
                names.scenario,
                key,
                f"{names.model} has no such parameter; allowed: {', '.join(ranges)}",
            )
        try:
            factor_between(span.unit, ranges[parameter].unit)
        except ValueError as error:
            refuse(names.scenario, f"{key}.unit", str(error))


def _check_ends(
    plant: SimulatedPlant[V],
    controller: Controller,
    scenario: Scenario,
    spread: Spread,
    names: DocumentNames,
) -> None:
    for parameter, span in spread.parameters.items():
        least = plant.ranges()[parameter].least
        for end, value in (("low", span.low), ("high", span.high)):
            if least is not None and value < 0.0:  # a mechanism would use the limit instead
                problem = f"found {value:g} {span.unit}, below 0"
                refuse(
                    names.scenario,
                    f"spread.parameters.{parameter}.{end}",
                    f"{problem}; allowed: at least 0, because its lower limit is proportional to "
                    f"{plant.ranges()[least[0]].label}",
                )
            values = {parameter: Quantity(value=value, unit=span.unit)}
            one = msgspec.structs.replace(
                scenario, variants=GIVEN, plants=None, given=values, spread=None
            )
            try:
                plant.variants(controller, one, names.model)
            except FrictoolError as error:
                reason = (
                    str(error)
                    .removeprefix(f"{names.model} as given: ")
                    .removesuffix("; give another")
                )
                problem = (
                    f"found {value:g} {span.unit}; a plant with this value cannot be simulated"
                )
                refuse(
                    names.scenario, f"spread.parameters.{parameter}.{end}", f"{problem}: {reason}"
                )


def _check_times(
    one: SpreadFault | SpreadDisturbance, key: str, seconds: float, period: float, name: str
) -> None:
    lasts = one.lasts_s if isinstance(one, SpreadFault) else one.duration_s
    of_it = "lasts_s" if isinstance(one, SpreadFault) else "duration_s"
    if one.at_s.high >= seconds:
        refuse(
            name,
            f"{key}.at_s",
            f"found {one.at_s.high:g}, after the end; allowed: below {seconds:g}, the duration of "
            "the scenario",
        )
    if lasts is None:
        return
    if lasts.low < period * (1.0 - SAME_INSTANT):
        refuse(
            name,
            f"{key}.{of_it}",
            f"found {lasts.low:g} s; allowed: at least one sample ({period:g} s)",
        )
    if one.at_s.high + lasts.high > seconds * (1.0 + SAME_INSTANT):
        end = one.at_s.high + lasts.high
        refuse(
            name,
            f"{key}.{of_it}",
            f"may end at {end:g} s, after the end; allowed: at most {seconds:g} s, the duration of "
            "the scenario",
        )
