"""Resampling of streams with different time bases to one time grid, without extrapolation.

    held      a command, or a drive signal that changes once per control period, keeps its value
              until the next sample: the resampled value is the last sample at or before each time
    linear    every other signal is interpolated between the samples around each time

The grid begins, to the ns, at the first sample of the stream that begins last. It ends at or before
the last sample of the stream that ends first.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from frictool.logs.canonical.mcap_layout import StreamHeader, message_path
from frictool.logs.canonical.sample_chunks import join_blocks, merged
from frictool.logs.log import MAIN_TOPIC
from frictool.logs.raw_table import BLOCK_ROWS, Nanoseconds
from frictool.logs.stream_source import SampleBlock
from frictool.typing import Vector

HELD = ("reference", "current", "voltage")
EFFORT = "effort"
# metadata record: `period_s`, and MESSAGE PATH -> `held` or `linear`, with the original path if it
# differs
RESAMPLED = "resampled"


@dataclass(frozen=True)
class GridField:
    """Field of the resampled stream.

    stream: index of the original stream.
    field: index of the field in the original stream.
    is_held: True if a value is kept until the next sample, False if values are interpolated.
    """

    stream: int
    field: int
    is_held: bool


@dataclass(frozen=True)
class ResamplingGrid:
    """Layout of the resampled stream `/axis`.

    parts: for each field of the resampled stream, the original stream and field.
    period_ns: sample period in ns.
    note: entries of the metadata record RESAMPLED.
    """

    head: StreamHeader
    parts: tuple[GridField, ...]
    period_ns: int
    note: dict[str, str]


def grid(heads: Sequence[StreamHeader], derived: Sequence[str], period_ns: int) -> ResamplingGrid:
    """Return the layout of the resampled stream, which has the fields of all streams.

    derived: topics of the streams whose effort is computed from the drive signal. Such an effort
        keeps its value until the next sample, as the drive signal does.
    """
    fields: list[str] = []
    units: list[str] = []
    parts: list[GridField] = []
    note = {"period_s": f"{period_ns / 1e9:.9g}"}
    for number, head in enumerate(heads):
        for index, (name, unit) in enumerate(zip(head.fields, head.units, strict=True)):
            is_held = name in HELD or (name == EFFORT and head.topic in derived)
            new = name if name not in fields else _prefixed(head.topic, name, fields)
            was = message_path(head.topic, name)
            fields.append(new)
            units.append(unit)
            parts.append(GridField(number, index, is_held))
            path = message_path(MAIN_TOPIC, new)
            note[path] = ("held" if is_held else "linear") + (
                f", from {was}" if was != path else ""
            )
    return ResamplingGrid(
        StreamHeader(MAIN_TOPIC, tuple(fields), tuple(units)), tuple(parts), period_ns, note
    )


def _prefixed(topic: str, name: str, taken: list[str]) -> str:
    words = "_".join(
        filter(None, topic.removeprefix(MAIN_TOPIC).lower().replace("/", "_").split("_"))
    )
    base = new = (
        f"{words}_{name}" if words[:1].isalpha() else f"more_{words}_{name}".replace("__", "_")
    )
    number = 2
    while new in taken:
        new = f"{base}_{number}"
        number = number + 1
    return new


def resampled(
    streams: Sequence[Iterator[SampleBlock]], on: ResamplingGrid
) -> Iterator[SampleBlock]:
    """Yield the resampled stream in blocks."""
    kept: list[SampleBlock | None] = [None] * len(streams)
    start: int | None = None
    row = 0
    for index, piece in merged(streams):
        before = kept[index]
        kept[index] = piece if before is None else join_blocks([before, piece])
        there = [one for one in kept if one is not None]
        if len(there) < len(streams):
            continue
        start = max(int(one.time[0]) for one in there) if start is None else start
        rows = (min(int(one.time[-1]) for one in there) - start) // on.period_ns + 1 - row
        while rows > 0:
            count = min(rows, BLOCK_ROWS)
            time = start + (row + np.arange(count)) * on.period_ns
            yield SampleBlock(time, tuple(_at(there[part.stream], part, time) for part in on.parts))
            row = row + count
            rows = rows - count
        following = start + row * on.period_ns
        kept = [
            one.part(
                max(0, int(np.searchsorted(one.time, following, side="right")) - 1), one.time.size
            )
            for one in there
        ]


def _at(samples: SampleBlock, part: GridField, time: Nanoseconds) -> Vector:
    values = samples.values[part.field]
    before = np.searchsorted(samples.time, time, side="right") - 1
    if part.is_held:
        return values[before]
    after = np.minimum(before + 1, samples.time.size - 1)
    width = np.maximum(samples.time[after] - samples.time[before], 1)
    weight = (time - samples.time[before]) / width
    interpolated: Vector = values[before] + weight * (values[after] - values[before])
    return interpolated
