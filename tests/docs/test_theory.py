"""docs/theory/README.md has every command with its page, code and tests; every page has its table; files that a page names exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.pages import PAGES, ROOT, links, name_of, prose, text_of

FOLDER = ROOT / "docs" / "theory"
TABLE = FOLDER / "README.md"
FILES = [path for folder in ("frictool", "tests", "benchmarks", "sample_logs", "thesis") for path in (ROOT / folder).rglob("*.py")]
NAMES = {str(path.relative_to(ROOT)) for path in FILES}


def rows() -> dict[str, list[str]]:
    """command -> [page, code, test], of each row of the table."""
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in text_of(TABLE).splitlines() if line.startswith("| `")]
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


@pytest.mark.parametrize("page", [page for page in PAGES if page.parent == FOLDER and page != TABLE], ids=name_of)
def test_a_page_opens_with_its_name_and_has_a_table_of_code_and_tests(page: Path) -> None:
    assert re.match(r"# [^\n]{10,}\n\n", text_of(page))
    headers = re.findall(r"^(\| .*)\n\| ---", prose(page), re.MULTILINE)
    assert any(("code" in header or "where" in header) and "test" in header for header in headers), headers


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_file_that_a_page_names_exists(page: Path) -> None:
    named = {name.removeprefix("../") for name in re.findall(r"`([\w./]+\.py)`", prose(page))} - {"utils.py", "control/NAME.py"}
    lost = {name for name in named if not any(path == name or path.endswith(f"/{name}") for path in NAMES)}
    assert lost == set()
