"""What a canonical log holds, channel by channel, while it is read: streams as declared, and pieces
of them."""

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

_WORDS = ["front", "back", "cdr"]  # of a message's head, what is the same in all of a stream


@dataclass
class DeclaredStream:
    """One stream as its channel declares it, how many samples have been found in it, and the time
    of the last, in ns as it is stored."""

    number: int
    topic: str
    fields: tuple[str, ...]
    samples: int = 0
    last: int | None = None

    def __post_init__(self) -> None:
        self.dtype = message_dtype(len(self.fields))
        # kind, length and channel take 11 bytes: two words that overlap are compared, not three
        # fields
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
        head["opcode"], head["length"], head["channel"], head["cdr"] = (
            MESSAGE_OPCODE,
            size - RECORD_HEAD,
            self.number,
            CDR_HEAD,
        )
        self._head = head.view(self._heads)[0]

    def are_mine(self, records: Records) -> bool:
        """Whether records are messages of this channel and of its layout."""
        heads = records.view(self._heads)
        return all(bool((heads[name] == self._head[name]).all()) for name in _WORDS)


class ChannelSamples(NamedTuple):
    """Samples of a channel, times as stored; chunks: the bytes where the records begin in which
    they lie."""

    channel: int
    samples: SampleBlock
    chunks: tuple[int, ...]


def axis_fields(channel: Channel, schema: Schema | None) -> tuple[str, ...] | None:
    """The fields of a stream of a canonical log; None where the channel is none."""
    text = schema.data.decode() if schema is not None and schema.encoding == SCHEMA_ENCODING else ""
    fields = schema_fields(text)
    return (
        fields
        if channel.message_encoding == MESSAGE_ENCODING and TOPIC.fullmatch(channel.topic)
        else None
    )
