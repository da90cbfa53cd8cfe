"""Notebooks made from the tutorials: every block is a cell, and a notebook runs to its end."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

import nbformat
import pytest

from release.notebook import main, notebook
from tests.support.documentation_pages import ROOT, blocks
from tests.support.documentation_player import run_notebook, scratch

TUTORIALS = ["tutorial.md", "tutorial_emps.md", "tutorial_plan.md", "api.md"]


@pytest.mark.parametrize("name", TUTORIALS)
def test_every_block_of_a_tutorial_is_a_cell(name: str, tmp_path: Path) -> None:
    page = ROOT / "docs" / name
    main([str(page), str(tmp_path / "page.ipynb")])
    made = nbformat.read(tmp_path / "page.ipynb", as_version=4)
    nbformat.validate(made)
    code = "\n".join(cell.source for cell in made.cells if cell.cell_type == "code")
    for block in blocks(page, "sh", "python"):
        for line in block.lines:
            assert line.partition("  # exit code")[0].rstrip().removeprefix("cd ") in code
    assert made == notebook(page.read_text())


def test_an_annotated_exit_code_is_checked() -> None:
    (cell,) = notebook("```sh\nfrictool report a.mcap   # exit code 1\n```\n").cells
    assert cell.source == "%%bash\nset -e\nfrictool report a.mcap || test $? -eq 1"


@pytest.mark.skipif(
    not (importlib.util.find_spec("nbclient") and importlib.util.find_spec("ipykernel")),
    reason="nbclient and ipykernel are not installed: pip install 'frictool[dev]'",
)
@pytest.mark.parametrize(
    ("name", "section", "shown"),
    [
        ("tutorial.md", "## 2. Test signals", "coulomb: sines in position control"),
        pytest.param(
            "api.md", "## A controller, simulated and judged", "kg m^2", marks=pytest.mark.accept
        ),
    ],
)
def test_the_notebook_of_a_page_s_first_section_runs(
    name: str, section: str, shown: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cell of bash behind `cd`, ; `make accept` runs cells of Python, and a whole tutorial."""
    first, found, _ = (ROOT / "docs" / name).read_text().partition(section)
    assert found
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    monkeypatch.setenv("PATH", path)
    assert shown in run_notebook(first, scratch(tmp_path))
