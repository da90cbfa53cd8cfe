"""Every command of docs/tutorial.md runs as it stands there and prints what the page says: here
those of the first sections, in `make accept` all; `make tutorial` runs the same commands."""

from __future__ import annotations

import re
import subprocess
from decimal import Decimal
from pathlib import Path

import pytest

from tests.support.documentation_pages import ROOT, blocks, text_of
from tests.support.documentation_player import COMMENT, NUMBER, play, scratch

PAGE = ROOT / "docs" / "tutorial.md"
FOLDER = "configs/clutch"
FIRST_LEFT_OUT = "## 5. Friction and inertia"
COLUMN = "simulated clutch"


def column(page: str) -> list[str]:
    """The cells below `simulated clutch`, of each table that has the column."""
    cells, place = [], None
    for line in page.splitlines():
        row = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            place = None
        elif COLUMN in row:
            place = row.index(COLUMN)
        elif place is not None and not set(row[place]) <= {"-"}:
            cells.append(row[place])
    return cells


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """All that the page's commands print; each prints what stands beneath it."""
    folder = scratch(tmp_path_factory.mktemp("tutorial"))
    with pytest.MonkeyPatch.context() as patch:
        out = play(PAGE, folder, patch)
    for name in ("friction.svg", "steps.svg"):
        assert (folder / FOLDER / "build/tutorial" / name).read_text().startswith("<svg")
    return out


def test_the_first_sections_print_what_they_say(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    printed = play(PAGE, scratch(tmp_path), monkeypatch, FIRST_LEFT_OUT)
    assert "coulomb: sines in position control" in printed


@pytest.mark.accept
def test_the_figures_of_the_tables_are_printed(printed: str) -> None:
    found = [Decimal(number) for number in NUMBER.findall(printed)]
    cells = column(text_of(PAGE))
    assert len(cells) == 6
    for cell in cells:
        unit = Decimal((0, (1,), int(Decimal(cell).as_tuple().exponent)))
        assert any(abs(number - Decimal(cell)) <= unit for number in found), cell


def test_make_runs_the_commands_of_the_page() -> None:
    commands = [COMMENT.sub("", line) for block in blocks(PAGE, "sh") for line in block.lines]
    assert commands[0] == f"cd {FOLDER}"
    dry = ["make", "--no-print-directory", "-n", "-C", FOLDER, "tutorial", "FRICTOOL=frictool"]
    result = subprocess.run(dry, cwd=ROOT, capture_output=True, text=True, check=True)
    assert [
        re.sub(r"; test \$\? -eq \d$", "", line) for line in result.stdout.splitlines()
    ] == commands[1:]
