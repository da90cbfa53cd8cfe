"""Reading of YAML nodes (mappings, lists and scalars); each error names file, line and key.

The error for a misspelt name suggests the nearest known name.
"""

from __future__ import annotations

import difflib
import math
import typing
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import msgspec
import yaml

from frictool.documents.name_list import listed
from frictool.errors import DocumentError

MAX_KEY = 200  # characters, longest name of a key
LONGEST_ALLOWED = 100  # characters of the allowed keys in a message
Pairs = dict[str, tuple[yaml.Node, yaml.Node]]  # key -> (node of the key, node of the value)


class NodeReader:
    """Reader of the nodes of one file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def fail(self, node: yaml.Node, key: str, message: str) -> typing.NoReturn:
        """Raise DocumentError with file, line and key of `node`."""
        raise DocumentError(self.path, message, line=node.start_mark.line + 1, key=key)

    def pairs(self, node: yaml.Node, key: str) -> Pairs:
        """Return (node of the key, node of the value) for each key of a mapping.

        Raises DocumentError if the node is not a mapping, or if a key is not a text, is too long,
        or occurs twice.

        - key: path of the mapping
        """
        if not isinstance(node, yaml.MappingNode):
            self.fail(node, key, f"found {shown(node)}; allowed: a mapping of keys")
        pairs: Pairs = {}
        for name_node, value_node in node.value:
            if not isinstance(name_node, yaml.ScalarNode):
                self.fail(name_node, key, "found a key that is not text; allowed: plain names")
            name = name_node.value
            if len(name) > MAX_KEY:
                self.fail(
                    name_node,
                    key,
                    f"found a key of {len(name)} characters; allowed: at most {MAX_KEY}",
                )
            if name in pairs:
                self.fail(
                    name_node,
                    join(key, name),
                    f"found twice, first in line {pairs[name][0].start_mark.line + 1}; keep one",
                )
            pairs[name] = (name_node, value_node)
        return pairs

    def check_known(self, pairs: Pairs, names: list[str], key: str) -> None:
        """Raise DocumentError for the first key in `pairs` that is not in `names`."""
        for name, (name_node, _) in pairs.items():
            if name not in names:
                self.fail(
                    name_node,
                    join(key, name),
                    f"unknown key{suggestion(name, names)}; allowed: "
                    f"{listed(names, LONGEST_ALLOWED)}",
                )

    def items(self, node: yaml.Node, meta: list[msgspec.Meta], key: str) -> list[yaml.Node]:
        """Return the nodes of a list; raise DocumentError if the list is too long or too short."""
        if not isinstance(node, yaml.SequenceNode):
            self.fail(node, key, f"found {shown(node)}; allowed: a list")
        for item in meta:
            least = item.min_length or 0
            most = item.max_length
            count = len(node.value)
            if count < least or (most is not None and count > most):
                allowed = (
                    f"at least {least}"
                    if most is None
                    else f"at most {most}"
                    if count > most
                    else f"{least} to {most}"
                )
                self.fail(node, key, f"found a list of {count}; allowed: {allowed}")
        return list(node.value)

    def plain(self, node: yaml.Node, key: str) -> Any:
        """Return a scalar as number, bool, None or text, according to the rules of YAML 1.2."""
        if not isinstance(node, yaml.ScalarNode):
            self.fail(node, key, f"found {shown(node)}; allowed: a single value")
        tag = node.tag.rpartition(":")[2]
        if tag == "float":
            lowered = node.value.lower()
            return math.nan if "nan" in lowered else float(lowered.replace(".inf", "inf"))
        if tag == "int":
            return int(node.value) if len(node.value) < 400 else math.inf
        if tag == "bool":
            return node.value == "true"
        return None if tag == "null" else node.value

    def scalar(self, node: yaml.Node, kind: Any, meta: list[msgspec.Meta], key: str) -> Any:
        """Return a scalar as type `kind`.

        Raises DocumentError if the scalar has another type or is outside the limits `meta`.
        """
        value = self.plain(node, key)
        if (
            kind is str
            and value is not None
            and not isinstance(value, str)
            and isinstance(node, yaml.ScalarNode)
        ):
            value = node.value  # text that looks like another type, such as the name 12 or true
        if kind is float and isinstance(value, float | int) and not isinstance(value, bool):
            try:
                finite = math.isfinite(value)
            except OverflowError:
                finite = False
            if not finite:
                self.fail(node, key, f"found {shown(node)}; allowed: a finite number")
        whole = typing.Annotated[kind, *meta] if meta else kind
        try:
            return msgspec.convert(value, whole, strict=True)
        except msgspec.ValidationError:
            self.fail(
                node,
                key,
                f"found {shown(node)}; allowed: "
                f"{allowed_values(kind, meta)}{_nearest_choice(kind, value)}",
            )


def join(key: str, name: str) -> str:
    """Return the path of the entry `name` in the mapping at the path `key`, such as `key.name`."""
    return f"{key}.{name}" if key else name


def shown(node: yaml.Node) -> str:
    """Return the content of a node as short text for an error message."""
    if isinstance(node, yaml.ScalarNode):
        text = node.value if len(node.value) <= 60 else node.value[:57] + "..."
        return repr(text) if node.tag.endswith(":str") else (text or "nothing")
    return "a mapping" if isinstance(node, yaml.MappingNode) else "a list"


def suggestion(name: str, known: list[str]) -> str:
    """Return a hint with the known name that is nearest to `name`; empty if no name is near.

    The hint is also empty if only one name is known, because the message states this name anyway.
    """
    near = [] if len(known) == 1 else difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f", did you mean {near[0]!r}?" if near else ""


def _nearest_choice(kind: Any, value: Any) -> str:
    if get_origin(kind) is Literal and isinstance(value, str):
        return suggestion(value, [str(choice) for choice in get_args(kind)])
    return ""


def type_name(kind: Any) -> str:
    """Return the name of a type for an error message."""
    if get_origin(kind) is Literal:
        return " | ".join(str(choice) for choice in get_args(kind))
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return "a mapping"
    return {float: "a number", int: "a whole number", str: "text", bool: "true or false"}.get(
        kind, str(kind)
    )


def allowed_values(kind: Any, meta: list[msgspec.Meta]) -> str:
    """Return type and limits of a scalar as text for an error message."""
    limits: list[str] = []
    for item in meta:
        bounds = ((">", item.gt), (">=", item.ge), ("<", item.lt), ("<=", item.le))
        limits += [f"{relation} {bound:g}" for relation, bound in bounds if bound is not None]
        lengths = (("at least", item.min_length), ("at most", item.max_length))
        limits += [
            f"{relation} {length} character{'s' if length > 1 else ''}"
            for relation, length in lengths
            if length is not None
        ]
        limits += [f"the form {item.pattern}"] if item.pattern is not None else []
    return (
        f"{type_name(kind)}{' of' if kind is str and limits else ''} {' and '.join(limits)}"
    ).rstrip()
