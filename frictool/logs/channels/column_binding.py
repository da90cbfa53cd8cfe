"""Assignment of the channels in bench.yaml to the tables of a raw file.

Each table that contains the column of a channel becomes a stream.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from frictool.documents.bench import Bench, Column
from frictool.documents.name_list import listed
from frictool.documents.quantity import CHANNEL_DIMENSIONS
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import message_path
from frictool.logs.channels.mapping import EFFORT, TIME, ChannelMapper
from frictool.logs.log import MAIN_TOPIC
from frictool.logs.raw_table import DataLoss, LostColumnError, RawTable, pick
from frictool.logs.text.header_units import ISO_8601

# channel -> column of the bench, and its name in the table
ChannelColumns = dict[str, tuple[Column, str]]


def bind(
    tables: Sequence[RawTable],
    bench: Bench,
    stem: str = "",
    taken: Sequence[str] = (),
    lost: list[DataLoss] | None = None,
) -> list[ChannelMapper]:
    """Return the streams of a raw file.

    The table that contains the position becomes `/axis`. If no table contains the position, the
    first table that contains a channel becomes `/axis`. All other tables that contain a channel
    become `/axis/NAME`.

    stem: "" for the first file of a log; the file name without suffix for any other file. The first
        stream of any other file becomes `/axis/STEM`; its remaining streams become
        `/axis/STEM_NAME`.
    taken: topics already in use.
    lost: list to which a channel is added if its column is in the missing part of a truncated file;
        None to raise LogError instead.

    Raises LogError if bench.yaml maps no channel, or if a table has no time. Also raises LogError
    if a column is missing, is in several tables, or has a unit that contradicts bench.yaml.
    """
    source = tables[0].source
    if not bench.columns.keys() - {TIME}:
        raise LogError(
            source,
            f"bench {bench.name!r} maps no channel: columns needs at least one of "
            f"{', '.join(CHANNEL_DIMENSIONS)}",
        )
    bound: dict[int, ChannelColumns] = {}
    behind: dict[str, LostColumnError] = {}
    for channel, column in bench.columns.items():
        if channel != TIME:
            try:
                home, name = _home(tables, channel, column)
            except LostColumnError as error:
                behind[channel] = error
                continue
            bound.setdefault(home, {})[channel] = column, name
    if behind and (lost is None or not bound):
        raise next(iter(behind.values()))
    order = sorted(bound, key=lambda home: "position" not in bound[home])
    topics: list[str] = []
    for home in order:
        topics.append(topic_for(stem, tables[home].topic if topics else "", [*taken, *topics]))
    if lost is not None:
        lost += [
            DataLoss((message_path(topics[0], channel),), error.reason)
            for channel, error in behind.items()
        ]
    derive_from = (
        bench.actuator.drive if not any(EFFORT in channels for channels in bound.values()) else None
    )
    return [
        ChannelMapper(
            tables[home],
            bench,
            _time(tables[home], bench) | bound[home],
            topic,
            derive=derive_from in bound[home],
            period=bench.sample_period_s if topic == topics[0] else None,
        )
        for home, topic in zip(order, topics, strict=True)
    ]


def _home(tables: Sequence[RawTable], channel: str, column: Column) -> tuple[int, str]:
    wanted = column.column
    source = tables[0].source
    if isinstance(wanted, int) and len(tables) > 1:
        raise LogError(
            source,
            f"columns.{channel}.column: found {wanted}, but the file has {len(tables)} tables, "
            "so that a number does not determine the column; give the name of the column",
        )
    matches = [
        (home, name)
        for home, table in enumerate(tables)
        if (name := table.find(wanted)) is not None
    ]
    if not matches:
        pick([name for table in tables for name in table.names], wanted, source)
    if len(matches) > 1:
        where = listed([tables[home].topic for home, _ in matches])
        raise LogError(
            source,
            f"has {len(matches)} columns {wanted!r}, in {where}; "
            f"write in columns.{channel} a name that only one column has",
        )
    return matches[0]


def _time(table: RawTable, bench: Bench) -> ChannelColumns:
    column = bench.columns.get("time")
    if column is None:
        return {}
    name = table.find(column.column)
    if name is None and table.clock is None:
        pick(table.names, column.column, table.source)
    # the second condition is True if this column already gives the times of the rows
    if name is None or (name == table.clock and column.unit == ISO_8601):
        return {}
    return {TIME: (column, name)}


def topic_for(stem: str, name: str, taken: Collection[str]) -> str:
    """Return the topic `/axis`, `/axis/STEM`, `/axis/NAME` or `/axis/STEM_NAME` of a stream.

    Characters that ROS 2 does not allow are replaced by `_`. If the topic is already in use, a
    number is appended.
    """
    words = re.sub(r"[^A-Za-z0-9]+", "_", "_".join(filter(None, (stem, name)))).strip("_")
    topic = (
        f"{MAIN_TOPIC}/{words if not words[:1].isdigit() else '_' + words}" if words else MAIN_TOPIC
    )
    number = 2
    while topic in taken:
        base = topic.removesuffix(f"_{number - 1}") if topic != MAIN_TOPIC else f"{MAIN_TOPIC}/more"
        topic = f"{base}_{number}"
        number = number + 1
    return topic
