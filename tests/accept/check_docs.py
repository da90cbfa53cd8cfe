"""The `console` blocks of the documentation: what takes minutes is made here, each line in a copy
of its own.

It has to end as make says, and print what the `text` block beneath shows. The other blocks run in
`make test` (tests/docs).
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

from tests.support.documentation_pages import PAGES, ROOT, blocks
from tests.support.documentation_player import (
    COMMENT,
    DATA,
    first_missing,
    run_notebook,
    scratch,
)


def made(command: str, shown: list[str]) -> dict[str, Any]:
    """Passed where the command ends with exit code 0 and prints `shown`, run at the top of a copy
    with the frictool of this clone."""
    with tempfile.TemporaryDirectory() as folder:
        copy = scratch(Path(folder))
        for name in ("tests", "studies", "frictool", "benchmarks"):
            (copy / name).symlink_to(ROOT / name)
        tools = {"FRICTOOL": f"{Path(sys.executable).parent}/frictool", "PYTHON": sys.executable}
        line = " ".join([command, *(f"{name}={path}" for name, path in tools.items())])
        done = subprocess.run(
            ["bash", "-c", line],
            cwd=copy,
            env={**os.environ, "FRICTOOL_DATA": str(DATA)},
            capture_output=True,
            text=True,
        )
        missing = first_missing(done.stdout.splitlines(), shown)
        told = {
            "code": done.returncode,
            "not printed": missing or "",
            "end": (done.stderr or done.stdout)[-300:],
        }
        return {"passed": done.returncode == 0 and missing is None, **told}


def _lines() -> Iterator[tuple[str, list[str]]]:
    """The lines of `make` of all pages, with the `text` that stands beneath, for any line where
    there is none.

    A `python -m tests.accept` among them runs its checks by itself.
    """
    for page in PAGES:
        found = blocks(page)
        for block, next_one in itertools.zip_longest(found, found[1:]):
            if block.language != "console":
                continue
            shown = (
                next_one.lines if next_one is not None and next_one.language == "text" else ["..."]
            )
            yield from (
                (COMMENT.sub("", line).strip(), shown)
                for line in block.lines
                if line.startswith("make ")
            )


def runs_a_notebook() -> dict[str, Any]:
    """Passed where the notebook of the tutorial of `plan` ends and prints its promise."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    page = (ROOT / "docs/tutorial_plan.md").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ, {"PATH": path}):
        printed = run_notebook(page, scratch(Path(folder)))
    return {"passed": "promise coulomb" in printed, "end": printed[-300:]}


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "docs: a notebook runs to its end": runs_a_notebook,
    **{f"docs: {line}": partial(made, line, shown) for line, shown in _lines()},
}
