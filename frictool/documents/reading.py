"""Strict reading of a YAML document into its type.

The text is parsed to nodes, so that every error message names the line. The nodes are walked along
the type, so that every message names the key, the value found and the allowed values. For a
misspelt key it suggests the nearest known name.
"""

from __future__ import annotations

import difflib
import itertools
import math
import types
import typing
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin

import msgspec
import yaml

from frictool.documents import yaml_parser
from frictool.documents.quantity import (
    CHOICES,
    Axis,
    Quantity,
    Series,
    Span,
    chosen_dimension,
    factor_to_si,
    si_unit,
)
from frictool.documents.quantity_notation import (
    UNKNOWN,
    axis_dimension,
    example_unit,
    quantity_form,
    written_quantity,
)
from frictool.errors import DocumentError, InputFileError

MAX_BYTES = 2_000_000
MAX_KEY = 200  # characters, longest name of a key
Pairs = dict[str, tuple[yaml.Node, yaml.Node]]  # key -> (node of the key, node of the value)

# advice if the file is a mechanism and one of these is expected
OF_A_MECHANISM = {
    "Model": "reduce it first: frictool reduce {path} -o model.yaml",
    "Bench": (
        "a model has its bench: frictool reduce {path} -o model.yaml writes both; or write "
        "a bench.yaml (frictool init)"
    ),
}


def read_text(path: Path) -> str:
    """Return the text of a document file. Raises InputFileError if it cannot be read as text."""
    try:
        if path.is_dir():
            raise InputFileError(path, "is a directory; a YAML document is expected")
        if not path.is_file() and path.exists():
            raise InputFileError(path, "is not a regular file; a YAML document is expected")
        if path.stat().st_size > MAX_BYTES:
            raise InputFileError(
                path,
                f"has {path.stat().st_size} bytes; allowed: {MAX_BYTES}; a YAML "
                "document is expected",
            )
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputFileError(path, "no such file") from None
    except OSError as error:
        raise InputFileError(path, f"cannot be read: {error.strerror}") from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputFileError(
            path, f"is not text (byte {error.start} is not UTF-8); a YAML document is expected"
        ) from None
    if not text.strip():
        raise InputFileError(path, "is empty; a YAML document is expected")
    return text


def compose(text: str, path: Path) -> yaml.Node:
    """Return the node tree of a document.

    Raises InputFileError with the line of the first syntax error.
    """
    try:
        node = yaml_parser.compose(text)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = (
            _problem(error)
            if isinstance(error, yaml_parser.RefusedYaml)
            else f"not valid YAML: {_problem(error)}"
        )
        raise InputFileError(path, problem, line=None if mark is None else mark.line + 1) from None
    except (yaml.YAMLError, ValueError) as error:
        raise InputFileError(path, f"not valid YAML: {str(error).splitlines()[0]}") from None
    except RecursionError:
        raise InputFileError(path, "not valid YAML: nested too deeply") from None
    if node is None:
        raise InputFileError(path, "is empty; a YAML document is expected")
    return node


def _problem(error: yaml.MarkedYAMLError) -> str:
    """Return the parser's problem, in plain words for a tab and for a second document."""
    problem = error.problem or error.context or "?"
    if "'\\t'" in problem:
        return "found a tab; indent with spaces"
    return (
        "found a second document, after ---; one file is one document"
        if "another document" in problem
        else problem
    )


