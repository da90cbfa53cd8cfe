"""All blocks of a mechanism as one stream of a log, `/mechanism`, that plotting tools show signal
by signal.

=============================
==================================================================================================
channel                        meaning, at each sample; names are the elements', in lower case
=============================
==================================================================================================
BLOCK_position, BLOCK_velocity rad or m
BLOCK_stuck                    1 while friction holds it, of blocks that friction can hold
LINK_contact                   of a link with play: -1 or 1 at the flank that it touches, 0 between;
                               of a stop: at its low, its high end
SOURCE_current, .. _effort     what flows from the sample on
SENSOR_position, .. _velocity  what each sensor shows, without the faults of a scenario
BLOCK_disturbance              the mean effort from outside over the sample, where a scenario names
                               the block
=============================
==================================================================================================
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from frictool.documents.quantity import si_unit
from frictool.engine.mechanism.state import STUCK
from frictool.logs.log import Stream
from frictool.simulate.axis_channels import NO_UNIT
from frictool.simulate.mechanism_rig import resolution_of
from frictool.simulate.mechanism_variants import MechanismVariant

Vector = NDArray[np.float64]
Modes = NDArray[np.int8]
DRIVE_UNITS = {"current": "A", "voltage": "V"}


def field_names(names: Iterable[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """Names of elements -> the beginnings of names of signals: lower case, no double _, each once
    and none of those taken.

    >>> field_names(("m6", "Rack", "rack"), ("m6",))
    {'m6': 'm6_2', 'Rack': 'rack', 'rack': 'rack_2'}
    """
    found: dict[str, str] = {}
    known = set(taken)
    for name in names:
        plain = re.sub(r"_+", "_", name.lower()).strip("_")
        unique, number = plain, 2
        while unique in known:
            unique, number = f"{plain}_{number}", number + 1
        known.add(unique)
        found[name] = unique
    return found


class MechanismChannels:
    """Makes the `/mechanism` streams of the variants of one scenario; time (n,); disturbances:
    block -> mean effort of each sample (n,)."""

    def __init__(self, time: Vector, disturbances: dict[int, Vector]) -> None:
        self.time, self.disturbances = time, disturbances

    def stream(self, variant: MechanismVariant, motion: Vector, modes: Modes) -> Stream:
        """motion (samples, 2 n + u): positions, speeds, drives; modes (samples, m):
        engine/mechanism/state.py."""
        columns: dict[str, tuple[Vector, str]] = {}
        for parts in (
            self._blocks(variant, motion, modes),
            self._contacts(variant, modes),
            self._edges(variant, motion),
        ):
            columns |= {name: (values, unit) for name, values, unit in parts}
        signals = {
            name: np.ascontiguousarray(values, dtype=np.float64)
            for name, (values, _) in columns.items()
        }
        return Stream(
            variant.whole_topic,
            self.time,
            signals,
            {name: unit for name, (_, unit) in columns.items()},
        )

    def _blocks(
        self, variant: MechanismVariant, motion: Vector, modes: Modes
    ) -> Iterator[tuple[str, Vector, str]]:
        made = variant.assembled
        names, n = field_names(made.blocks), len(made.blocks)
        holding = held_blocks(variant)
        for block, name in enumerate(made.blocks):
            kind = made.kinds[block]
            yield f"{names[name]}_position", motion[:, block], si_unit("position", kind)
            yield f"{names[name]}_velocity", motion[:, n + block], si_unit("velocity", kind)
            if block in holding:
                yield f"{names[name]}_stuck", (modes[:, block] == STUCK).astype(np.float64), NO_UNIT
            if block in self.disturbances:
                yield (
                    f"{names[name]}_disturbance",
                    self.disturbances[block],
                    si_unit("effort", kind),
                )

    def _contacts(
        self, variant: MechanismVariant, modes: Modes
    ) -> Iterator[tuple[str, Vector, str]]:
        made = variant.assembled
        names = field_names(variant.document.links)
        packed, n, j = made.packed, len(made.blocks), len(made.joints)
        places = [(name, n + i) for i, name in enumerate(made.joints) if packed.joints.gap[i] > 0.0]
        places += [
            (name, n + 2 * j + i)
            for i, name in enumerate(made.couplings)
            if packed.couplings.gap[i] > 0.0
        ]
        places += [(name, n + 2 * j + len(made.couplings) + i) for i, name in enumerate(made.stops)]
        for name, place in places:
            yield f"{names[name]}_contact", modes[:, place].astype(np.float64), NO_UNIT

    def _edges(
        self, variant: MechanismVariant, motion: Vector
    ) -> Iterator[tuple[str, Vector, str]]:
        made, document = variant.assembled, variant.document
        n, names = len(made.blocks), field_names(document.sources)
        for place, (name, source) in enumerate(document.sources.items()):
            kind = made.kinds[int(made.packed.sources.block[place])]
            unit = DRIVE_UNITS.get(source.drive) or si_unit("effort", kind)
            yield f"{names[name]}_{source.drive}", motion[:, 2 * n + place], unit
        names = field_names(document.sensors, field_names(made.blocks).values())
        for (name, sensor), block in zip(document.sensors.items(), made.sensor_blocks, strict=True):
            step = resolution_of(sensor)
            shown = motion[:, block if sensor.measures == "position" else n + block]
            seen = np.floor(shown / step) * step if step > 0.0 else shown
            yield (
                f"{names[name]}_{sensor.measures}",
                seen,
                si_unit(sensor.measures, made.kinds[block]),
            )


def held_blocks(variant: MechanismVariant) -> set[int]:
    """The blocks that friction can hold, their own or that of what moves as one with them."""
    packed = variant.assembled.packed
    dry = set(packed.frictions.block.tolist()) | set(packed.pressings.block.tolist())
    dry |= set(
        packed.joints.a[(packed.joints.drive_loss != 0.0) | (packed.joints.thread != 0.0)].tolist()
    )
    return {
        block
        for group in variant.assembled.groups
        if dry & set(group.blocks)
        for block in group.blocks
    }
