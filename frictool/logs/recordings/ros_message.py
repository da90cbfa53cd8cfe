"""Parser of ROS message definitions (`ros2msg`, `ros1msg`) into a tree of fields.

A definition is a text that defines a type and all types that this type contains.

    float64[] position        # a sequence; float64[6] is an array of fixed length; float64[<=6] has
                              # the same bytes as float64[]
    std_msgs/Header header    # a nested message, defined after a line of ===
"""

from __future__ import annotations

import re
from typing import Literal, NamedTuple

DEEPEST = 32  # maximum depth of nested messages
MOST_FIELDS = 20_000  # maximum number of fields of a message and its nested messages
NUMBERS = {
    "bool": "u1",
    "byte": "u1",
    "char": "u1",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float32": "f4",
    "float64": "f8",
}
TEXTS = ("string", "wstring")
WELL_KNOWN = {  # types that definitions use without defining them
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec\n",
    "time": "uint32 sec\nuint32 nanosec\n",  # ROS 1, as is `duration`
    "duration": "int32 sec\nint32 nanosec\n",
}

_SEPARATOR = re.compile(r"^=+[ \t\r]*\nMSG: *(\S+)[^\n]*$", re.MULTILINE)
_FIELD = re.compile(r"\s*([\w/]+)(?:<=\d+)?(\[(?:<=)?\d*\])?\s+(\w+)\s*(=?)", re.ASCII)

Repeat = Literal["once", "fixed", "sequence"]


class MessageType(NamedTuple):
    """Message type with its fields in order."""

    name: str
    fields: tuple[MessageField, ...]


class MessageField(NamedTuple):
    """Field of a message.

    kind: type of a number (key of NUMBERS), of a text (one of TEXTS), or of a nested message.
    repeat: "once" for a single value, "fixed" for an array of fixed length, "sequence" for an array
        of variable length.
    size: length of an array of fixed length, else 0.
    """

    name: str
    kind: str | MessageType
    repeat: Repeat = "once"
    size: int = 0


# message -> (name, kind, repeat, size) of each field
Definitions = dict[str, list[tuple[str, str, Repeat, int]]]


def parse_message(name: str, text: str) -> MessageType:
    """Return the message type `name`, such as `sensor_msgs/msg/JointState`, from a definition.

    Raises ValueError if a line is not a field, or if a nested message is not defined.
    """
    main = short_name(name)
    parts = _SEPARATOR.split(text)
    definitions: Definitions = {known: _fields(known, lines) for known, lines in WELL_KNOWN.items()}
    for part, lines in zip([main, *map(short_name, parts[1::2])], parts[0::2], strict=True):
        definitions[part] = _fields(part, lines)
    return assembled(main, definitions)


def short_name(name: str) -> str:
    """Return the name of a message type without `msg/`.

    >>> short_name("sensor_msgs/msg/JointState")
    'sensor_msgs/JointState'
    """
    return name.replace("/msg/", "/")


def assembled(name: str, definitions: Definitions) -> MessageType:
    """Return the message type `name` with all nested message types.

    Raises ValueError if a nested message is not defined, or if the tree is too deep or too large.
    """
    left = MOST_FIELDS

    def build(name: str, depth: int) -> MessageType:
        nonlocal left
        if name not in definitions:
            raise ValueError(f"message {name!r} is used but not defined")
        left -= len(definitions[name])
        if depth > DEEPEST or left < 0:
            raise ValueError(
                f"message {name!r} is nested in more than {DEEPEST} messages, or contains more "
                f"than {MOST_FIELDS} fields"
            )
        fields = (
            MessageField(
                field,
                kind if kind in NUMBERS or kind in TEXTS else build(kind, depth + 1),
                repeat,
                size,
            )
            for field, kind, repeat, size in definitions[name]
        )
        return MessageType(name, tuple(fields))

    return build(name, 0)


def _fields(message: str, lines: str) -> list[tuple[str, str, Repeat, int]]:
    parsed: list[tuple[str, str, Repeat, int]] = []
    for line in lines.splitlines():
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        match = _FIELD.match(line)
        if match is None:
            raise ValueError(f"message {message!r}: {line.strip()[:60]!r} is not a field")
        kind, array, name, constant = match.groups()
        if constant:
            continue
        fixed = array[1:-1].isdigit() if array else False
        repeat: Repeat = "once" if not array else "fixed" if fixed else "sequence"
        parsed.append(
            (name, _full_name(kind, message), repeat, int(array[1:-1]) if array and fixed else 0)
        )
    return parsed


def _full_name(kind: str, message: str) -> str:
    if kind in NUMBERS or kind in TEXTS:
        return kind
    if kind in WELL_KNOWN:
        return kind
    if kind == "Header":  # in ROS 1, independent of the package
        return "std_msgs/Header"
    package = message.rpartition("/")[0]
    return short_name(kind) if "/" in kind else f"{package}/{kind}"
