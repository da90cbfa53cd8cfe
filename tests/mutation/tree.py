"""A clone of the last commit in which one mutant at a time is compiled and tested."""

from __future__ import annotations

import hashlib
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

from frictool import kernel_cache
from frictool.kernels import ROOMS, toolchain
from tests.mutation.mutants import Mutant
from tests.mutation.selection import dependents, files_that_reach, import_graph

FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)
NO_TESTS = 5  # pytest's exit code


@dataclass(frozen=True)
class Outcome:
    """Outcome of a mutant: `killed`, `survived` or `out of time`; the test that failed; the wall time [s]."""

    status: str
    test: str
    seconds: float


class Tree:
    """A clone of the checkout `root` in `folder`, with the kernels that `root` has compiled."""

    def __init__(self, root: Path, folder: Path) -> None:
        shutil.rmtree(folder, ignore_errors=True)
        subprocess.run(["git", "clone", "--quiet", "--shared", str(root), str(folder)], check=True)
        self.root, self.folder = root, folder
        self.excluded: list[str] = []  # tests that fail on the unedited program
        self.compiled: set[Path] = set()  # folders of kernels of mutants
        self.graph = import_graph(folder)
        self._seed(self._kernels(root), self._kernels(folder), root, set())

    def judge(self, mutant: Mutant, budget: float) -> Outcome:
        """Return whether a test notices `mutant` within `budget` seconds. A test that fails without the edit is left out."""
        try:
            return self._judge(mutant, budget)
        finally:
            for folder in self.compiled:
                shutil.rmtree(folder, ignore_errors=True)

    def _judge(self, mutant: Mutant, budget: float) -> Outcome:
        module = mutant.path.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
        start = time.monotonic()
        for files in files_that_reach(self.graph, module):
            status = "failed"
            while status == "failed":
                left = budget - (time.monotonic() - start)
                if left <= 0.0:
                    return Outcome("out of time", "", budget)
                with self._edited(mutant, module):
                    status, test = self._run(files, left)
                if status == "failed" and self._run([test] if test else files, budget)[0] == "passed":
                    return Outcome("killed", test, time.monotonic() - start)
                if status == "failed" and not test:
                    raise RuntimeError(f"{' '.join(files)}: pytest fails on the unedited program")
                if status == "failed":
                    self.excluded.append(test)
        return Outcome("survived", "", time.monotonic() - start)

    def _run(self, files: list[str], limit: float) -> tuple[str, str]:
        """Return (passed | failed | out of time, first test that failed)."""
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "-n", "2" if len(files) > 1 else "0", *files]
        command += [f"--deselect={test}" for test in self.excluded]
        environment = {**os.environ, "PYTHONPATH": str(self.folder), "FRICTOOL_DATA": _data(self.root)}
        try:
            done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True, timeout=limit, check=False)
        except subprocess.TimeoutExpired:
            return "out of time", ""
        if done.returncode in (0, NO_TESTS):
            return "passed", ""
        found = FAILED.search(done.stdout)
        return "failed", found.group(1) if found else ""

    @contextmanager
    def _edited(self, mutant: Mutant, module: str) -> Iterator[None]:
        path = self.folder / mutant.path
        source = path.read_text()
        path.write_text(mutant.apply(source))
        if (edited := self._kernels(self.folder)) not in self.compiled and not edited.exists():
            self.compiled.add(edited)
            path.write_text(source)
            unedited = self._kernels(self.folder)
            path.write_text(mutant.apply(source))
            self._seed(unedited, edited, self.folder, set(dependents(self.graph, module)))
        try:
            yield
        finally:
            path.write_text(source)

    def _seed(self, source: Path, target: Path, origin: Path, skipped: set[str]) -> None:
        """Copy the kernels that the checkout `origin` has compiled, for all modules but `skipped`."""
        for compiled in source.rglob("*.nb[ic]"):
            package = next((room for room in ROOMS if compiled.parent.name == _cache_name(origin / "frictool" / room)), None)
            if package is None or f"frictool/{package}/{compiled.name.split('.')[0]}".replace("/", ".") in skipped:
                continue
            copy = target / _cache_name(self.folder / "frictool" / package) / compiled.name
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(compiled, copy)

    def _kernels(self, checkout: Path) -> Path:
        package = checkout / "frictool"
        return package / "__pycache__" / kernel_cache.folder_name(package, ROOMS, toolchain())


def _cache_name(folder: Path) -> str:
    """Return the name that numba gives to the cache of a source folder."""
    return f"{folder.name}_{hashlib.sha1(str(folder).encode()).hexdigest()}"


def _data(root: Path) -> str:
    return os.environ.get("FRICTOOL_DATA", str(root.parent / "shared" / "data"))
