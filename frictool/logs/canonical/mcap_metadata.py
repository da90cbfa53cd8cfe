"""Units, times and other metadata records of a canonical log."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import (
    EPOCH_KEY,
    SHIFT_KEY,
    TIME,
    UNITS,
    StreamHeader,
    message_path,
)
from frictool.logs.canonical.mcap_streams import DeclaredStream

_WHOLE = re.compile(r"-?[0-9]{1,19}")
Metadata = dict[str, dict[str, str]]  # name -> key -> text


def heads(path: Path, metadata: Metadata, channels: Iterable[DeclaredStream]) -> list[StreamHeader]:
    """Return the headers (topic, fields, units) in the order of `channels`.

    Raises LogError if there is no channel, or if a channel has no samples or no units.
    """
    units = metadata.get(UNITS, {})
    heads_read = []
    for one in channels:
        if not one.samples:
            raise LogError(path, f"stream {one.topic} has no samples")
        missing = [name for name in one.fields if message_path(one.topic, name) not in units]
        if missing:
            raise LogError(
                path,
                f"is not a canonical log: metadata {UNITS!r} has no "
                f"{message_path(one.topic, missing[0])!r}",
            )
        heads_read.append(
            StreamHeader(
                one.topic,
                one.fields,
                tuple(units[message_path(one.topic, name)] for name in one.fields),
            )
        )
    if not heads_read:
        raise LogError(path, "no sample can be read, because no channel is declared")
    return heads_read


def shift_ns(path: Path, metadata: Metadata) -> int:
    """Return the shift in ns that the writer added to every time; 0 if the times were not shifted.

    Raises LogError if this entry of the metadata is not an integer.
    """
    return _nanoseconds(path, metadata, SHIFT_KEY) or 0


def epoch_ns(path: Path, metadata: Metadata) -> int | None:
    """Return the clock time in ns at time 0 of the log, or None if the log has no clock.

    Raises LogError if this entry of the metadata is not an integer.
    """
    return _nanoseconds(path, metadata, EPOCH_KEY)


def _nanoseconds(path: Path, metadata: Metadata, key: str) -> int | None:
    text = metadata.get(TIME, {}).get(key)
    if text is not None and not (_WHOLE.fullmatch(text) and abs(int(text)) < 2**62):
        raise LogError(path, f"metadata {TIME}.{key}: found {text!r}; allowed: a whole number")
    return None if text is None else int(text)


def notes(metadata: Metadata) -> Metadata:
    """Return the metadata records except the units and the time shift."""
    clocks = {key: text for key, text in metadata.get(TIME, {}).items() if key != SHIFT_KEY}
    others = {name: entries for name, entries in metadata.items() if name not in (UNITS, TIME)}
    return {**others, **({TIME: clocks} if clocks else {})}
