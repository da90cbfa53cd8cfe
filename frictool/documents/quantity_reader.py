"""Reading of quantities: numbers with a unit, converted to SI, and their intervals."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any, Literal

import msgspec
import yaml

from frictool.documents.node_reader import NodeReader, Pairs, join, shown
from frictool.documents.quantity import (
    CHOICES,
    Axis,
    Quantity,
    Series,
    Span,
    UnitScale,
    chosen_dimension,
    si_unit,
    unit_scale,
)
from frictool.documents.quantity_notation import (
    UNKNOWN,
    axis_dimension,
    example_unit,
    quantity_form,
    written_quantity,
)
from frictool.documents.struct_fields import fields_of


class QuantityReader(NodeReader):
    """Reader of quantities.

    axis, drive: kinds of axis and drive that the document has stated so far; they decide the units.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.axis: Axis = "rotary"
        self.drive: Literal["current", "voltage"] = "current"

    def quantity(
        self, node: yaml.Node, kind: type[Quantity | Span], meta: list[msgspec.Meta], key: str
    ) -> Any:
        """Read a quantity or a span (type `kind`) and return it in SI.

        - meta: limits of the value
        - key: path of the node in the document
        """
        extra = next((m.extra for m in meta if m.extra), {"dimension": "any"})
        pairs = self._quantity_keys(node, kind, str(extra["dimension"]), key)
        fields = {field.name: field for field in fields_of(kind)}
        unit = self.scalar(pairs["unit"][1], str, [], join(key, "unit"))
        scale, si = self._scale(pairs["unit"][1], unit, str(extra["dimension"]), join(key, "unit"))
        numbers: dict[str, float] = {
            name: scale.si(self.scalar(pairs[name][1], float, [], join(key, name)))
            for name in ("value", "low", "high")
            if name in pairs
        }
        self._in_range(pairs, numbers, unit, extra, key)
        others = {
            name: self.scalar(pairs[name][1], fields[name].type, [], join(key, name))
            for name in pairs
            if name not in (*numbers, "unit")
        }
        return kind(**numbers, **others, unit=si)

    def series(self, node: yaml.Node, meta: list[msgspec.Meta], key: str) -> Series:
        """Read a list of numbers with a unit and return it in SI."""
        extra = next((m.extra for m in meta if m.extra), {"dimension": "any"})
        pairs = self._quantity_keys(node, Series, str(extra["dimension"]), key)
        unit = self.scalar(pairs["unit"][1], str, [], join(key, "unit"))
        scale, si = self._scale(pairs["unit"][1], unit, str(extra["dimension"]), join(key, "unit"))
        items = self.items(pairs["values"][1], [], join(key, "values"))
        values = [
            self.scalar(item, float, [], f"{join(key, 'values')}[{index}]")
            for index, item in enumerate(items)
        ]
        return Series(tuple(map(scale.si, values)), si)

    def _quantity_keys(
        self, node: yaml.Node, kind: type[msgspec.Struct], dimension: str, key: str
    ) -> Pairs:
        fields = {field.name: field for field in fields_of(kind)}
        required = [name for name, field in fields.items() if field.required or name == "unit"]
        if not isinstance(node, yaml.MappingNode):
            written = written_quantity(node.value) if isinstance(node, yaml.ScalarNode) else None
            number, unit = written or (UNKNOWN, "")
            form = quantity_form(
                required,
                {"value": number, "unit": example_unit(dimension, self.axis, self.drive, unit)},
            )
            self.fail(
                node, key, f"found {shown(node)}; allowed: a mapping with a unit; write {form}"
            )
        pairs = self.pairs(node, key)
        self.check_known(pairs, list(fields), key)
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
                self.fail(node, join(key, name), f"missing; allowed: {form}")
        return pairs

    def _in_range(
        self, pairs: Pairs, numbers: dict[str, float], unit: str, extra: dict[str, Any], key: str
    ) -> None:
        minimum = extra.get("minimum")
        exclusive = bool(extra.get("exclusive"))
        for name, number in numbers.items():
            if minimum is not None and (number < minimum or (exclusive and number == minimum)):
                finding = f"found {shown(pairs[name][1])} {unit}"
                self.fail(
                    pairs[name][1],
                    join(key, name),
                    f"{finding}; allowed: {'>' if exclusive else '>='} {minimum:g}",
                )
        order = [name for name in ("low", "value", "high") if name in numbers]
        for below, above in itertools.pairwise(order):
            if numbers[below] > numbers[above]:
                low, high = pairs[below][1], pairs[above][1]
                self.fail(
                    low,
                    join(key, below),
                    f"found {shown(low)} above {above} {shown(high)}; allowed: low <= "
                    "value <= high",
                )

    def _scale(self, node: yaml.Node, unit: str, dimension: str, key: str) -> tuple[UnitScale, str]:
        if dimension == "any":
            return UnitScale(1.0), unit
        dimension = axis_dimension(dimension, self.drive)
        try:
            if dimension in CHOICES:
                dimension, axis = chosen_dimension(unit, dimension)
                return unit_scale(unit, dimension, axis), si_unit(dimension, axis)
            return unit_scale(unit, dimension, self.axis), si_unit(dimension, self.axis)
        except ValueError as error:
            self.fail(node, key, str(error))
