"""Strict reading of a YAML document into an object of its document type.

The nodes are matched with the fields of the type, so that every error names the key, the value in
the file and the allowed values.
"""

from __future__ import annotations

import re
import types
import typing
from typing import Any, Literal, Union, get_args, get_origin

import msgspec
import yaml

from frictool.documents.node_reader import join, shown, suggestion, type_name
from frictool.documents.quantity import Quantity, Series, Span
from frictool.documents.quantity_reader import QuantityReader
from frictool.documents.struct_fields import fields_of, hints_of

# advice if the file is a mechanism, but a document of one of these types is expected
OF_A_MECHANISM = {
    "Model": "reduce it first: frictool reduce {path} -o model.yaml",
    "Bench": (
        "a model contains its bench: frictool reduce {path} -o model.yaml writes both; or write "
        "a bench.yaml (frictool init)"
    ),
}


class DocumentReader(QuantityReader):
    """Reader of documents: it converts each YAML node to the Python type of its field."""

    def read(self, node: yaml.Node, kind: Any, key: str) -> Any:
        """Convert a YAML node to the type `kind`, and return the value.

        `key`: path of the node in the document, for messages.
        """
        meta: list[msgspec.Meta] = []
        origin = get_origin(kind)
        if origin is typing.Annotated:
            kind, *extra = get_args(kind)
            meta = [m for m in extra if isinstance(m, msgspec.Meta)]
            origin = get_origin(kind)
        if origin in (Union, types.UnionType):
            return self._optional(node, kind, meta, key)
        if isinstance(kind, type) and issubclass(kind, Quantity | Span):
            return self.quantity(node, kind, meta, key)
        if kind is Series:
            return self.series(node, meta, key)
        if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
            return self._struct(node, kind, key)
        if origin is tuple:
            return self._sequence(node, get_args(kind)[0], meta, key)
        if origin is dict:
            names, values = get_args(kind)
            return self._mapping(node, names, values, key)
        return self.scalar(node, kind, meta, key)

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
        value = self.plain(node, key) if isinstance(node, yaml.ScalarNode) else None
        if type(value) not in scalar_members:
            self.fail(
                node,
                key,
                f"found {shown(node)}; allowed: {' or '.join(type_name(m) for m in members)}",
            )
        return value

    def _tagged(self, node: yaml.Node, members: list[type[msgspec.Struct]], key: str) -> Any:
        kinds = {str(member.__struct_config__.tag): member for member in members}
        field = str(members[0].__struct_config__.tag_field)
        pairs = self.pairs(node, key)
        if field not in pairs:
            self.fail(node, join(key, field), f"missing; allowed: {', '.join(kinds)}")
        tag_value = str(self.plain(pairs[field][1], join(key, field)))
        if tag_value not in kinds:
            self.fail(
                pairs[field][1],
                join(key, field),
                f"found {tag_value!r}{suggestion(tag_value, list(kinds))}; "
                f"allowed: {', '.join(kinds)}",
            )
        return self._struct(node, kinds[tag_value], key)

    def _struct(self, node: yaml.Node, kind: type[msgspec.Struct], key: str) -> Any:
        fields = {field.encode_name: field for field in fields_of(kind)}
        hints = hints_of(kind)
        present = self.pairs(node, key)
        tag = kind.__struct_config__.tag_field
        if tag is not None:  # the tag has selected the struct already
            present = {name: pair for name, pair in present.items() if name != tag}
        if (
            "format" in present and "format" in fields
        ):  # check the format first: in a document of another kind every key is unknown
            self._refuse_mechanism(present["format"][1], kind, join(key, "format"))
            self.read(present["format"][1], hints["format"], join(key, "format"))
        elif "format" in fields:
            self._missing(node, "format", fields, hints, key)
        self.check_known(present, list(fields), key)
        values: dict[str, Any] = {}
        # the axis and its drive decide the units of all other keys: read them first
        for name in sorted(present, key=lambda n: n not in ("axis", "actuator", "bench", "drive")):
            value = self.read(present[name][1], hints[fields[name].name], join(key, name))
            if name == "axis":
                self.axis = value
            if name == "drive" and not isinstance(value, float):  # `rest.drive` is a number
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
            named = re.match(r"`?(\w+)", str(error))
            at = present.get(named[1], (node, node))[0] if named is not None else node
            self.fail(at, key or kind.__name__.lower(), str(error))

    def _missing(
        self, node: yaml.Node, name: str, fields: dict[str, Any], hints: dict[str, Any], key: str
    ) -> typing.NoReturn:
        value = hints[fields[name].name]
        example = (
            ""
            if key
            else f"; write {name}: {type_name(value) if get_origin(value) is Literal else '...'}"
        )
        self.fail(
            node,
            join(key, name),
            (
                f"missing{example}; required: "
                f"{', '.join((n for n, f in fields.items() if f.required))}"
            ),
        )

    def _refuse_mechanism(self, node: yaml.Node, kind: type[msgspec.Struct], key: str) -> None:
        tried = OF_A_MECHANISM.get(kind.__name__)
        if tried is not None and isinstance(node, yaml.ScalarNode) and node.value == "mechanism/1":
            self.fail(
                node,
                key,
                f"found 'mechanism/1'; allowed: {kind.__name__.lower()}/1; "
                f"{tried.format(path=self.path)}",
            )

    def _mapping(self, node: yaml.Node, names: Any, kind: Any, key: str) -> dict[str, Any]:
        pairs = self.pairs(node, key)
        if get_origin(names) is Literal:
            self.check_known(pairs, list(get_args(names)), key)
        return {name: self.read(value, kind, join(key, name)) for name, (_, value) in pairs.items()}

    def _sequence(
        self, node: yaml.Node, kind: Any, meta: list[msgspec.Meta], key: str
    ) -> tuple[Any, ...]:
        return tuple(
            self.read(item, kind, f"{key}[{index}]")
            for index, item in enumerate(self.items(node, meta, key))
        )
