"""docs/reference is what `make reference` writes, and every key and option of it has a meaning."""

from __future__ import annotations

import re

import pytest

from release.reference import pages
from tests.support.documentation_pages import ROOT

PAGES = pages()


@pytest.mark.parametrize("name", PAGES)
def test_the_page_is_the_program_s(name: str) -> None:
    page = ROOT / "docs/reference" / name
    assert page.read_text(encoding="utf-8") == PAGES[name], (
        "the program has changed: make reference"
    )


@pytest.mark.parametrize("name", PAGES)
def test_every_key_argument_and_option_has_a_meaning(name: str) -> None:
    rows = re.findall(r"^\| `.*$", PAGES[name], re.MULTILINE)
    assert len(rows) > 200
    assert [row for row in rows if row.endswith("|  |")] == []
