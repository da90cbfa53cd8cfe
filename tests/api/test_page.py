"""docs/api.md, whose blocks tests/docs plays: each has its output, and the table names what there
is."""

from __future__ import annotations

import importlib
import re

import pytest

from tests.support.documentation_pages import ROOT, blocks, text_of

PAGE = ROOT / "docs" / "api.md"
ROWS = re.findall(r"^\| `(frictool[\w.]*)` \| (.*?) \|", text_of(PAGE), re.MULTILINE)


def test_every_block_has_its_output() -> None:
    kinds = [block.language for block in blocks(PAGE, "python", "text")]
    assert kinds == ["python", "text"] * (len(kinds) // 2)
    assert len(kinds) >= 16


@pytest.mark.parametrize(("package", "offered"), ROWS)
def test_the_table_names_what_there_is(package: str, offered: str) -> None:
    module = importlib.import_module(package)
    for name in re.findall(r"`(\w+)\(", offered):
        assert name in module.__all__
        assert getattr(module, name).__doc__
