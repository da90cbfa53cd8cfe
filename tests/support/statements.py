"""Statements of a module, without the expressions in them, which are most of its nodes."""

from __future__ import annotations

import ast
from collections.abc import Iterator

PARTS = ("body", "orelse", "finalbody", "handlers", "cases")


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield every statement of `tree`, those of functions, classes and branches too."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        inner = [one for part in PARTS for one in getattr(node, part, ())]
        yield from inner
        waiting += inner
