"""Sources and sensors of a mechanism, and the choice of source and sensor for the controller."""

from __future__ import annotations

import math

from frictool.adapters.mechanism.block_references import MOTION, BlockNames, check_unit
from frictool.adapters.mechanism.element_packing import ElementArrays, pack_rows
from frictool.documents.mechanism import Mechanism, Sensor, Source
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.element_error import ElementError
from frictool.plant.mechanism.packed_mechanism import PackedDrives

DRIVE_UNITS = {"current": "A", "voltage": "V"}


def pack_sources(document: Mechanism, blocks: BlockNames, collected: ElementArrays) -> PackedDrives:
    """Return the sources in the document's order; add constant efforts to `collected.pushes`.

    Raises ElementError if a block or units do not fit.
    """
    rows = []
    for name, source in document.sources.items():
        key = f"sources.{name}"
        block = blocks.index(f"{key}.on", source.on)
        _check_source(key, source, blocks)
        if source.effort is not None:
            collected.constant_push(name, block, source.effort.value)
        winding = (
            (0.0, 0.0)
            if source.winding is None
            else (source.winding.resistance_ohm, source.winding.voltage_v)
        )
        constant = 1.0 if source.constant is None else source.constant.value
        limit = math.inf if source.limit is None else source.limit.value
        rows.append((block, constant, limit, source.loop_time_constant_s, *winding))
    return pack_rows(PackedDrives, rows)


def _check_source(key: str, source: Source, blocks: BlockNames) -> None:
    kind = blocks.kind(f"{key}.on", source.on)
    check_unit(f"{key}.effort", source.effort, "effort", kind, source.on)
    if source.drive == "effort":
        check_unit(f"{key}.limit", source.limit, "effort", kind, source.on)
        return
    check_unit(
        f"{key}.constant",
        source.constant,
        f"effort per {'ampere' if source.drive == 'current' else 'volt'}",
        kind,
        source.on,
    )
    wanted = DRIVE_UNITS[source.drive]
    if source.limit is not None and source.limit.unit != wanted:
        raise ElementError(
            f"{key}.limit.unit",
            f"found a multiple of {source.limit.unit}; allowed: {wanted} and its multiples, "
            f"since drive is {source.drive}",
        )


def check_sensor(name: str, sensor: Sensor, blocks: BlockNames) -> None:
    """Raise ElementError if the block or the step of a sensor is invalid."""
    key = f"sensors.{name}"
    kind = blocks.kind(f"{key}.on", sensor.on)
    if kind == "linear" and sensor.counts_per_revolution is not None:
        raise ElementError(
            f"{key}.counts_per_revolution",
            f"{sensor.on} {MOTION[kind]}, without revolutions; write the key step, with a length",
        )
    check_unit(f"{key}.step", sensor.step, "position", kind, sensor.on)


def controlled_names(document: Mechanism) -> tuple[str, str]:
    """Return the names of the controller's source and sensor.

    The names are stated in `control`. Without `control`, the mechanism must have one source and one
    sensor; sources of a constant effort are ignored if there is another source. Raises ElementError
    if a stated name is unknown, or if there is no source or sensor, or several.
    """
    if document.control is not None:
        for what, name, known in (
            ("source", document.control.source, document.sources),
            ("sensor", document.control.sensor, document.sensors),
        ):
            if name not in known:
                raise ElementError(
                    f"control.{what}",
                    f"found {name!r}; allowed: "
                    f"{', '.join(known) or f'none, since there is no {what}'}",
                )
        return document.control.source, document.control.sensor
    driven = [name for name, source in document.sources.items() if source.effort is None] or list(
        document.sources
    )
    for what, names in (("source", driven), ("sensor", list(document.sensors))):
        if not names:
            raise ElementError(
                f"{what}s",
                f"found none; allowed: at least one {what}, for a controller or a reduced model",
            )
        if len(names) > 1:
            raise ElementError(
                f"{what}s",
                f"found {', '.join(names)}; write the controller's {what} under `control`: "
                f"{{source: ..., sensor: ...}}",
            )
    return driven[0], next(iter(document.sensors))


def controlled_indices(document: Mechanism, assembled: AssembledMechanism) -> tuple[int, int]:
    """Return the indices of the source and the sensor that a controller uses.

    Raises ElementError if the choice of source or sensor is ambiguous.
    """
    source, sensor = controlled_names(document)
    return assembled.sources.index(source), assembled.sensors.index(sensor)
