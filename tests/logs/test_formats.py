"""The registry of log formats and its page."""

from __future__ import annotations

import pytest

from frictool.logs.formats import FORMATS, SUFFIXES, WRITTEN, Format
from tests.support.documentation_pages import ROOT, text_of


@pytest.mark.parametrize("form", FORMATS, ids=lambda form: form.name)
def test_the_documentation_names_the_modules_of_a_format(form: Format) -> None:
    page = text_of(ROOT / "docs/log_formats.md")
    for module in (form.reader, form.writer):
        assert module.removeprefix("frictool.").replace(".", "/") in page


def test_a_name_and_a_written_suffix_belong_to_one_format() -> None:
    assert len({form.name for form in FORMATS}) == len(FORMATS)
    written = [suffix for form in WRITTEN.values() for suffix in form.suffixes]
    assert len(set(written)) == len(written)
    assert set(written) < set(SUFFIXES)
