"""docs/theory/mechanism.md: its commands run in configs/screw and print what the page says; its
file is the one that they read."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from studies.command_line import run
from tests.support.documentation_player import agrees

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/theory/mechanism.md").read_text()
BLOCKS = re.findall(
    r"```(sh|text)\n(.*?)```",
    re.sub(r"```console\n.*?```\n+```text\n.*?```", "", PAGE, flags=re.DOTALL),
    re.DOTALL,
)  # make accept has those
NOTHING = re.compile(r"-?\d\.?\d*e-1\d")  # rounding: what is left of a balance that closes


def test_the_page_shows_the_file() -> None:
    shown = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    assert shown == [(ROOT / "configs/screw/irreversible.yaml").read_text()]


def test_its_commands_print_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(
        ROOT / "configs/screw", tmp_path / "screw", ignore=shutil.ignore_patterns("build")
    )
    monkeypatch.chdir(tmp_path / "screw")
    printed, commands = "", 0
    for kind, text in BLOCKS:
        if kind == "sh":
            Path("build").mkdir(exist_ok=True)  # the page's own line
            results = [
                run(*shlex.split(line)[1:])
                for line in text.splitlines()
                if not line.startswith("mkdir ")
            ]
            assert all(result.code == 0 for result in results), text
            printed, commands = (
                "\n".join(result.stdout for result in results),
                commands + len(results),
            )
            continue
        lines = iter(NOTHING.sub("0", printed).splitlines())
        for said in text.splitlines():
            if said.strip() not in ("...", ""):
                assert any(agrees(line, NOTHING.sub("0", said)) for line in lines), (
                    f"not printed, or not in this order: {said}"
                )
    assert commands == 4


@pytest.mark.parametrize(
    "target", sorted(set(re.findall(r"^make -C (configs/\w+) \w+", PAGE, re.MULTILINE)))
)
def test_its_makefiles_are_there(target: str) -> None:
    assert (ROOT / target / "Makefile").exists()
