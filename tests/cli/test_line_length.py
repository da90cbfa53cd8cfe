"""No line about ordinary logs is longer than 240 characters, and no refusal longer than 200."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from frictool.identify.line_breaking import INDENT, LONGEST, bounded
from studies.command_line import run

ROOT = Path(__file__).parents[2]
BENCH = ROOT / "configs/clutch/bench.yaml"
LONGEST_REFUSAL = 200  # characters, without paths
PLACE = 10  # characters before the text of a refusal, without the path
VALUE = 12  # characters of a value that a refusal contains


@pytest.mark.parametrize("kind", ["sines", "steps", "ramp"])
@pytest.mark.parametrize(
    "command",
    [["info"], ["identify"], ["identify", "--method", "least-squares"], ["assess"]],
    ids=" ".join,
)
def test_no_line_is_long(command: list[str], kind: str) -> None:
    result = run(*command, ROOT / f"sample_logs/{kind}.csv", "--bench", BENCH)
    text = result.stdout + result.stderr.replace(str(ROOT), "")
    assert text
    assert max(map(len, text.splitlines())) <= LONGEST


def test_a_long_line_is_broken_between_words_and_its_rest_is_indented() -> None:
    line = "  chosen: " + "word " * 100 + "end"
    first, *rest = bounded(["short", line]).splitlines()[1:]
    assert first.startswith("  chosen: word")
    assert all(one.startswith(" " * (2 + INDENT) + "word") for one in rest)
    assert " ".join([first, *map(str.strip, rest)]) == line


def text_length(node: ast.expr) -> int:
    """Return the characters of a text in the code, with VALUE for each value in it."""
    match node:
        case ast.Constant(value=str(text)):
            return len(text)
        case ast.JoinedStr(values=parts):
            return sum(map(text_length, parts))
        case ast.BinOp(left=left, right=right):
            return text_length(left) + text_length(right)
        case ast.IfExp(body=body, orelse=other):
            return max(text_length(body), text_length(other))
    return VALUE


def refusals(source: str) -> Iterator[tuple[int, int]]:
    """Yield the line and the length of the message of each exception that a module raises."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            call = node.exc  # of `Error(...)`, or of `Error(...).at(...)`
            while isinstance(call.func, ast.Attribute) and isinstance(call.func.value, ast.Call):
                call = call.func.value
            yield node.lineno, max(map(text_length, call.args), default=0)


def test_no_refusal_is_long() -> None:
    modules = sorted((ROOT / "frictool").rglob("*.py"))
    assert modules
    long = [
        f"{path.relative_to(ROOT)}:{line}: {length} characters"
        for path in modules
        for line, length in refusals(path.read_text())
        if length > LONGEST_REFUSAL - PLACE
    ]
    assert not long
