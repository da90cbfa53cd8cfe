"""Streams that the channels of a canonical log declare, and blocks of samples of these streams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from mcap.records import Channel, Schema

from frictool.logs.canonical.mcap_layout import (
    CDR_HEAD,
    MESSAGE_ENCODING,
    MESSAGE_OPCODE,
    RECORD_HEAD,
    SCHEMA_ENCODING,
    TOPIC,
    Records,
    message_dtype,
    schema_fields,
)
from frictool.logs.stream_source import SampleBlock

_WORDS = ["front", "back", "cdr"]  # parts of a message's head that are constant within a stream


@dataclass
class DeclaredStream:
    """Stream that a channel of an MCAP file declares.

    number: channel number.
    samples: number of samples read so far.
    last: time of the last sample read, in ns as stored in the file; None before the first sample.
    """

    number: int
    topic: str
    fields: tuple[str, ...]
    samples: int = 0
    last: int | None = None

    def __post_init__(self) -> None:
        self.dtype = message_dtype(len(self.fields))
        # opcode, length and channel take 11 bytes: comparing two overlapping words replaces
        # comparing three fields
        size = self.dtype.itemsize
        self._heads = np.dtype(
            {
                "names": _WORDS,
                "formats": ["<u8", "<u8", "<u4"],
                "offsets": [0, 3, 31],
                "itemsize": size,
            }
        )
        head = np.zeros(1, self.dtype)
        head["opcode"] = MESSAGE_OPCODE
        head["length"] = size - RECORD_HEAD
        head["channel"] = self.number
        head["cdr"] = CDR_HEAD
        self._head = head.view(self._heads)[0]

    def are_mine(self, records: Records) -> bool:
        """Return True if all records are messages of this channel with the layout of its schema."""
        heads = records.view(self._heads)
        return all(bool((heads[name] == self._head[name]).all()) for name in _WORDS)


class ChannelSamples(NamedTuple):
    """Samples of a channel, with the times as stored in the file.

    chunks: byte offsets of the chunks that contain the samples.
    """

    channel: int
    samples: SampleBlock
    chunks: tuple[int, ...]


def axis_fields(channel: Channel, schema: Schema | None) -> tuple[str, ...] | None:
    """Return the field names of a channel; None for a channel that no canonical log can contain."""
    text = schema.data.decode() if schema is not None and schema.encoding == SCHEMA_ENCODING else ""
    fields = schema_fields(text)
    return (
        fields
        if channel.message_encoding == MESSAGE_ENCODING and TOPIC.fullmatch(channel.topic)
        else None
    )
