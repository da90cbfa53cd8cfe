"""Stream `/mechanism` of a log, with signals of all blocks (rigid bodies) of a mechanism.

==============================  ==================================================================
channel                         meaning at each sample; names of elements are in lower case
==============================  ==================================================================
BLOCK_position, BLOCK_velocity  rad or m, rad/s or m/s
BLOCK_stuck                     1 while friction keeps a block at rest; only for blocks that can
                                stick
LINK_contact                    link with backlash: -1 or 1 at a flank, 0 between the flanks; end
                                stop: -1 at the low end, 1 at the high end, 0 between the ends
SOURCE_current, .. _effort      drive at the sample; if the drive jumps at the sample, the value
                                after the jump
SENSOR_position, .. _velocity   output of each sensor, without the faults of a scenario
BLOCK_disturbance               mean external effort over the sample, if a scenario disturbs the
                                block
==============================  ==================================================================
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from frictool.adapters.mechanism.sources_and_sensors import DRIVE_UNITS
from frictool.documents.quantity import si_unit
from frictool.engine.mechanism.state import STUCK
from frictool.logs.log import Stream
from frictool.simulate.axis_channels import NO_UNIT
from frictool.simulate.mechanism_rig import resolution_of
from frictool.simulate.mechanism_variants import MechanismVariant
from frictool.typing import Vector

Modes = NDArray[np.int8]


def field_names(names: Iterable[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """Return a prefix for the signal names of each element.

    Prefixes are lower case, without double underscores, unique, and not in `taken`.

    >>> field_names(("m6", "Rack", "rack"), ("m6",))
    {'m6': 'm6_2', 'Rack': 'rack', 'rack': 'rack_2'}
    """
    fields: dict[str, str] = {}
    known = set(taken)
    for name in names:
        plain = re.sub(r"_+", "_", name.lower()).strip("_")
        unique = plain
        number = 2
        while unique in known:
            unique = f"{plain}_{number}"
            number = number + 1
        known.add(unique)
        fields[name] = unique
    return fields


class MechanismChannels:
    """Builder of the streams `/mechanism`, one for each variant of a mechanism in a scenario.

    - time: times of the samples (n,) [s]
    - disturbances: mean effort on a block over each sample (n,) [N m | N], by block index
    """

    def __init__(self, time: Vector, disturbances: dict[int, Vector]) -> None:
        self.time, self.disturbances = time, disturbances

    def stream(self, variant: MechanismVariant, motion: Vector, modes: Modes) -> Stream:
        """Return the stream of a variant with n blocks and u sources.

        `motion` (samples, 2 n + u): positions and speeds of the blocks, drives of the sources.
        `modes` (samples, m): modes of sticking and contact (engine/mechanism/state.py).
        """
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
        packed = made.packed
        n = len(made.blocks)
        j = len(made.joints)
        columns = [
            (name, n + i) for i, name in enumerate(made.joints) if packed.joints.gap[i] > 0.0
        ]
        columns += [
            (name, n + 2 * j + i)
            for i, name in enumerate(made.couplings)
            if packed.couplings.gap[i] > 0.0
        ]
        columns += [
            (name, n + 2 * j + len(made.couplings) + i) for i, name in enumerate(made.stops)
        ]
        for name, place in columns:
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
    """Return the indices of the blocks that friction can hold at rest.

    The friction acts on the block itself or on a block that is rigidly linked to it. Losses of a
    rigid link count as friction on its driving block.
    """
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
