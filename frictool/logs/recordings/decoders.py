"""Choice of the decoder of a topic, by the encoding of its messages."""

from __future__ import annotations

from pathlib import Path

from frictool.errors import LogError
from frictool.logs.raw_table import excerpt
from frictool.logs.recordings.cdr import MessageDecoder
from frictool.logs.recordings.json_messages import JsonDecoder
from frictool.logs.recordings.protobuf_messages import protobuf_decoder
from frictool.logs.recordings.recording import Decoder, Topic
from frictool.logs.recordings.ros_definitions import DEFINITIONS
from frictool.logs.recordings.ros_idl import parse_idl
from frictool.logs.recordings.ros_message import parse_message, short_name


def topic_of(
    path: Path, name: str, kind: str, encoding: str, form: str, definition: bytes
) -> Topic:
    """Return the topic `name`, which has messages of the type `kind`.

    path: recording.
    encoding: encoding of the messages (`cdr`, `ros1`, `json`, `protobuf`).
    form: language of the definition, such as `ros2msg`.
    definition: definition of the type; empty if the recording has none.

    If the messages cannot be decoded, the topic's `refused` states the reason.
    """
    try:
        return Topic(name, kind, _decoder(path, kind, encoding, form, definition))
    except LogError as error:  # a library is missing; reported if the topic is requested
        return Topic(name, kind, refused=str(error).removeprefix(f"{path}: "))
    except (ValueError, RecursionError) as error:
        return Topic(
            name,
            kind,
            refused=f"the definition of {kind or 'its messages'} cannot be read: "
            f"{excerpt(str(error))}",
        )


def _decoder(path: Path, kind: str, encoding: str, form: str, definition: bytes) -> Decoder:
    if encoding == "json":
        return JsonDecoder()
    if encoding == "protobuf":
        return protobuf_decoder(path, kind, definition)
    if encoding not in ("cdr", "ros1"):
        raise ValueError(f"encoding {encoding!r}; allowed: cdr, ros1, json, protobuf")
    text = definition.decode("utf-8", "replace")
    if form in ("ros2idl", "omgidl"):
        return MessageDecoder(parse_idl(kind, text))
    if not text.strip() and form in ("", "ros2msg"):  # older recorders omit the definition
        if short_name(kind) not in DEFINITIONS:
            raise ValueError("the recording lacks it, and frictool knows only common types")
        text = DEFINITIONS[short_name(kind)]
    return MessageDecoder(parse_message(kind, text), aligned=encoding == "cdr")
