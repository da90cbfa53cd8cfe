"""The `console` blocks of the documentation: what takes minutes is made here, each line in a copy of its own, and has to end as make says.

The other blocks run in `make test` (tests/docs).
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from tests.docs.pages import PAGES, ROOT, blocks
from tests.docs.playing import COMMENT, DATA, scratch


def made(command: str) -> dict[str, Any]:
    """Passed where the command ends with exit code 0, run at the top of a copy with the frictool of this clone."""
    with tempfile.TemporaryDirectory() as folder:
        copy = scratch(Path(folder))
        for name in ("tests", "frictool", "benchmarks"):
            (copy / name).symlink_to(ROOT / name)
        tools = {"FRICTOOL": f"{Path(sys.executable).parent}/frictool", "PYTHON": sys.executable}
        line = " ".join([command, *(f"{name}={path}" for name, path in tools.items())])
        done = subprocess.run(
            ["bash", "-c", line], cwd=copy, env={**os.environ, "FRICTOOL_DATA": str(DATA)}, capture_output=True, text=True
        )
        return {"passed": done.returncode == 0, "code": done.returncode, "end": (done.stderr or done.stdout)[-300:]}


def _lines() -> list[str]:
    """The lines of all pages, each once: those of `make`. A `python -m tests.accept` among them runs its checks by itself."""
    lines = [COMMENT.sub("", line).strip() for page in PAGES for block in blocks(page, "console") for line in block.lines]
    return sorted({line for line in lines if line.startswith("make ")})


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {f"docs: {line}": partial(made, line) for line in _lines()}
