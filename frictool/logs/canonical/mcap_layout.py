"""Layout of the canonical log inside MCAP, shared by its writer and its reader.

    Header                 profile `ros2`
    Schema, Channel        one channel per stream: `/axis`, `/axis/NAME`, `/mechanism`; encoding
                           `cdr`; schema `ros2msg`, flat `float64`
    Metadata               `units` (`/axis.position` -> `rad`), `time` (the shift of the times and
                           the clocks, if any), `provenance`, ...
    Chunk, MessageIndex    at most four seconds of one stream, zstd; the chunk contains messages
                           only, so that it is one NumPy array
    DataEnd                CRC of everything before it
    summary                schemas, channels, statistics, chunk and metadata indexes, offsets

A message consists of the time in ns (log time = publish time) and the values of all fields. All
messages of a stream have the same dtype: 35 bytes of head, then 8 bytes for each field.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MAGIC = b"\x89MCAP0\r\n"
PROFILE = "ros2"
MESSAGE_ENCODING = "cdr"
SCHEMA_ENCODING = "ros2msg"
# name of the first schema; the schema of streams with other fields is Axis2, Axis3, ...
SCHEMA_NAME = "frictool_msgs/msg/Axis"
UNITS = "units"  # metadata record: MESSAGE PATH -> unit
TIME = "time"  # metadata record: SHIFT_KEY -> ns that were added to every time to make it >= 0
SHIFT_KEY = "shift_ns"
# key of the record `time`: clock time in ns at log time 0; the record also has TOPIC -> clock
EPOCH_KEY = "epoch_ns"
KIND = "log"  # metadata record: kind of the log, with the bench, the actuator and the date
UNIT = "unit"  # optional key of the record KIND: actuator
DATE = "date"  # optional key of the record KIND: date of the log (ISO 8601)
COLUMNS = "columns"  # metadata record: MESSAGE PATH -> raw column from which the signal was made

RECORD_HEAD = 9  # bytes of a record's head: opcode (1), length (8)
MESSAGE_OPCODE = 0x05
CDR_HEAD = 0x00000100  # bytes 00 01 00 00: plain CDR, little-endian
NS = 1_000_000_000
LATEST = 9_000_000_000.0  # s, latest time; its value in ns fits 63 bits

# names of fields and topics that ROS 2 accepts
FIELD_NAME = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")
TOPIC = re.compile(r"/(axis|mechanism)(/[A-Za-z_][A-Za-z0-9_]*)*")
_FIELD_LINE = re.compile(r"float64[ \t]+([A-Za-z][A-Za-z0-9_]*)")

Records = NDArray[np.void]


@dataclass(frozen=True)
class StreamHeader:
    """Topic, fields and units of a stream, in the order of the file."""

    topic: str
    fields: tuple[str, ...]
    units: tuple[str, ...]

    def __post_init__(self) -> None:
        if not TOPIC.fullmatch(self.topic):
            raise ValueError(
                f"topic: found {self.topic!r}; allowed: /axis, /axis/NAME or /mechanism, "
                "NAME of letters, digits and _"
            )
        for name in self.fields:
            if not FIELD_NAME.fullmatch(name):
                raise ValueError(
                    f"signal: found {name!r}; allowed: lower-case letters, digits and single _"
                )


def message_dtype(fields: int) -> np.dtype[np.void]:
    """Return the dtype of a message with `fields` float64 values, as stored in a chunk."""
    return np.dtype(
        [
            ("opcode", "u1"),
            ("length", "<u8"),
            ("channel", "<u2"),
            ("sequence", "<u4"),
            ("log_time", "<u8"),
            ("publish_time", "<u8"),
            ("cdr", "<u4"),
            ("values", "<f8", (fields,)),
        ]
    )


def schema_text(fields: tuple[str, ...]) -> str:
    r"""Return the `ros2msg` definition of a message with these fields.

    >>> schema_text(("position", "current"))
    'float64 position\nfloat64 current\n'
    """
    return "".join(f"float64 {name}\n" for name in fields)


def schema_fields(text: str) -> tuple[str, ...] | None:
    """Return the field names in a `ros2msg` text; None if a field is not float64 or is repeated."""
    lines = [line.partition("#")[0].strip() for line in text.splitlines()]
    matches = [_FIELD_LINE.fullmatch(line) for line in lines if line]
    names = tuple(match.group(1) for match in matches if match)
    return names if names and len(names) == len(matches) == len(set(names)) else None


def message_path(topic: str, field: str) -> str:
    """Return topic and field joined to one path, such as `/axis.position`."""
    return f"{topic}.{field}"
