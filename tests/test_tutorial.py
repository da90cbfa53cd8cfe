"""Every command of docs/tutorial.md runs as it stands there and prints what the page says; `make tutorial` runs the same commands."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from decimal import Decimal
from pathlib import Path

import pytest

from tests.cli.run import run

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "tutorial.md").read_text()
BLOCKS = re.findall(r"```(sh|text)\n(.*?)```", PAGE, re.DOTALL)
COMMANDS = [line for kind, text in BLOCKS if kind == "sh" for line in text.splitlines()]
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
COLUMN = "simulated clutch"


def agrees(printed: str, page: str) -> bool:
    """The same words, and numbers that differ by one unit of the page's last digit at most: another processor may round otherwise."""
    if NUMBER.sub("#", printed).split() != NUMBER.sub("#", page).split():
        return False
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(page), strict=True)
    return all(abs(Decimal(found) - Decimal(said)) <= Decimal((0, (1,), int(Decimal(said).as_tuple().exponent))) for found, said in pairs)


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
def printed(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """What each block of commands prints, each run where the page runs it."""
    folder = tmp_path_factory.mktemp("tutorial")
    for name in ("sample_logs", "configs"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("build"))
    out = []
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder / "configs" / "clutch")
        for kind, text in BLOCKS:
            if kind == "sh":
                out.append("".join(_output(line) for line in text.splitlines()))
        assert Path("build/tutorial/friction.svg").read_text().startswith("<svg")
        assert Path("build/tutorial/steps.svg").read_text().startswith("<svg")
    return out


def _output(line: str) -> str:
    program, *arguments = shlex.split(line)
    assert program == "frictool"
    result = run(*arguments)
    assert result.code == 0, f"{line}\n{result.stdout}\n{result.stderr}"
    return result.stdout + result.stderr


def test_what_the_page_says_is_printed(printed: list[str]) -> None:
    block = -1
    for kind, text in BLOCKS:
        if kind == "sh":
            block += 1
            continue
        lines = iter(printed[block].splitlines())
        for said in text.splitlines():
            if said.strip() != "...":
                assert any(agrees(line, said) for line in lines), f"not printed, or not in this order: {said}"


def test_the_figures_of_the_tables_are_printed(printed: list[str]) -> None:
    found = [Decimal(number) for number in NUMBER.findall("\n".join(printed))]
    cells = column(PAGE)
    assert len(cells) == 12
    for cell in cells:
        unit = Decimal((0, (1,), int(Decimal(cell).as_tuple().exponent)))
        assert any(abs(number - Decimal(cell)) <= unit for number in found), cell


def test_make_runs_the_commands_of_the_page() -> None:
    dry = ["make", "--no-print-directory", "-n", "-C", "configs/clutch", "tutorial", "FRICTOOL=frictool"]
    result = subprocess.run(dry, cwd=ROOT, capture_output=True, text=True, check=True)
    assert result.stdout.splitlines() == COMMANDS


def test_a_figure_that_has_changed_is_noticed() -> None:
    assert agrees("inertia  1.3201e-05 kg", "inertia 1.32e-05 kg")
    assert not agrees("inertia  1.3301e-05 kg", "inertia 1.3201e-05 kg")
    assert not agrees("mass 1.3201e-05 kg", "inertia 1.3201e-05 kg")
