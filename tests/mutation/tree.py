"""A clone of the last commit in which one mutant at a time is compiled and tested."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from frictool.runtime import kernel_folders, kernels
from tests.mutation.mutants import Mutant
from tests.mutation.selection import files_that_reach, import_graph

FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", re.MULTILINE)
NO_TESTS = 5  # pytest's exit code


@dataclass(frozen=True)
class Outcome:
    """Outcome of a mutant: `killed`, `survived` or `out of time`; the test that failed; the wall
    time [s]."""

    status: str
    test: str
    seconds: float


class Tree:
    """A clone of the checkout `root` in `folder`, and beside it a copy of the kernels that are
    compiled."""

    def __init__(self, root: Path, folder: Path) -> None:
        shutil.rmtree(folder, ignore_errors=True)
        subprocess.run(["git", "clone", "--quiet", "--shared", str(root), str(folder)], check=True)
        self.root, self.folder = root, folder
        self.excluded: list[str] = []  # tests that fail on the unedited program
        self.graph = import_graph(folder)
        self.places = folder.with_name(f"{folder.name}-kernels")
        shutil.rmtree(self.places, ignore_errors=True)
        if kernels.FOLDER is not None:
            shutil.copytree(kernels.FOLDER, self.places / kernels.FOLDER.name)

    def judge(self, mutant: Mutant, budget: float) -> Outcome:
        """Return whether a test notices `mutant` within `budget` seconds. A test that fails without
        the edit is left out."""
        before = self._states()
        try:
            return self._judge(mutant, budget)
        finally:
            for state in self._states() - before:
                shutil.rmtree(state, ignore_errors=True)

    def _judge(self, mutant: Mutant, budget: float) -> Outcome:
        module = mutant.path.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
        start = time.monotonic()
        for files in files_that_reach(self.graph, module):
            status = "failed"
            while status == "failed":
                left = budget - (time.monotonic() - start)
                if left <= 0.0:
                    return Outcome("out of time", "", budget)
                with self._edited(mutant):
                    status, test = self._run(files, left)
                if status == "out of time":
                    return Outcome(status, "", budget)
                if (
                    status == "failed"
                    and self._run([test] if test else files, budget)[0] == "passed"
                ):
                    return Outcome("killed", test, time.monotonic() - start)
                if status == "failed" and not test:
                    raise RuntimeError(f"{' '.join(files)}: pytest fails on the unedited program")
                if status == "failed":
                    self.excluded.append(test)
        return Outcome("survived", "", time.monotonic() - start)

    def _run(self, files: list[str], limit: float) -> tuple[str, str]:
        """Return (passed | failed | out of time, first test that failed)."""
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-q",
            "-rfE",
            "-n",
            "2" if len(files) > 1 else "0",
            *files,
        ]
        command += [f"--deselect={test}" for test in self.excluded]
        environment = {
            **os.environ,
            "PYTHONPATH": str(self.folder),
            "FRICTOOL_DATA": _data(self.root),
            "NUMBA_CACHE_DIR": str(self.places),
        }
        try:
            done = subprocess.run(
                command,
                cwd=self.folder,
                env=environment,
                capture_output=True,
                text=True,
                timeout=limit,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return "out of time", ""
        if done.returncode in (0, NO_TESTS):
            return "passed", ""
        found = FAILED.search(done.stdout)
        return "failed", found.group(1) if found else ""

    @contextmanager
    def _edited(self, mutant: Mutant) -> Iterator[None]:
        path = self.folder / mutant.path
        source = path.read_text()
        path.write_text(mutant.apply(source))
        try:
            yield
        finally:
            path.write_text(source)

    def _states(self) -> set[Path]:
        """Return the folders of compiled kernels: those of a mutant are the ones that it adds."""
        return {
            state.path
            for folder in self.places.glob("*/")
            for state in kernel_folders.states(folder)
        }


def _data(root: Path) -> str:
    return os.environ.get("FRICTOOL_DATA", str(root.parent / "shared" / "data"))
