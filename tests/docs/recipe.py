"""Copy of the package to which a test adds what a recipe of CONTRIBUTING.md says."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tests.support.documentation_pages import ROOT


@dataclass(frozen=True)
class CopiedPackage:
    """Copy of `frictool/` in `folder`, which commands run in processes of their own."""

    folder: Path

    @classmethod
    def into(cls, folder: Path) -> CopiedPackage:
        """Return the copy, without compiled files."""
        shutil.copytree(
            ROOT / "frictool", folder / "frictool", ignore=shutil.ignore_patterns("__pycache__")
        )
        return cls(folder)

    def insert(self, path: str, before: str, text: str) -> None:
        """Insert `text` before the one line of a file that begins with `before`."""
        file = self.folder / path
        lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
        (at,) = [index for index, line in enumerate(lines) if line.startswith(before)]
        file.write_text("".join([*lines[:at], text, *lines[at:]]), encoding="utf-8")

    def run(self, *arguments: str | Path, code: int = 0) -> subprocess.CompletedProcess[str]:
        """Run `frictool ARGUMENTS` of the copy, and assert that it ends with the exit code."""
        result = subprocess.run(
            [sys.executable, "-P", "-m", "frictool", *map(str, arguments)],
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONPATH": str(self.folder), "COLUMNS": "100"},
            check=False,
        )
        assert result.returncode == code, result.stderr
        return result
