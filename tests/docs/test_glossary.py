"""docs/glossary.md: in alphabetical order, no term twice, every name of frictool's that it gives is
one."""

from __future__ import annotations

import re
import unicodedata
from functools import cache

import pytest

from tests.support.documentation_pages import ROOT, text_of

PAGE = ROOT / "docs/glossary.md"


def rows() -> list[list[str]]:
    """French, English, names, section of each term."""
    table = text_of(PAGE).split("| --- | --- | --- | --- |\n")[1].strip().splitlines()
    return [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in table]


@cache
def known() -> str:
    """Where a name can stand: the documents' schemas, and the program, in quotes."""
    schemas = [path.read_text() for path in sorted((ROOT / "docs/schemas").glob("*.json"))]
    return "\n".join(
        [*schemas, *(path.read_text() for path in sorted((ROOT / "frictool").rglob("*.py")))]
    )


def folded(term: str) -> str:
    """As a French dictionary orders it: accents, hyphens and apostrophes aside."""
    plain = unicodedata.normalize("NFKD", term.lower()).encode("ascii", "ignore").decode()
    return plain.replace("-", " ").replace("'", " ")


def test_terms_are_in_order_and_stand_once() -> None:
    terms = [folded(row[0]) for row in rows()]
    assert len(terms) > 80
    assert terms == sorted(terms)
    assert len(set(terms)) == len(terms)


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0])
def test_a_term_has_its_english_its_section_and_names_that_exist(row: list[str]) -> None:
    french, english, names, section = row
    assert french
    assert english
    assert re.fullmatch(r"\d(\.\d){0,4}|annex [ABC]", section)
    lost = [
        name
        for name in re.findall(r"`([^`]+)`", names)
        if f'"{name}"' not in known() and f"def {name}(" not in known()
    ]
    assert lost == []
