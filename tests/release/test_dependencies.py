"""The declared dependencies of an installation are the imports of the package, and the other way
round."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from importlib import metadata

from frictool import __version__
from studies.rigs.clutch_model import ROOT
from tests.support.statements import statements

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
FIRST_NAME = re.compile(r"[A-Za-z0-9._-]+")
# by numba, mcap, jinja2 and dask, with which they are one
BROUGHT_ALONG = {"llvmlite", "lz4", "zstandard", "markupsafe", "distributed"}


def normal(name: str) -> str:
    """As package indices compare names."""
    return re.sub(r"[-_.]+", "-", name).lower()


def asked_for(requirements: list[str]) -> set[str]:
    return {normal(found[0]) for one in requirements if (found := FIRST_NAME.match(one))}


def imported() -> set[str]:
    """Distributions whose modules the package imports, anywhere in it."""
    modules = set[str]()
    for path in (ROOT / "frictool").rglob("*.py"):
        for node in statements(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                modules |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                modules.add(node.module.partition(".")[0])
    of = metadata.packages_distributions()
    return {
        normal(of[name][0])
        for name in modules - set(sys.stdlib_module_names) - {"frictool"}
        if name in of
    }


def test_every_dependency_is_imported_and_every_import_is_asked_for() -> None:
    needed = asked_for(PROJECT["dependencies"])
    optional = set().union(
        *(
            asked_for(found)
            for name, found in PROJECT["optional-dependencies"].items()
            if name not in ("dev", "bench")
        )
    )
    used = imported()
    assert needed <= used, "asked for, and imported by nothing"
    assert used <= needed | optional | BROUGHT_ALONG, "imported, and asked for by nothing"


def test_one_version() -> None:
    """The version of the package, of its installation and of its citation are one."""
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert cited is not None
    assert __version__ == cited[1] == metadata.version("frictool")
