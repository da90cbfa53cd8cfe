"""Analysis of one module's syntax tree: digest without comments and docstrings, imports, names."""

from __future__ import annotations

import ast
import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# (level, module, name); name "" is the module itself, "*" all names in it
Import = tuple[int, str, str]
BY_NAME = {"import_module", "__import__", "exec", "eval"}
ANALYSIS = (
    hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:8]
    if Path(__file__).is_file()
    else "none"
)


@dataclass(frozen=True)
class ModuleSource:
    """Facts about a module's source, from which the module's dependencies follow.

    digest: digest of the syntax tree.
    imports: imports of the module.
    names: names that the module defines or imports.
    table: if the module is a package, maps each name that the package imports only at first use to
        the module that defines this name, relative to the package.
    is_open: True if the module imports another module by a computed name.
    """

    digest: str
    imports: tuple[Import, ...]
    names: frozenset[str]
    table: dict[str, str]
    is_open: bool


def analyse(content: bytes) -> ModuleSource:
    """Analyse the source of a module; raise SyntaxError or ValueError if `content` is invalid."""
    tree = ast.parse(content)
    names = frozenset(_bound(tree))
    table = _table(tree)
    imports: set[Import] = set()
    is_open = False
    skipped = {
        id(child)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and _is_for_checkers(node)
        for top in node.body
        for child in ast.walk(top)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            called = node.func
            is_open |= (
                called.id if isinstance(called, ast.Name) else getattr(called, "attr", "")
            ) in BY_NAME
        if isinstance(node, (ast.Import, ast.ImportFrom)) and id(node) not in skipped:
            imports.update(_imports(node))
    _strip(tree)
    return ModuleSource(
        hashlib.sha256(ast.dump(tree).encode()).hexdigest()[:32],
        tuple(sorted(imports)),
        names,
        table,
        is_open,
    )


def _is_for_checkers(node: ast.If) -> bool:
    return (getattr(node.test, "id", "") or getattr(node.test, "attr", "")) == "TYPE_CHECKING"


def _imports(node: ast.Import | ast.ImportFrom) -> list[Import]:
    if isinstance(node, ast.ImportFrom):
        return [(node.level, node.module or "", alias.name) for alias in node.names]
    return [
        (0, alias.name if alias.asname else alias.name.split(".")[0], "") for alias in node.names
    ]


def _bound(tree: ast.Module) -> set[str]:
    names = set()
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            names |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            names |= {
                one.id
                for one in ast.walk(node)
                if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)
            }
    return names


def _table(tree: ast.Module) -> dict[str, str]:
    calls = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "lazy_exports"
    ]
    origins: dict[str, str] = {}
    for node in (
        argument for call in calls for argument in call.args if isinstance(argument, ast.Dict)
    ):
        for module, names in ast.literal_eval(node).items():
            origins |= dict.fromkeys(names, module)
    return origins


def _strip(tree: ast.Module) -> None:
    node: Any
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [one for one in body if not _is_text(one)]


def _is_text(statement: ast.stmt) -> bool:
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )
