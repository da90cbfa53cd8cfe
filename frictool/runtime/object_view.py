"""Short text, HTML table and comparison of documents and results, for the Python prompt.

ObjectView        base class of documents: __repr__ in one line, _repr_html_ as a table
ResultView        base class of results: also __eq__, which compares arrays by their values
"""

from __future__ import annotations

import dataclasses
import html
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

LONGEST = 160  # characters of a line
LONGEST_VALUE = 40  # characters of a value in a line
MOST_ROWS = 40  # rows of a nested table


class ObjectView:
    """Base class for objects whose fields are shown as text and HTML."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Return one line with the class and as many fields as fit into the line."""
        parts: list[str] = []
        remaining = LONGEST
        for name, value in _fields(self):
            part = f"{name}={brief(value)}"
            remaining -= len(part) + 2
            if remaining < 0:
                parts.append("...")
                break
            parts.append(part)
        return f"{type(self).__name__}({', '.join(parts)})"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th>{html.escape(name)}</th><td>{_cell(value)}</td></tr>"
            for name, value in _fields(self)
        )
        return f"<table><caption>{html.escape(type(self).__name__)}</caption>{rows}</table>"


class ResultView(ObjectView):
    """Base class of results that can be compared with ==, and shown as text and HTML.

    A subclass must be a dataclass with `eq=False, repr=False`, so that it inherits these methods.
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]  # a result holds arrays

    def __eq__(self, other: object) -> bool:
        """Return True if all fields are equal; NaN is equal to NaN."""
        if type(self) is not type(other):
            return NotImplemented
        return same(self, other)


def same(one: Any, other: Any) -> bool:
    """Return True if two values have equal types and equal contents; NaN is equal to NaN."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if hasattr(one, "dtype") and hasattr(one, "shape"):
        return bool(
            one.shape == other.shape
            and one.dtype == other.dtype
            and ((one == other) | ((one != one) & (other != other))).all()  # NaN
        )
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if dataclasses.is_dataclass(one):
        return all(
            same(getattr(one, field.name), getattr(other, field.name))
            for field in dataclasses.fields(one)
        )
    if isinstance(one, float) and one != one:  # NaN
        return bool(other != other)  # NaN
    return bool(one == other)


def brief(value: Any) -> str:
    """Return a value as short text; long contents are replaced by their size."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, str):
        shown = value if len(value) <= LONGEST_VALUE else f"{value[: LONGEST_VALUE - 3]}..."
        return repr(shown)
    if value is None or isinstance(value, bool | int):
        return repr(value)
    if hasattr(value, "dtype") and hasattr(value, "shape"):
        return f"array{tuple(value.shape)}"
    if _is_quantity(value):
        return _quantity(value)
    if isinstance(value, Mapping):
        keys = ", ".join(map(str, value))
        return f"{{{keys if len(keys) <= LONGEST_VALUE else f'{len(value)} entries'}}}"
    if isinstance(value, Sequence | set | frozenset):
        return f"({len(value)} {'entry' if len(value) == 1 else 'entries'})"
    name = getattr(value, "name", None)
    return f"{type(value).__name__}({repr(name) if isinstance(name, str) else '...'})"


def _fields(view: Any) -> list[tuple[str, Any]]:
    names = (
        view.__struct_fields__
        if isinstance(view, msgspec.Struct)
        else [field.name for field in dataclasses.fields(view)]
    )
    return [
        (name, value)
        for name in names
        if name != "format" and (value := getattr(view, name)) is not None and not _is_empty(value)
    ]


def _is_empty(value: Any) -> bool:
    return isinstance(value, Mapping | list | tuple) and not value


def _is_record(value: Any) -> bool:
    return isinstance(value, msgspec.Struct) or (
        dataclasses.is_dataclass(value) and not isinstance(value, type)
    )


def _is_quantity(value: Any) -> bool:
    return all(hasattr(value, key) for key in ("value", "low", "high", "unit"))


def _quantity(value: Any) -> str:
    text = f"{value.value:.6g}"
    if value.low is not None and value.high is not None:
        text += f" [{value.low:.6g}, {value.high:.6g}]"
    return f"{text} {value.unit}".strip()


def _cell(value: Any, nested: bool = True) -> str:
    if nested and not _is_quantity(value):
        if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
            return _table([(key, entry) for key, entry in value.items()])
        if isinstance(value, list | tuple) and value and all(map(_is_record, value)):
            return _records(value)
        if _is_record(value):
            return _table(_fields(value))
    return html.escape(brief(value))


def _table(rows: list[tuple[str, Any]]) -> str:
    body = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{_cell(value, nested=False)}</td></tr>"
        for name, value in rows[:MOST_ROWS]
    )
    return f"<table>{body}{_rest(len(rows))}</table>"


def _records(records: Sequence[Any]) -> str:
    rows = [dict(_fields(one)) for one in records[:MOST_ROWS]]
    columns = list(dict.fromkeys(name for row in rows for name in row))
    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    body = "".join(
        "<tr>"
        + "".join(
            f"<td>{_cell(row[name], nested=False) if name in row else ''}</td>" for name in columns
        )
        + "</tr>"
        for row in rows
    )
    return f"<table><tr>{head}</tr>{body}{_rest(len(records))}</table>"


def _rest(count: int) -> str:
    return f"<tr><td>... {count - MOST_ROWS} more</td></tr>" if count > MOST_ROWS else ""
