"""What a canonical log holds, channel by channel, while it is read: streams as declared, pieces of them, and what is lost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

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
from frictool.logs.flow import Samples


@dataclass
class Declared:
    """One stream as its channel declares it, how many samples have been found in it, and the time of the last, in ns as it is stored."""

    number: int
    topic: str
    fields: tuple[str, ...]
    samples: int = 0
    first: int | None = None
    last: int | None = None

    def __post_init__(self) -> None:
        self.dtype = message_dtype(len(self.fields))

    def are_mine(self, records: Records) -> bool:
        """Whether records are messages of this channel and of its layout."""
        like = (records["opcode"] == MESSAGE_OPCODE) & (records["length"] == self.dtype.itemsize - RECORD_HEAD)
        return bool((like & (records["channel"] == self.number) & (records["cdr"] == CDR_HEAD)).all())


class Lost(NamedTuple):
    """What cannot be read: of one channel, or of all; when, in ns as stored; how many samples; None is not known."""

    reason: str
    channel: int | None = None
    first: int | None = None
    last: int | None = None
    samples: int | None = None


class Piece(NamedTuple):
    """Samples of a channel, times as stored; at: the byte where the record begins in which they lie."""

    channel: int
    samples: Samples
    at: int


def axis_fields(channel: Channel, schema: Schema | None) -> tuple[str, ...] | None:
    """The fields of a stream of a canonical log; None where the channel is none."""
    text = schema.data.decode() if schema is not None and schema.encoding == SCHEMA_ENCODING else ""
    fields = schema_fields(text)
    return fields if channel.message_encoding == MESSAGE_ENCODING and TOPIC.fullmatch(channel.topic) else None
