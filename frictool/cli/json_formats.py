"""Formats of the JSON objects that commands print with --json, read from json_formats.yaml."""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path
from typing import Any, Literal

import msgspec
import yaml

KINDS: dict[str, Any] = {
    "text": str,
    "whole": int,
    "number": float,
    "flag": bool,
    "object": dict[str, Any],
    "any": Any,
}


@cache
def json_formats() -> dict[str, Any]:
    """Map each format with its version, such as "report/2", to the keys of its JSON objects."""
    text = Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8")
    return {name: keys for name, keys in yaml.safe_load(text).items() if "/" in name}


def format_names() -> dict[str, str]:
    """Map each format to the format with its version, as in {"report": "report/2"}."""
    return {name.partition("/")[0]: name for name in json_formats()}


def json_type(name: str) -> Any:
    """Return the msgspec type of the objects of a format, such as "report/2"."""
    title = name.partition("/")[0].title().replace("-", "")
    return _type(title, {"format": name, **json_formats()[name]})


def json_format_schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a format, such as "report/2".

    The schema allows additional keys, because later releases may add keys.
    """
    schema = msgspec.json.schema(json_type(name))
    for one in schema["$defs"].values():
        if one.get("additionalProperties") is False:
            del one["additionalProperties"]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _type(title: str, kind: Any) -> Any:
    if isinstance(kind, list):
        return list[_type(title, kind[0])]  # type: ignore[misc]  # made at run time
    if isinstance(kind, dict) and "*" in kind:
        return dict[str, _type(title, kind["*"])]  # type: ignore[misc]  # made at run time
    if isinstance(kind, dict):
        return _record(title, kind)
    base = kind.removesuffix("~")
    value_type = KINDS.get(base) or Literal[tuple(base.split(" | "))]
    return value_type if base == kind else value_type | None


def _record(title: str, keys: dict[str, Any]) -> Any:
    fields: list[Any] = []
    for names, kind in keys.items():
        for marked in names.split():
            name = marked.rstrip("~+")
            field_type = _type(title + name.title().replace("_", "").replace(".", ""), kind)
            field_type = field_type | None if "~" in marked else field_type
            field = (
                (field_type | msgspec.UnsetType, msgspec.UNSET) if "+" in marked else (field_type,)
            )
            fields += [(key, *field) for key in (_registered(name) if "." in name else [name])]
    return msgspec.defstruct(title, fields, kw_only=True, forbid_unknown_fields=True)


def _registered(name: str) -> list[str]:
    module, _, registry = name.rpartition(".")
    return list(getattr(importlib.import_module(f"frictool.{module}"), registry))
