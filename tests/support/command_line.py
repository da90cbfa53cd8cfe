"""Assertions on commands, and names of files, for tests that run commands."""

from __future__ import annotations

from pathlib import Path

from studies.command_line import CommandResult


def refused(result: CommandResult, code: int, *words: str) -> None:
    """Assert exit code `code`, one line on stderr that holds `words`, and nothing else printed."""
    assert result.code == code, f"exit {result.code}: {result.stderr}"
    assert result.stderr.count("\n") == 1, result.stderr
    assert result.stderr.startswith("error: "), result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    for word in words:
        assert word in result.stderr, result.stderr


def also_called(path: Path, ending: str) -> Path:
    """Return a link to `path` whose name has the ending of an output."""
    link = path.with_name(f"link_to_{path.stem}{ending}")
    link.symlink_to(path.resolve())
    return link
