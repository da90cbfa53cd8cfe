"""Fields of document types. They are looked up once per type, because a lookup is slow."""

from __future__ import annotations

import functools
import typing
from typing import Any

import msgspec


@functools.cache
def fields_of(kind: type[msgspec.Struct]) -> tuple[msgspec.structs.FieldInfo, ...]:
    """Return the fields of a document type, in the order of their definition."""
    return msgspec.structs.fields(kind)


@functools.cache
def hints_of(kind: type[msgspec.Struct]) -> dict[str, Any]:
    """Return the type of each field, including its metadata."""
    return typing.get_type_hints(kind, include_extras=True)
