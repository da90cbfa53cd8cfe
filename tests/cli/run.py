"""Runs a command line within the test's process, as a shell would see it: exit code, stdout,
stderr, raw bytes of stdout."""

from __future__ import annotations

import io
import sys
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from frictool.cli.main import main


@dataclass(frozen=True)
class Result:
    """What a finished process leaves behind."""

    code: int
    out: bytes
    stderr: str

    @property
    def stdout(self) -> str:
        return self.out.decode()


def run(*arguments: str | Path) -> Result:
    """`frictool ARGUMENTS` through `frictool.cli.main.main`. What is no foreseen error is raised,
    as a traceback would be."""
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
    err = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
    code = 0
    with ExitStack() as stack:
        stack.enter_context(mock.patch.object(sys, "argv", ["frictool", *map(str, arguments)]))
        stack.enter_context(redirect_stdout(out))
        stack.enter_context(redirect_stderr(err))
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else int(bool(stop.code))
    return Result(code, _bytes(out), _bytes(err).decode())


def _bytes(stream: io.TextIOWrapper) -> bytes:
    raw = stream.buffer
    assert isinstance(raw, io.BytesIO)
    return raw.getvalue()


def refused(result: Result, code: int, *words: str) -> None:
    """Asserts that the command ended with `code` and one line on stderr that holds `words`, and
    printed nothing else."""
    assert result.code == code, f"exit {result.code}: {result.stderr}"
    assert result.stderr.count("\n") == 1, result.stderr
    assert result.stderr.startswith("error: "), result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    for word in words:
        assert word in result.stderr, result.stderr


def also_called(path: Path, ending: str) -> Path:
    """A link to a file, so that a name with the ending of an output is that of an input."""
    link = path.with_name(f"link_to_{path.stem}{ending}")
    link.symlink_to(path.resolve())
    return link
