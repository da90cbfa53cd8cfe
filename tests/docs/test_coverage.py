"""docs/coverage.md: every file, test and figure that it names exists, and it names every table and
figure that `make thesis` makes."""

from __future__ import annotations

import re
from typing import NamedTuple

import pytest

from studies.thesis.documents import read
from studies.thesis.page import CHAPTERS, chapter_of
from tests.docs.thesis_numbers import LAST_EQUATION, LAST_FIGURE, LAST_TABLE, numbers
from tests.support.documentation_pages import ROOT, text_of

PAGE = ROOT / "docs/coverage.md"
HEAD = "| section | system | equations | code | tests | reproduced |"
SECTIONS = (
    "2.1.5",
    "2.2.4",
    "2.4.3",
    "3.4.3",
    "3.5",
    "3.8",
    "4.2.4",
    "4.3",
    "4.4",
    "5.2.5",
    "5.3.4",
    "5.4.2",
    "6.2",
    "6.4",
    "7.2",
    "annex A",
    "annex B",
)


class Row(NamedTuple):
    """The cells of a system."""

    section: str
    system: str
    equations: str
    code: str
    tests: str
    reproduced: str


def rows() -> list[Row]:
    table = text_of(PAGE).split(HEAD)[1].split("\n\n")[0].strip().splitlines()[1:]
    return [Row(*(cell.strip() for cell in line.strip().strip("|").split("|"))) for line in table]


def named(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def reproduced() -> set[str]:
    """Tables and figures, of all rows."""
    cells = " ; ".join(row.reproduced for row in rows())
    return {
        *re.findall(r"\b(?:table|section|annex)_\w+", cells),
        *re.findall(r"\b(?:\d|C)\.\d+", cells),
    }


def test_the_table_is_that_of_the_thesis() -> None:
    assert len(rows()) >= 48
    assert len({(row.section, row.system) for row in rows()}) == len(rows())
    assert {chapter_of(row.section.replace("annex C", "annex_c")) for row in rows()} >= set(
        CHAPTERS
    ) - {"C"}
    assert {row.section for row in rows()} >= set(SECTIONS)


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row.section}, {row.system[:24]}")
def test_code_and_tests_of_a_system_exist(row: Row) -> None:
    code, tests = named(row.code), named(row.tests)
    assert code
    assert tests
    assert [name for name in code if not (ROOT / "frictool" / name).exists()] == []
    for name in tests:
        path, _, function = name.partition("::")
        assert (ROOT / "tests" / path).is_file(), name
        assert not function or f"def {function}(" in (ROOT / "tests" / path).read_text(), name


def test_what_is_reproduced_is_what_make_thesis_makes() -> None:
    documents = read()
    assert reproduced() == {*documents.tables, *documents.figures}


def test_every_equation_has_its_system() -> None:
    ranges = re.findall(
        r"\((\d)\.(\d+)\)(?:-\(\d\.(\d+)\))?", " ".join(row.equations for row in rows())
    )
    covered = {
        f"{whole}.{part}"
        for whole, first, last in ranges
        for part in range(int(first), int(last or first) + 1)
    }
    assert [number for number in numbers(LAST_EQUATION) if number not in covered] == []


def test_every_figure_and_table_is_made_anew_or_has_its_reason() -> None:
    made = reproduced()
    left = text_of(PAGE).split("## Figures that are not reproduced\n")[1].split("\n## ")[0]
    reasons = [
        named
        for line in left.splitlines()
        if line.startswith("|")
        for named in re.findall(r"[2-6C]\.\d+", line.split("|")[1])
    ]
    assert sorted(reasons) == sorted(set(numbers(LAST_FIGURE)) - made)
    assert [
        number for number in numbers(LAST_TABLE) if f"table_{number.replace('.', '_')}" not in made
    ] == []
