"""Mutants: single edits of an operator, a constant or a call, found in the syntax tree and drawn by
a seed."""

from __future__ import annotations

import ast
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ARITHMETIC = {
    ast.Add: "-",
    ast.Sub: "+",
    ast.Mult: "/",
    ast.Div: "*",
    ast.Pow: "*",
    ast.FloorDiv: "*",
    ast.Mod: "//",
}
COMPARISONS = {
    ast.Lt: "<=",
    ast.LtE: "<",
    ast.Gt: ">=",
    ast.GtE: ">",
    ast.Eq: "!=",
    ast.NotEq: "==",
}
SYMBOLS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
OPERATORS = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "**",
    ast.FloorDiv: "//",
    ast.Mod: "%",
}
OPPOSITES = (("min", "max"), ("minimum", "maximum"), ("floor", "ceil"), ("argmin", "argmax"))
CALLS = {name: other for pair in OPPOSITES for name, other in (pair, pair[::-1])}


@dataclass(frozen=True)
class Mutant:
    """One edit: the characters `[start, stop)` of `path`, on line `line`, become `replacement`."""

    path: str
    line: int
    start: int
    stop: int
    original: str
    replacement: str

    def apply(self, source: str) -> str:
        """Return `source` with the edit made."""
        return source[: self.start] + self.replacement + source[self.stop :]

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: `{self.original}` -> `{self.replacement}`"


def draw(root: Path, folders: list[str], count: int, seed: str) -> list[Mutant]:
    """Return `count` mutants on different lines of `folders` below `root`, drawn by `seed`."""
    by_line: dict[tuple[str, int], list[Mutant]] = {}
    for folder in folders:
        for path in sorted((root / folder).rglob("*.py")):
            for mutant in mutants_of(str(path.relative_to(root)), path.read_text()):
                by_line.setdefault((mutant.path, mutant.line), []).append(mutant)
    generator = random.Random(seed)
    lines = generator.sample(sorted(by_line), min(count, len(by_line)))
    return [generator.choice(by_line[line]) for line in lines]


def mutants_of(path: str, source: str) -> list[Mutant]:
    """Return every mutant of a module, in the order of its text. Annotations and docstrings have
    none."""
    lines = source.splitlines(keepends=True)
    starts = [0]
    for text in lines:
        starts.append(starts[-1] + len(text))
    encoded = [text.encode() for text in lines]

    def offset(line: int, column: int) -> int:  # the syntax tree counts columns in bytes
        return starts[line - 1] + len(encoded[line - 1][:column].decode())

    def between(left: ast.expr, right: ast.expr, symbol: str, replacement: str) -> Iterator[Mutant]:
        low, high = (
            offset(left.end_lineno or 0, left.end_col_offset or 0),
            offset(right.lineno, right.col_offset),
        )
        at = source.find(symbol, low, high)
        if at >= 0 and "#" not in source[low:at]:
            yield Mutant(
                path, source.count("\n", 0, at) + 1, at, at + len(symbol), symbol, replacement
            )

    found: list[Mutant] = []
    for node in _code(ast.parse(source)):
        if isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
            found += between(
                node.left, node.right, OPERATORS[type(node.op)], ARITHMETIC[type(node.op)]
            )
        elif isinstance(node, ast.Compare):
            for left, operator, right in zip(
                [node.left, *node.comparators], node.ops, node.comparators, strict=False
            ):
                if type(operator) in COMPARISONS:
                    found += between(
                        left, right, SYMBOLS[type(operator)], COMPARISONS[type(operator)]
                    )
        elif isinstance(node, ast.BoolOp):
            symbol, other = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
            for left, right in zip(node.values, node.values[1:], strict=False):
                found += between(left, right, symbol, other)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            at = offset(node.lineno, node.col_offset)
            symbol = "-" if isinstance(node.op, ast.USub) else "not "
            if source.startswith(symbol, at):
                found.append(Mutant(path, node.lineno, at, at + len(symbol), symbol, ""))
        elif (
            isinstance(node, ast.Constant)
            and type(node.value) in (int, float)
            and node.end_lineno == node.lineno
        ):
            at, end = (
                offset(node.lineno, node.col_offset),
                offset(node.lineno, node.end_col_offset or 0),
            )
            found.append(
                Mutant(path, node.lineno, at, end, source[at:end], f"({source[at:end]} + 1)")
            )
        elif isinstance(node, ast.Call):
            name = (
                node.func.attr
                if isinstance(node.func, ast.Attribute)
                else getattr(node.func, "id", "")
            )
            if name in CALLS:
                end = offset(node.func.end_lineno or 0, node.func.end_col_offset or 0)
                found.append(
                    Mutant(path, node.func.end_lineno or 0, end - len(name), end, name, CALLS[name])
                )
    return sorted(found, key=lambda mutant: mutant.start)


def _code(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes that run: no annotations, and no `X | Y` of types."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield child
                yield from _code(child)
