"""docs/schemas holds what `frictool schema` prints, of every document; `make schemas` writes them
anew."""

from __future__ import annotations

import json

import pytest

from frictool.cli.schema import schema_of
from frictool.documents.registry import DOCUMENTS
from tests.support.documentation_pages import ROOT, text_of

FOLDER = ROOT / "docs" / "schemas"


@pytest.mark.parametrize("name", DOCUMENTS)
def test_the_schema_is_the_program_s(name: str) -> None:
    printed = json.dumps(schema_of(name), indent=2) + "\n"
    assert (FOLDER / f"{name}.schema.json").read_text() == printed, (
        "the documents have changed: make schemas"
    )


def test_no_other_schema_is_there_and_each_is_linked() -> None:
    files = {path.name for path in FOLDER.iterdir()}
    assert files == {f"{name}.schema.json" for name in DOCUMENTS}
    assert all(f"(schemas/{file})" in text_of(ROOT / "docs/formats.md") for file in files)
