"""Decoder of protobuf messages, which a FileDescriptorSet in the recording defines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from frictool.logs.optional_libraries import library
from frictool.logs.recordings.object_decoder import ObjectDecoder

EXTRA = "protobuf"


def protobuf_decoder(path: Path, kind: str, definition: bytes) -> ObjectDecoder:
    """Return the decoder of messages of the type `kind`.

    path: recording.
    definition: serialised FileDescriptorSet.

    Raises LogError if the library protobuf is missing. Raises ValueError if the descriptors are
    damaged, or do not contain the type.
    """
    descriptors, message, factory, pools = (
        library(path, f"google.protobuf.{name}", EXTRA)
        for name in ("descriptor_pb2", "message", "message_factory", "descriptor_pool")
    )
    try:
        files = descriptors.FileDescriptorSet.FromString(definition)
        pool = pools.DescriptorPool()
        _add(pool, {file.name: file for file in files.file})
        Message = factory.GetMessageClass(pool.FindMessageTypeByName(kind))
    except (message.DecodeError, TypeError, KeyError, ValueError):
        raise ValueError("its descriptors are damaged or do not contain the type") from None

    def objects(data: bytes) -> object:
        try:
            return _mapping(Message.FromString(data))
        except (message.DecodeError, UnicodeDecodeError) as error:
            raise ValueError(f"is not a {kind} ({' '.join(str(error).split())})") from None

    return ObjectDecoder(objects)


def _add(pool: Any, files: dict[str, Any]) -> None:
    while files:
        name = next(
            (
                name
                for name, file in files.items()
                if not any(other in files for other in file.dependency)
            ),
            None,
        )
        if name is None:
            raise ValueError("its descriptor files import each other in a circle")
        pool.Add(files.pop(name))


def _mapping(message: Any) -> dict[str, object]:
    """Return a message as a mapping of its fields.

    A field that is not set is omitted if it is optional or a nested message; otherwise it has its
    default value.
    """
    values: dict[str, object] = {}
    for field in message.DESCRIPTOR.fields:
        if field.has_presence and not message.HasField(field.name):
            continue
        value = getattr(message, field.name)
        if field.message_type is None:
            values[field.name] = list(value) if field.is_repeated else value
        elif field.message_type.GetOptions().map_entry:
            values[field.name] = {
                str(key): value[key]
                if field.message_type.fields_by_name["value"].message_type is None
                else _mapping(value[key])
                for key in value
            }
        else:
            values[field.name] = (
                [_mapping(one) for one in value] if field.is_repeated else _mapping(value)
            )
    return values
