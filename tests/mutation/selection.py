"""Test selection: the test files that reach a module, the nearest in the import graph first."""

from __future__ import annotations

import re
from collections import deque
from pathlib import Path

FROM = re.compile(
    r"^\s*from ((?:frictool|studies|tests)[\w.]*) import \(?([^#\n]*(?:\n    [^)]*)?)", re.MULTILINE
)
PLAIN = re.compile(r"^\s*import ((?:frictool|studies|tests)[\w.]*)", re.MULTILINE)
QUOTED = re.compile(
    r"\"(frictool\.[\w.]+)\""
)  # a table of modules that are imported when they are used
OF_PACKAGE = re.compile(r"import_module\(f\"(frictool[\w.]*)\.\{")


def import_graph(root: Path) -> dict[str, set[str]]:
    """Return the modules that each module of `frictool`, `studies` and `tests` imports."""
    paths = {
        _dotted(path.relative_to(root)): path
        for top in ("frictool", "studies", "tests")
        for path in sorted((root / top).rglob("*.py"))
    }
    graph = {}
    for name, path in paths.items():
        text = path.read_text()
        imported = {*PLAIN.findall(text), *QUOTED.findall(text)}
        for package in OF_PACKAGE.findall(text):
            imported |= {module for module in paths if module.startswith(f"{package}.")}
        for package, names in FROM.findall(text):
            imported |= {package, *(f"{package}.{word}" for word in re.findall(r"\w+", names))}
        graph[name] = (imported & paths.keys()) - {name}
    return graph


def dependents(graph: dict[str, set[str]], module: str) -> dict[str, int]:
    """Return every module that imports `module`, directly or not, with its distance."""
    importers: dict[str, set[str]] = {}
    for name, imported in graph.items():
        for target in imported:
            importers.setdefault(target, set()).add(name)
    distances, queue = {module: 0}, deque([module])
    while queue:
        current = queue.popleft()
        for name in sorted(importers.get(current, ())):
            if name not in distances:
                distances[name] = distances[current] + 1
                queue.append(name)
    return distances


def files_that_reach(graph: dict[str, set[str]], module: str) -> list[list[str]]:
    """Return the test files that reach `module`, in groups of one distance, the nearest first;
    `tests/docs` is left out.

    Of one distance, files in the test folder of the module's own package come first.
    """
    package = module.split(".")[1]
    groups: dict[tuple[int, bool], list[str]] = {}
    for name, distance in dependents(graph, module).items():
        parts = name.split(".")
        if parts[0] == "tests" and parts[-1].startswith("test_") and parts[1] != "docs":
            groups.setdefault((distance, parts[1] != package), []).append("/".join(parts) + ".py")
    return [sorted(groups[key]) for key in sorted(groups)]


def _dotted(path: Path) -> str:
    return ".".join(path.with_suffix("").parts).removesuffix(".__init__")
