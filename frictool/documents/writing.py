"""Deterministic writing of documents as YAML."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import yaml

from frictool.documents.yaml_scalars import Dumper
from frictool.errors import OutputError
from frictool.runtime.part_files import part_file

FLOW_WIDTH = 110


class _Dumper(Dumper):
    """Dumper with short lists and quantities on one line, and with shortest exact floats."""


def _float(dumper: yaml.SafeDumper, value: float) -> yaml.Node:
    return dumper.represent_scalar("tag:yaml.org,2002:float", repr(value))


def _text(dumper: yaml.SafeDumper, value: str) -> yaml.Node:
    # only double quotes escape unprintable characters
    return dumper.represent_scalar(
        "tag:yaml.org,2002:str", value, style=None if value.isprintable() else '"'
    )


def _mapping(dumper: yaml.SafeDumper, value: dict[str, Any]) -> yaml.Node:
    node = dumper.represent_mapping("tag:yaml.org,2002:map", value.items())
    node.flow_style = _is_short(value)
    return node


def _sequence(dumper: yaml.SafeDumper, value: list[Any]) -> yaml.Node:
    node = dumper.represent_sequence("tag:yaml.org,2002:seq", value)
    node.flow_style = all(not isinstance(item, list | dict) for item in value)
    return node


def _is_short(value: dict[str, Any]) -> bool:
    if not value or any(isinstance(item, list | dict) for item in value.values()):
        return not value
    return sum(len(key) + len(str(item)) + 4 for key, item in value.items()) <= FLOW_WIDTH


_Dumper.add_representer(float, _float)
_Dumper.add_representer(str, _text)
_Dumper.add_representer(dict, _mapping)
_Dumper.add_representer(list, _sequence)
_Dumper.ignore_aliases = lambda self, data: True  # type: ignore[method-assign]  # no anchors


def to_yaml(document: msgspec.Struct) -> str:
    """Return the YAML text of a document.

    The keys have the order of the document's type. Optional keys without a value are omitted.
    Scalars of NumPy, which a caller in Python may have used, are written as Python numbers.
    """
    tree: dict[str, Any] = drop_unset(msgspec.to_builtins(document, enc_hook=_python_number))
    return tree_to_yaml(tree)


def _python_number(value: Any) -> Any:
    """Return a scalar of NumPy as a Python number; raise TypeError for another object."""
    if not hasattr(value, "item"):
        raise TypeError(f"a document cannot contain {value!r}, of type {type(value).__name__}")
    return value.item()


def save(document: msgspec.Struct, path: Path | str) -> None:
    """Write a document to a file, completely or not at all.

    Parameters
    ----------
    document : msgspec.Struct
        Document of any type.
    path : Path or str
        The file to write.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    path = Path(path)
    text = to_yaml(document)
    try:
        with part_file(path) as stream:
            stream.write(text.encode())
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None


def tree_to_yaml(tree: dict[str, Any]) -> str:
    """Return the YAML text of mappings, lists and scalars; the keys keep their order."""
    return yaml.dump(tree, Dumper=_Dumper, sort_keys=False, width=10_000, allow_unicode=True)


def drop_unset(value: Any) -> Any:
    """Return nested mappings and lists without keys whose value is None."""
    if isinstance(value, dict):
        return {key: drop_unset(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [drop_unset(item) for item in value]
    return value
