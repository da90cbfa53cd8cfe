"""The hunks of the recipes survive what earlier readers have added at the same place."""

from __future__ import annotations

import re

import pytest

from tests.support.documentation_pages import ROOT
from tests.support.recipes import blocks, changed, recipes


@pytest.mark.parametrize("heading", recipes())
def test_a_recipe_can_be_followed_after_a_reader_who_followed_it(heading: str) -> None:
    """The first reader's rows have other names, and stand where the recipe says."""
    hunks = [(name, text) for name, language, text in blocks(heading) if language == "diff"]
    assert hunks
    for name, text in hunks:
        earlier = re.sub(r"^(\+[^\w\n]*)(?=[a-z])", r"\1earlier_", text, flags=re.M)
        first = changed((ROOT / name).read_text(encoding="utf-8"), earlier)
        both = changed(first, text)
        assert len(both) - len(first) == sum(len(line) for line in _added(text))
        assert set(_added(earlier)) | set(_added(text)) <= {
            f"+{line}" for line in both.splitlines()
        }


def _added(difference: str) -> list[str]:
    return [line for line in difference.splitlines() if line.startswith("+")]
