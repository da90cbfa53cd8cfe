"""Every command of the README runs as it stands there, in the order given, and what it says of make is true."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from tests.cli.run import run

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
COMMANDS = [line for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL) for line in block.splitlines() if line.strip()]


def test_the_readme_opens_with_the_two_commands() -> None:
    opening = README.splitlines()[:6]
    assert any(line.strip().startswith("make demo") for line in opening)
    assert any(line.strip().startswith("make test") for line in opening)


def test_every_command_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("sample_logs", "configs"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("build"))
    monkeypatch.chdir(tmp_path)
    assert len(COMMANDS) >= 9
    for line in COMMANDS:
        program, *arguments = shlex.split(line)
        assert program == "frictool"
        result = run(*arguments)
        assert result.code == 0, f"{line}\n{result.stdout}\n{result.stderr}"
    assert (tmp_path / "build/report.html").read_text().startswith("<!DOCTYPE html>")


def test_every_link_of_the_documentation_leads_somewhere() -> None:
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")):
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.relative_to(ROOT)} links to {target}"


def test_every_command_of_the_table_exists() -> None:
    from frictool.cli.main import COMMANDS as registered

    named = set(re.findall(r"^\| `(\w+)", README, re.MULTILINE))
    assert named == set(registered)
