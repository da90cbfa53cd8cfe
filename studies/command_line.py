"""Run of frictool commands in this process, with the exit code and output that a shell sees."""

from __future__ import annotations

import io
import sys
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from unittest import mock

from frictool.cli.main import main


@dataclass(frozen=True)
class CommandResult:
    """Exit code, raw bytes of stdout, and stderr of a command."""

    code: int
    out: bytes
    stderr: str

    @property
    def stdout(self) -> str:
        return self.out.decode()


def run(*arguments: object) -> CommandResult:
    """Run `frictool ARGUMENTS` through `frictool.cli.main.main`; unexpected errors are raised."""
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
    return CommandResult(code, _bytes(out), _bytes(err).decode())


def _bytes(stream: io.TextIOWrapper) -> bytes:
    raw = stream.buffer
    assert isinstance(raw, io.BytesIO)
    return raw.getvalue()


def run_checked(*arguments: object) -> str:
    """Return the stdout of `frictool ARGUMENTS`.

    Raises
    ------
    RuntimeError
        If the command does not end with exit code 0.
    """
    result = run(*arguments)
    if result.code != 0:
        raise RuntimeError(f"frictool {arguments[0]} ended with {result.code}: {result.stderr}")
    return result.stdout
