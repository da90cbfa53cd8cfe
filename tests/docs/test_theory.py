"""docs/theory/README.md has every command with its page, code and tests; every page has its table;
files that a page names exist."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from tests.docs.thesis_numbers import LAST_EQUATION, LAST_FIGURE, LAST_SECTION, LAST_TABLE, is_there
from tests.support.documentation_pages import PAGES, ROOT, links, name_of, prose, text_of

FOLDER = ROOT / "docs" / "theory"
TABLE = FOLDER / "README.md"
FILES = [
    path
    for folder in ("frictool", "studies", "tests", "benchmarks")
    for path in (ROOT / folder).rglob("*.py")
]
NAMES = {str(path.relative_to(ROOT)) for path in FILES}


def rows() -> dict[str, list[str]]:
    """command -> [page, code, test], of each row of the table."""
    cells = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text_of(TABLE).splitlines()
        if line.startswith("| `")
    ]
    return {row[0].strip("`"): row[1:] for row in cells}


def test_every_command_has_its_row() -> None:
    from frictool.cli.main import COMMANDS as registered

    assert set(rows()) == set(registered)


def test_code_and_tests_of_a_row_exist() -> None:
    for command, (_, code, tests) in rows().items():
        for cell, folder in ((code, "frictool"), (tests, "tests")):
            named = re.findall(r"`([^`]+)`", cell)
            assert named, command
            assert [name for name in named if not (ROOT / folder / name).exists()] == [], command


def test_every_page_of_the_theory_is_linked_from_the_table() -> None:
    linked = {(FOLDER / path).resolve() for path, _ in links(TABLE)}
    assert {page for page in FOLDER.glob("*.md") if page not in linked} == {TABLE}


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.parent == FOLDER and page != TABLE], ids=name_of
)
def test_a_page_opens_with_its_name_and_has_a_table_of_code_and_tests(page: Path) -> None:
    assert re.match(r"# [^\n]{10,}\n\n", text_of(page))
    headers = re.findall(r"^(\| .*)\n\| ---", prose(page), re.MULTILINE)
    assert any(
        ("code" in header or "where" in header) and "test" in header for header in headers
    ), headers


# a file that a recipe makes
MADE = re.compile(r"(?:its own file|file of its own|belongs? in|Test it in),? `([\w./]+\.py)`")


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_file_that_a_page_names_exists(page: Path) -> None:
    named = {name.removeprefix("../") for name in re.findall(r"`([\w./]+\.py)`", prose(page))}
    named -= {"utils.py", "control/NAME.py", *MADE.findall(prose(page))}
    lost = {
        name
        for name in named
        if not any(path == name or path.endswith(f"/{name}") for path in NAMES)
    }
    assert lost == set()


CELL = re.compile(r"(?<!\\)\|")  # between two cells; \| stands for the sign itself
PATH = re.compile(r"`((?:\.\./)?[\w./]+(?:\.py|/))`")


def tables(page: Path) -> Iterator[list[list[str]]]:
    """The cells of each table of a page, its head first."""
    for found in re.finditer(r"(?:^\|.*\n)+", prose(page) + "\n", re.MULTILINE):
        rows = [
            [cell.strip() for cell in CELL.split(line.strip()[1:-1])]
            for line in found[0].splitlines()
        ]
        yield [rows[0], *rows[2:]]


def _lost(row: list[str], head: list[str]) -> list[str]:
    """The paths of a row that are not where they should be: below the folder that the column's head
    gives, below the package or the tests, or beside a path before them."""
    lost: list[str] = []
    beside: list[Path] = []
    for cell, column in zip(row, head, strict=True):
        given = re.findall(r"\(`([\w/]+/)`\)", column)
        for name in PATH.findall(cell):
            folders = [
                *(ROOT / folder for folder in given),
                ROOT,
                ROOT / "frictool",
                ROOT / "tests",
                *beside,
            ]
            path = next((folder / name for folder in folders if (folder / name).exists()), None)
            if path is None:
                lost.append(name)
            else:
                beside.append(path if path.is_dir() else path.parent)
    return lost


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_paths_of_a_table_are_where_its_head_says(page: Path) -> None:
    for head, *lines in tables(page):
        for line in lines:
            assert len(line) == len(head), line
            assert _lost(line, head) == [], line


SOURCES = ("frictool", "studies", "tests", "benchmarks", "configs")
WORD = re.compile(r"(?<![\w/.])[a-z]+(?:_[a-z0-9]+)+(?![\w/*])")


@cache
def _words() -> frozenset[str]:
    """Every name with an underscore that stands in the sources, and every file's."""
    files = [
        path
        for folder in SOURCES
        for ending in ("*.py", "*.yaml", "*.jinja", "Makefile")
        for path in (ROOT / folder).rglob(ending)
    ]
    text = "\n".join(
        path.read_text(encoding="utf-8") for path in files if "build" not in path.parts
    )
    return frozenset(re.findall(r"\w*_\w*", text)) | {path.stem for path in files}


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_name_that_a_page_gives_stands_in_the_sources(page: Path) -> None:
    quoted = " ".join(
        re.findall(r"`(?!python -m )([^`\n]+)`", prose(page))
    )  # of these test_pages.py asks
    assert {word for word in WORD.findall(quoted) if word not in _words()} - OTHERS == set()


OTHERS = {"dynamic_joint_states", "on_activate"}  # names of ROS 2, as examples
STATED = {"theorem 5.3.1", "theorem 6.2.1", "lemma 6.2.1", "proposition 5.2.1", "proposition 5.2.2"}


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_numbers_of_the_thesis_exist(page: Path) -> None:
    """Equations, figures, tables and sections that a page cites: none is beyond the last of its
    chapter."""
    text = re.sub(r"`[^`\n]*`|\]\([^)]*\)", "", prose(page)).replace("\n", " ")
    cited = {
        "equation": (re.findall(r"\(([2-6]\.\d+)\)", text), LAST_EQUATION),
        "figure": (re.findall(r"[Ff]igures? ([2-6]\.\d+)", text), LAST_FIGURE),
        "table": (re.findall(r"[Tt]ables? ([2-6]\.\d+)", text), LAST_TABLE),
        "section": (
            re.findall(
                r"(?<![\w.])([2-7]\.\d(?:\.\d){1,2})(?![.\d]*\w)", _without_statements(text)
            ),
            LAST_SECTION,
        ),
    }
    lost = {
        f"{kind} {number}"
        for kind, (numbers, last) in cited.items()
        for number in numbers
        if not is_there(number, last)
    }
    assert lost == set()


def _without_statements(text: str) -> str:
    """Theorems are numbered as sections are, and are no sections."""
    for stated in STATED:
        text = re.sub(stated, "", text, flags=re.IGNORECASE)
    return text


def test_a_number_that_is_not_there_is_noticed() -> None:
    assert is_there("5.71", LAST_EQUATION)
    assert not is_there("5.72", LAST_EQUATION)
    assert is_there("4.2.5.4", LAST_SECTION)
    assert not is_there("4.1.2", LAST_SECTION)
    assert _lost(["`synth/lpv.py`, `controller_schedule.py`"], ["code"]) == []
    assert _lost(["`lpv.py`"], ["code"]) == ["lpv.py"]
    assert _lost(["`lpv.py`"], ["code (`frictool/synth/`)"]) == []
