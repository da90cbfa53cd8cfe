"""docs/tutorial_emps.md on the measured record, where it is: its commands run and print what the
page says."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.documentation_pages import ROOT
from tests.support.documentation_player import DATA, play, scratch

PAGE = ROOT / "docs" / "tutorial_emps.md"


def test_what_the_page_says_is_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not (DATA / "emps" / "DATA_EMPS.mat").exists():
        pytest.skip(
            "the EMPS record is not here; set FRICTOOL_DATA to the folder that holds "
            "emps/DATA_EMPS.mat"
        )
    play(PAGE, scratch(tmp_path), monkeypatch)
    build = tmp_path / "configs/emps/build/tutorial"
    assert (build / "friction.svg").read_text().startswith("<svg")
    assert (build / "report.html").read_text().startswith("<!DOCTYPE html>")
