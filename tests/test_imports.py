"""Test files and acceptance checks share code by `tests/support` and `studies`, not by imports of
each other."""

from __future__ import annotations

import ast
from pathlib import Path

from tests.support.statements import statements

ROOT = Path(__file__).parents[1]


def _imports_of_tests(source: str) -> set[str]:
    """Return the modules named `test_*` or `check_*` that a source imports."""
    modules: set[str] = set()
    for node in statements(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.module:
            modules |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
    return {
        name
        for name in modules
        if name.startswith("tests.") and name.rpartition(".")[2].startswith(("test_", "check_"))
    }


def test_no_module_imports_a_test_file() -> None:
    found = {
        str(path.relative_to(ROOT)): names
        for path in sorted((ROOT / "tests").rglob("*.py"))
        if (names := _imports_of_tests(path.read_text(encoding="utf-8")))
    }
    assert found == {}


def test_an_import_of_a_test_file_is_noticed() -> None:
    assert _imports_of_tests("from tests.a import test_b\nimport tests.c.check_d") == {
        "tests.a.test_b",
        "tests.c.check_d",
    }
    assert _imports_of_tests("from tests.a.test_b import HERE") == {"tests.a.test_b"}
    assert _imports_of_tests("from tests.support.b import HERE") == set()