class DocumentReader:
    """Reader of nodes along a type.

    It keeps the axis and the drive that the document has stated so far, because units depend on
    them.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.axis: Axis = "rotary"
        self.drive: Literal["current", "voltage"] = "current"

    def fail(self, node: yaml.Node, key: str, message: str) -> typing.NoReturn:
        """Raise DocumentError with file, line and key of `node`."""
        raise DocumentError(self.path, message, line=node.start_mark.line + 1, key=key)

    def read(self, node: yaml.Node, kind: Any, key: str) -> Any:
        """Return the value of `node` as the document type `kind`."""
        meta: list[msgspec.Meta] = []
        origin = get_origin(kind)
        if origin is typing.Annotated:
            kind, *extra = get_args(kind)
            meta = [m for m in extra if isinstance(m, msgspec.Meta)]
            origin = get_origin(kind)
        if origin in (Union, types.UnionType):
            return self._optional(node, kind, meta, key)
        if isinstance(kind, type) and issubclass(kind, Quantity | Span):
            return self._quantity(node, kind, meta, key)
        if kind is Series:
            return self._series(node, meta, key)
        if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
            return self._struct(node, kind, key)
        if origin is tuple:
            return self._sequence(node, get_args(kind)[0], meta, key)
        if origin is dict:
            names, values = get_args(kind)
            return self._mapping(node, names, values, key)
        return self._scalar(node, kind, meta, key)

    def _optional(self, node: yaml.Node, kind: Any, meta: list[msgspec.Meta], key: str) -> Any:
        members = [member for member in get_args(kind) if member is not type(None)]
        if (
            type(None) in get_args(kind)
            and isinstance(node, yaml.ScalarNode)
            and node.tag == "tag:yaml.org,2002:null"
        ):
            return None
        if len(members) == 1:
            member = typing.Annotated[members[0], *meta] if meta else members[0]
            return self.read(node, member, key)
        if all(
            isinstance(member, type) and issubclass(member, msgspec.Struct) for member in members
        ):
            return self._tagged(node, members, key)
        scalar_members = [member for member in members if member in (str, int, float, bool)]
        value = self._plain(node, key) if isinstance(node, yaml.ScalarNode) else None
        if type(value) not in scalar_members:
            self.fail(
                node,
                key,
                f"found {_shown(node)}; allowed: {' or '.join(_type_name(m) for m in members)}",
            )
        return value

    def _tagged(self, node: yaml.Node, members: list[type[msgspec.Struct]], key: str) -> Any:
        """Return one of several structs, selected by its tag field."""
        kinds = {str(member.__struct_config__.tag): member for member in members}
        field = str(members[0].__struct_config__.tag_field)
        pairs = self._pairs(node, key)
        if field not in pairs:
            self.fail(node, _join(key, field), f"missing; allowed: {', '.join(kinds)}")
        tag_value = str(self._plain(pairs[field][1], _join(key, field)))
        if tag_value not in kinds:
            self.fail(
                pairs[field][1],
                _join(key, field),
                f"found {tag_value!r}{_suggest(tag_value, list(kinds))}; "
                f"allowed: {', '.join(kinds)}",
            )
        return self._struct(node, kinds[tag_value], key)

    def _series(self, node: yaml.Node, meta: list[msgspec.Meta], key: str) -> Series:
        extra = next((m.extra for m in meta if m.extra), {"dimension": "any"})
        pairs = self._quantity_pairs(node, Series, str(extra["dimension"]), key)
        unit = self.read(pairs["unit"][1], str, _join(key, "unit"))
        factor, si = self._factor(
            pairs["unit"][1], unit, str(extra["dimension"]), _join(key, "unit")
        )
        values = self._sequence(pairs["values"][1], float, [], _join(key, "values"))
        return Series(tuple(value * factor for value in values), si)

    def _struct(self, node: yaml.Node, kind: type[msgspec.Struct], key: str) -> Any:
        fields = {field.encode_name: field for field in msgspec.structs.fields(kind)}
        hints = typing.get_type_hints(kind, include_extras=True)
        present = self._pairs(node, key)
        tag = kind.__struct_config__.tag_field
        if tag is not None:  # the tag has selected the struct already
            present = {name: pair for name, pair in present.items() if name != tag}
        if (
            "format" in present and "format" in fields
        ):  # check the format first: in a document of another kind every key is unknown
            self._refuse_mechanism(present["format"][1], kind, _join(key, "format"))
            self.read(present["format"][1], hints["format"], _join(key, "format"))
        elif "format" in fields:
            self._missing(node, "format", fields, hints, key)
        self._known(present, list(fields), key)
        values: dict[str, Any] = {}
        # the axis and its drive decide the units of the rest: read them first
        for name in sorted(present, key=lambda n: n not in ("axis", "actuator", "bench", "drive")):
            value = self.read(present[name][1], hints[fields[name].name], _join(key, name))
            if name == "axis":
                self.axis = value
            if name == "drive" and not isinstance(value, float):  # `rest` has a limit of this name
                self.drive = value
            values[fields[name].name] = value
        for name, field in fields.items():
            if field.required and name not in present and type(None) in get_args(hints[field.name]):
                values[field.name] = None  # writing omits None
            elif field.required and name not in present:
                self._missing(node, name, fields, hints, key)
        try:
            return kind(**values)
        except ValueError as error:
            self.fail(node, key or kind.__name__.lower(), str(error))

    def _missing(
        self, node: yaml.Node, name: str, fields: dict[str, Any], hints: dict[str, Any], key: str
    ) -> typing.NoReturn:
        value = hints[fields[name].name]
        example = (
            ""
            if key
            else f"; write {name}: {_type_name(value) if get_origin(value) is Literal else '...'}"
        )
        self.fail(
            node,
            _join(key, name),
            (
                f"missing{example}; required: "
                f"{', '.join((n for n, f in fields.items() if f.required))}"
            ),
        )

    def _known(self, pairs: Pairs, names: list[str], key: str) -> None:
        for name, (name_node, _) in pairs.items():
            if name not in names:
                self.fail(
                    name_node,
                    _join(key, name),
                    f"unknown key{_suggest(name, names)}; allowed: {', '.join(names)}",
                )

    def _pairs(self, node: yaml.Node, key: str) -> Pairs:
        if not isinstance(node, yaml.MappingNode):
            self.fail(node, key, f"found {_shown(node)}; allowed: a mapping of keys")
        pairs: Pairs = {}
        for name_node, value_node in node.value:
            if not isinstance(name_node, yaml.ScalarNode):
                self.fail(name_node, key, "found a key that is not text; allowed: plain names")
            name = name_node.value
            if len(name) > MAX_KEY:
                self.fail(
                    name_node, key, f"found a key of {len(name)} characters; allowed: {MAX_KEY}"
                )
            if name in pairs:
                self.fail(
                    name_node,
                    _join(key, name),
                    f"found twice, first in line {pairs[name][0].start_mark.line + 1}; keep one",
                )
            pairs[name] = (name_node, value_node)
        return pairs

    def _mapping(self, node: yaml.Node, names: Any, kind: Any, key: str) -> dict[str, Any]:
        pairs = self._pairs(node, key)
        if get_origin(names) is Literal:
            self._known(pairs, list(get_args(names)), key)
        return {
            name: self.read(value, kind, _join(key, name)) for name, (_, value) in pairs.items()
        }

    def _refuse_mechanism(self, node: yaml.Node, kind: type[msgspec.Struct], key: str) -> None:
        """Raise an error for a mechanism and name the command that makes the expected document."""
        tried = OF_A_MECHANISM.get(kind.__name__)
        if tried is not None and isinstance(node, yaml.ScalarNode) and node.value == "mechanism/1":
            self.fail(
                node,
                key,
                f"found 'mechanism/1'; allowed: {kind.__name__.lower()}/1; "
                f"{tried.format(path=self.path)}",
            )

    def _sequence(
        self, node: yaml.Node, kind: Any, meta: list[msgspec.Meta], key: str
    ) -> tuple[Any, ...]:
        if not isinstance(node, yaml.SequenceNode):
            self.fail(node, key, f"found {_shown(node)}; allowed: a list")
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
        return tuple(
            self.read(item, kind, f"{key}[{index}]") for index, item in enumerate(node.value)
        )

    def _quantity(
        self, node: yaml.Node, kind: type[Quantity | Span], meta: list[msgspec.Meta], key: str
    ) -> Any:
        extra = next((m.extra for m in meta if m.extra), {"dimension": "any"})
        pairs = self._quantity_pairs(node, kind, str(extra["dimension"]), key)
        fields = {field.name: field for field in msgspec.structs.fields(kind)}
        unit = self.read(pairs["unit"][1], str, _join(key, "unit"))
        factor, si = self._factor(
            pairs["unit"][1], unit, str(extra["dimension"]), _join(key, "unit")
        )
        numbers: dict[str, float] = {
            name: self.read(pairs[name][1], float, _join(key, name)) * factor
            for name in ("value", "low", "high")
            if name in pairs
        }
        self._in_range(pairs, numbers, unit, extra, key)
        others = {
            name: self.read(pairs[name][1], fields[name].type, _join(key, name))
            for name in pairs
            if name not in (*numbers, "unit")
        }
        return kind(**numbers, **others, unit=si)

    def _quantity_pairs(
        self, node: yaml.Node, kind: type[msgspec.Struct], dimension: str, key: str
    ) -> Pairs:
        """Return the keys of a quantity, span or series.

        Error messages show its form with a suitable unit.
        """
        fields = {field.name: field for field in msgspec.structs.fields(kind)}
        required = [name for name, field in fields.items() if field.required or name == "unit"]
        if not isinstance(node, yaml.MappingNode):
            written = written_quantity(node.value) if isinstance(node, yaml.ScalarNode) else None
            number, unit = written or (UNKNOWN, "")
            form = quantity_form(
                required,
                {"value": number, "unit": example_unit(dimension, self.axis, self.drive, unit)},
            )
            self.fail(
                node, key, f"found {_shown(node)}; allowed: a mapping with a unit; write {form}"
            )
        pairs = self._pairs(node, key)
        self._known(pairs, list(fields), key)
        for name in required:
            if name not in pairs:
                present = {
                    other: pair[1].value
                    for other, pair in pairs.items()
                    if isinstance(pair[1], yaml.ScalarNode)
                }
                form = quantity_form(
                    required, {"unit": example_unit(dimension, self.axis, self.drive)} | present
                )
                self.fail(node, _join(key, name), f"missing; allowed: {form}")
        return pairs

    def _in_range(
        self, pairs: Pairs, numbers: dict[str, float], unit: str, extra: dict[str, Any], key: str
    ) -> None:
        minimum = extra.get("minimum")
        exclusive = bool(extra.get("exclusive"))
        for name, number in numbers.items():
            if minimum is not None and (number < minimum or (exclusive and number == minimum)):
                finding = f"found {_shown(pairs[name][1])} {unit}"
                self.fail(
                    pairs[name][1],
                    _join(key, name),
                    f"{finding}; allowed: {'>' if exclusive else '>='} {minimum:g}",
                )
        order = [name for name in ("low", "value", "high") if name in numbers]
        for below, above in itertools.pairwise(order):
            if numbers[below] > numbers[above]:
                low, high = pairs[below][1], pairs[above][1]
                self.fail(
                    low,
                    _join(key, below),
                    f"found {_shown(low)} above {above} {_shown(high)}; allowed: low <= "
                    "value <= high",
                )

    def _factor(self, node: yaml.Node, unit: str, dimension: str, key: str) -> tuple[float, str]:
        if dimension == "any":
            return 1.0, unit
        dimension = axis_dimension(dimension, self.drive)
        try:
            if dimension in CHOICES:
                dimension, axis = chosen_dimension(unit, dimension)
                return factor_to_si(unit, dimension, axis), si_unit(dimension, axis)
            return factor_to_si(unit, dimension, self.axis), si_unit(dimension, self.axis)
        except ValueError as error:
            self.fail(node, key, str(error))

    def _plain(self, node: yaml.Node, key: str) -> Any:
        if not isinstance(node, yaml.ScalarNode):
            self.fail(node, key, f"found {_shown(node)}; allowed: a single value")
        tag = node.tag.rpartition(":")[2]
        if tag == "float":
            lowered = node.value.lower()
            return math.nan if "nan" in lowered else float(lowered.replace(".inf", "inf"))
        if tag == "int":
            return int(node.value) if len(node.value) < 400 else math.inf
        if tag == "bool":
            return node.value == "true"
        return None if tag == "null" else node.value

    def _scalar(self, node: yaml.Node, kind: Any, meta: list[msgspec.Meta], key: str) -> Any:
        value = self._plain(node, key)
        if (
            kind is str
            and value is not None
            and not isinstance(value, str)
            and isinstance(node, yaml.ScalarNode)
        ):
            value = node.value  # a name such as 12 or true
        if kind is float and isinstance(value, float | int) and not isinstance(value, bool):
            try:
                finite = math.isfinite(value)
            except OverflowError:
                finite = False
            if not finite:
                self.fail(node, key, f"found {_shown(node)}; allowed: a finite number")
        whole = typing.Annotated[kind, *meta] if meta else kind
        try:
            return msgspec.convert(value, whole, strict=True)
        except msgspec.ValidationError:
            self.fail(
                node,
                key,
                f"found {_shown(node)}; allowed: "
                f"{_allowed(kind, meta)}{_nearest_choice(kind, value)}",
            )


def _join(key: str, name: str) -> str:
    return f"{key}.{name}" if key else name


def _shown(node: yaml.Node) -> str:
    if isinstance(node, yaml.ScalarNode):
        text = node.value if len(node.value) <= 60 else node.value[:57] + "..."
        return repr(text) if node.tag.endswith(":str") else (text or "nothing")
    return "a mapping" if isinstance(node, yaml.MappingNode) else "a list"


def _suggest(name: str, known: list[str]) -> str:
    """Return a hint with the nearest known name; empty if none is near.

    It is also empty if only one name is known, which the message states anyway.
    """
    near = [] if len(known) == 1 else difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f", did you mean {near[0]!r}?" if near else ""


def _nearest_choice(kind: Any, value: Any) -> str:
    if get_origin(kind) is Literal and isinstance(value, str):
        return _suggest(value, [str(choice) for choice in get_args(kind)])
    return ""


def _type_name(kind: Any) -> str:
    if get_origin(kind) is Literal:
        return " | ".join(str(choice) for choice in get_args(kind))
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return "a mapping"
    return {float: "a number", int: "a whole number", str: "text", bool: "true or false"}.get(
        kind, str(kind)
    )


def _allowed(kind: Any, meta: list[msgspec.Meta]) -> str:
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
        f"{_type_name(kind)}{' of' if kind is str and limits else ''} {' and '.join(limits)}"
    ).rstrip()
