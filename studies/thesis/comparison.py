"""Comparison of computed and published values: agreements, differences with reasons, and errors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from studies.thesis.documents import KINDS, Documents, Kind, Row, Table, kind_of
from studies.thesis.results import ComputedValue, Part


@dataclass(frozen=True)
class ComparedValue:
    """Computed and published value.

    difference, allowed: difference and tolerance as text. word: reason for the difference. kind:
    one of KINDS.
    """

    key: str
    name: str
    ours: str
    published: str
    difference: str
    agrees: bool
    word: str
    allowed: str
    kind: Kind


@dataclass(frozen=True)
class Comparison:
    """Compared values of each table, and the problems that make the reproduction fail."""

    tables: dict[str, list[ComparedValue]]
    problems: tuple[str, ...]

    @property
    def lines(self) -> list[ComparedValue]:
        return [line for lines in self.tables.values() for line in lines]

    @property
    def counts(self) -> dict[Kind, tuple[int, int]]:
        """Return the number of values of each kind, and the number of those that agree."""
        chosen = {kind: [line.agrees for line in self.lines if line.kind == kind] for kind in KINDS}
        return {kind: (len(agreeing), sum(agreeing)) for kind, agreeing in chosen.items()}


def agrees(found: ComputedValue, row: Row) -> bool:
    """Return True if the published value is within its tolerance of the computed value or range.

    A text must be equal, except that ">8" agrees with every number above 8.
    """
    if isinstance(row.value, str) or isinstance(found.value, str):
        return _same(str(found.value), str(row.value))
    margin = row.within * abs(row.value)
    low = found.value if found.low is None else found.low
    high = found.value if found.high is None else found.high
    return low - margin <= row.value <= high + margin  # False if a value is NaN


def _same(ours: str, published: str) -> bool:
    if published.startswith(">"):
        return ours.isdigit() and int(ours) > int(published[1:])
    return ours == published


def compare(documents: Documents, part: Part, chosen: frozenset[str] | None = None) -> Comparison:
    """Return the comparison of all values.

    chosen: names of the requested tables and figures; None for all.
    """
    tables, problems, used = {}, [], set()
    for name, table in documents.tables.items():
        if chosen is not None and name not in chosen:
            continue
        ours = part.values.get(name, {})
        problems += _lost(
            f"{name}: values not computed:", [key for key in table.rows if key not in ours]
        )
        problems += [
            f"{name} {key}: computed, but not in published.yaml"
            for key in ours
            if key not in table.rows
        ]
        tables[name] = [
            _line(name, key, table, ours[key], documents.words) for key in table.rows if key in ours
        ]
        used |= {f"{name} {key}" for key in table.rows}
        problems += [
            f"{name} {line.key}: {line.ours}, published {line.published}; no reason in words.yaml"
            for line in tables[name]
            if _lacks(line)
        ]
        problems += [
            f"{name} {line.key}: agrees; remove the reason in words.yaml"
            for line in tables[name]
            if line.agrees and line.word
        ]
    if chosen is None:
        problems += [
            f"words.yaml, {key}: no such value is published"
            for key in documents.words
            if key not in used
        ]
        problems += [
            f"{name}: not in published.yaml" for name in part.values if name not in documents.tables
        ]
        problems += [
            f"figure {number}: not in figures.yaml"
            for number in part.figures
            if number not in documents.figures
        ]
    asked = [number for number in documents.figures if chosen is None or number in chosen]
    problems += _lost(
        "frictool did not draw figures", [number for number in asked if number not in part.figures]
    )
    return Comparison(tables, tuple(problems))


def _lost(what: str, names: list[str]) -> list[str]:
    """Return a list with one line of the names; an empty list without names."""
    return [f"{what} {', '.join(names)}"] if names else []


def _lacks(line: ComparedValue) -> bool:
    return not line.agrees and not line.word


def _line(
    name: str, key: str, table: Table, found: ComputedValue, words: dict[str, str]
) -> ComparedValue:
    row, word = table.rows[key], words.get(f"{name} {key}", "")
    good = agrees(found, row)
    allowed = f" (allowed {100.0 * row.within:g} %)" if row.within else ""
    return ComparedValue(
        key=key,
        name=row.name or key,
        ours=_shown(found, row.unit),
        published=number(row.value, row.unit),
        difference=_difference(found, row),
        agrees=good,
        word=word,
        allowed=allowed,
        kind=kind_of(table, row),
    )


def _shown(found: ComputedValue, unit: str) -> str:
    text = number(found.value, unit)
    if found.low is None or found.high is None:
        return text
    return (
        f"{text} ({number(found.low, '')} to "
        f"{number(found.high, '')}{', ' + found.spread if found.spread else ''})"
    )


def number(value: float | str, unit: str) -> str:
    """Return a value with four digits and its unit as text."""
    if isinstance(value, str):
        return value
    text = "never" if math.isinf(value) else "none" if math.isnan(value) else f"{value:.4g}"
    return f"{text} {unit}".strip() if math.isfinite(value) else text


def _difference(found: ComputedValue, row: Row) -> str:
    if isinstance(row.value, str) or isinstance(found.value, str):
        return "" if _same(str(found.value), str(row.value)) else "differs"
    if row.value == 0.0:
        return f"{found.value:+.3g}"
    ratio = found.value / row.value
    if abs(ratio - 1.0) < 5e-4:
        return ""  # a zero, as it would be written
    return f"x {ratio:.3g}" if not 0.5 <= ratio <= 2.0 else f"{100.0 * (ratio - 1.0):+.1f} %"
