"""`make accept` goes on where it was interrupted, and its parts end in time."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.accept import __main__ as acceptance

COSTS = {"long": 1000.0, "short": 1.0, "new": 60.0}


def check(path: Path, name: str, passed: bool) -> acceptance.Check:
    def run() -> dict[str, Any]:
        with path.open("a") as lines:
            lines.write(f"{name}\n")
        return {"passed": passed}

    return run


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty repository with one commit and three checks, of which `new` fails."""
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b.c"]
    subprocess.run([*git, "init", "-q"], check=True)
    (tmp_path / "code").write_text("1")
    (tmp_path / ".gitignore").write_text("accept.json\nran\n")
    subprocess.run([*git, "add", "."], check=True)
    subprocess.run([*git, "commit", "-q", "-m", "one"], check=True)
    ran = tmp_path / "ran"
    checks = {name: check(ran, name, name != "new") for name in COSTS}
    monkeypatch.setattr(acceptance, "collect", lambda _: checks)
    monkeypatch.setattr(acceptance, "ROOT", tmp_path)
    return tmp_path


def ran(folder: Path) -> list[str]:
    lines = sorted((folder / "ran").read_text().split()) if (folder / "ran").exists() else []
    (folder / "ran").write_text("")
    return lines


def test_what_passed_at_the_commit_is_not_run_again(checkout: Path) -> None:
    target = str(checkout / "accept.json")
    assert acceptance.main([target]) == 1
    assert ran(checkout) == ["long", "new", "short"]
    assert acceptance.main([target]) == 1
    assert ran(checkout) == ["new"]
    assert acceptance.main([target, "short"]) == 0
    assert ran(checkout) == []
    assert acceptance.main([target, "short", "--again"]) == 0
    assert ran(checkout) == ["short"]


@pytest.mark.parametrize("edited", ["code", "check_more.py"])
def test_edited_or_added_files_reuse_nothing(checkout: Path, edited: str) -> None:
    target = str(checkout / "accept.json")
    acceptance.main([target])
    ran(checkout)
    (checkout / edited).write_text("2")
    acceptance.main([target])
    assert ran(checkout) == ["long", "new", "short"]
    assert {row["commit"] for row in json.loads(Path(target).read_text()).values()} == {""}


@pytest.mark.parametrize("edited", [False, True])
def test_a_check_that_was_not_run_has_not_passed(
    checkout: Path,
    edited: bool,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if edited:
        (checkout / "code").write_text("2")
    monkeypatch.setattr(acceptance, "run", lambda checks, costs, most_s: iter(()))
    assert acceptance.main([str(checkout / "accept.json"), "--minutes", "1"]) == 1
    assert capsys.readouterr().out.count("not run") == 3


def test_a_part_begins_only_what_ends_in_time() -> None:
    costs = {"long": 1000.0, **{f"short {k}": 1.0 for k in range(200)}}
    checks: dict[str, acceptance.Check] = {name: lambda: {"passed": True} for name in costs}
    ended = dict(acceptance.run(checks, costs, 500.0))
    assert len(ended) == len(costs)  # the longest is the first: a limit does not stop it for ever
    ended = dict(acceptance.run(checks, dict.fromkeys(costs, 1000.0), 500.0))
    assert 1 <= len(ended) <= (os.cpu_count() or 1)
