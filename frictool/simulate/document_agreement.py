"""Check that plant, controller and scenario have the same kind of axis, drive and timing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, NoReturn

from frictool.documents.conditions import Disturbance
from frictool.documents.controller import Controller
from frictool.documents.key_lines import document_error
from frictool.documents.laws import FrictionOverTemperature
from frictool.documents.quantity import si_unit
from frictool.documents.scenario import Scenario
from frictool.documents.spread import SpreadDisturbance
from frictool.simulate.rig import Rig


class DocumentNames(NamedTuple):
    """Names of the plant (`model`), controller and scenario in messages, such as their paths."""

    model: str = "model"
    controller: str = "controller"
    scenario: str = "scenario"


DOCUMENTS = DocumentNames()


def refuse(name: str, key: str, message: str) -> NoReturn:
    """Raise DocumentError for `key` of the document `name`.

    If `name` is the path of a file, the message contains the line of the key.
    """
    raise document_error(name, key, message)


def check_agreement(
    rig: Rig, controller: Controller, scenario: Scenario, names: DocumentNames
) -> None:
    """Raise DocumentError if controller or scenario do not fit the rig of the plant.

    The controller must have the rig's kind of axis, kind of drive, sample period, delay and time
    constant of the drive. The scenario must have the rig's kind of axis, and must pass
    `check_drive`, `check_efforts` and `check_temperature`.
    """
    owner = rig.owner.format(names.model)
    lag = controller.bench.actuator.loop_time_constant_s
    for key, ours, theirs in (
        ("axis", controller.axis, rig.axis),
        ("drive", controller.drive, rig.drive),
        ("sample_period_s", controller.sample_period_s, rig.sample_period_s),
        ("delay_samples", controller.delay_samples, rig.delay_samples),
        ("bench.actuator.loop_time_constant_s", lag, rig.loop_time_constant_s),
    ):
        if ours != theirs:
            refuse(
                names.controller,
                key,
                f"found {ours}, but {owner} has {theirs}; synthesise again for {_this(rig)}",
            )
    if scenario.axis != rig.axis:
        refuse(names.scenario, "axis", f"found {scenario.axis}, but {names.model} has {rig.axis}")
    check_drive(scenario, rig, names)
    check_efforts(scenario, rig, names)
    check_temperature(scenario, rig.temperature, names)


def check_drive(scenario: Scenario, rig: Rig, names: DocumentNames) -> None:
    """Raise DocumentError if the scenario's kind of drive (current, voltage) is not the rig's.

    The default kind `current` is allowed for any rig, unless the scenario has an offset of the
    drive's sensor.
    """
    in_drive = any(fault.offset is not None for fault in scenario.sensor_faults)
    if scenario.drive != rig.drive and (in_drive or scenario.drive != "current"):
        refuse(
            names.scenario,
            "drive",
            f"found {scenario.drive}; allowed: {rig.drive}, the drive of {names.model}",
        )


def check_efforts(scenario: Scenario, rig: Rig, names: DocumentNames) -> None:
    """Raise DocumentError if the unit of a disturbance does not suit the rig's kind of axis.

    Only disturbances of the driven axis are checked.
    """
    wanted = si_unit("effort", rig.effort_axis)
    for index, disturbance in enumerate(scenario.disturbances):
        if disturbance.on is None and disturbance.effort.unit != wanted:
            unit = disturbance.effort.unit
            message = (
                f"unit {unit!r} is not a unit of effort for a {rig.effort_axis} axis; allowed: "
                f"{wanted} and its multiples"
            )
            refuse(names.scenario, f"disturbances[{index}].effort.unit", message)


def check_temperature(
    scenario: Scenario, law: FrictionOverTemperature | None, names: DocumentNames
) -> None:
    """Raise DocumentError if the scenario has a temperature, but `law` is None.

    law: dependence of the plant's friction on the temperature; None if the friction does not depend
    on the temperature.
    """
    if scenario.temperature is not None and law is None:
        refuse(
            names.scenario,
            "temperature",
            f"found {scenario.temperature.value:g} degC, but {names.model} has no "
            "laws.temperature; identify a model from logs with a temperature, or use drifts",
        )


def disturbances_of(scenario: Scenario) -> Iterator[tuple[str, Disturbance | SpreadDisturbance]]:
    """Yield (key, disturbance) for each disturbance of the scenario and of its `spread`."""
    drawn = () if scenario.spread is None else scenario.spread.disturbances
    yield from ((f"disturbances[{index}]", one) for index, one in enumerate(scenario.disturbances))
    yield from ((f"spread.disturbances[{index}]", one) for index, one in enumerate(drawn))


def _this(rig: Rig) -> str:
    return "this bench" if rig.owner != "{}" else "this mechanism"
