"""Reader of published.yaml, words.yaml and figures.yaml.

The cells of tables 2.1 and 3.2, and the reasons for their differences, are those of `frictool
compare`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import msgspec

from frictool.compare.thesis_tables import (
    OTHER_PARAMETERS,
    PROPERTIES,
    REASONS,
    TABLE_2_1,
    TABLE_3_2,
    TESTS,
)

HERE = Path(__file__).parent
GRIDS = {"2.1": (TABLE_2_1, PROPERTIES), "3.2": (TABLE_3_2, (*TESTS, "parameters"))}


class Row(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Published value.

    within: allowed relative difference; 0 for a text or a number that must be equal.
    """

    value: float | str
    name: str = ""
    unit: str = ""
    within: float = 0.0


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Table of the thesis, or values in the text of a section.

    where: section and table. ours: origin of the computed values. grid: True if the published cells
    are in `frictool compare`. inputs: True if the values are inputs in a rig's file; the comparison
    then checks the file.
    """

    title: str
    where: str
    ours: str
    rows: dict[str, Row] = {}
    grid: str = ""
    inputs: bool = False


Kind = Literal["computed", "word", "input"]
KINDS: dict[Kind, str] = {
    "computed": "computed numbers",
    "word": "words, signs and counts of parameters",
    "input": "inputs typed in a rig's file",
}


def kind_of(table: Table, row: Row) -> Kind:
    """Return the kind of a comparison, one of KINDS."""
    if table.inputs:
        return "input"
    return "word" if isinstance(row.value, str) else "computed"


class Figure(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Figure of the thesis: title, content and section."""

    title: str
    shows: str
    where: str


class Documents(msgspec.Struct, frozen=True):
    """Contents of the three files; words: "TABLE KEY" -> reason for the difference."""

    tables: dict[str, Table]
    words: dict[str, str]
    figures: dict[str, Figure]


def read(folder: Path = HERE) -> Documents:
    """Return the contents of the three files.

    Raises ValueError if a file has other contents, or if a reason occurs twice.
    """
    tables = _decoded(folder / "published.yaml", dict[str, Table])
    words = _decoded(folder / "words.yaml", dict[str, str])
    figures = _decoded(folder / "figures.yaml", dict[str, Figure])
    for name, table in tables.items():
        if table.grid:
            rows, own = _grid(name, table.grid)
            tables[name] = msgspec.structs.replace(table, rows={**rows, **table.rows})
            both = own.keys() & words.keys()
            if both:
                raise ValueError(
                    "words.yaml and frictool/compare/thesis_tables.py both say why: "
                    f"{', '.join(sorted(both))}"
                )
            words |= own
    return Documents(tables, words, figures)


def _decoded(path: Path, kind: type[Any]) -> Any:
    """Return the contents of a file; an error begins with the name of the file."""
    try:
        return msgspec.yaml.decode(path.read_bytes(), type=kind)
    except msgspec.DecodeError as error:
        raise ValueError(f"{path.name}: {' '.join(str(error).split())}") from None


def _grid(name: str, grid: str) -> tuple[dict[str, Row], dict[str, str]]:
    """Return the cells LAW.ROW of a table of `frictool compare`, and reasons for differences."""
    printed, heads = GRIDS[grid]
    rows = {
        f"{law}.{head}": Row(cell)
        for law, cells in printed.items()
        for head, cell in zip(heads, cells, strict=True)
    }
    words = {
        f"{name} {law}.{head}": why
        for law, reasons in REASONS.items()
        for (head, _), why in reasons.items()
        if f"{law}.{head}" in rows and why != OTHER_PARAMETERS
    }
    return rows, words
