"""No line about ordinary logs is longer than 240 characters.

No refusal and no warning is longer than 200.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path

import msgspec
import pytest

from frictool.documents.bench import Bench
from frictool.documents.example_values import examples_words
from frictool.documents.quantity import Quantity
from frictool.documents.starting_documents import StartingRig, example_keys
from frictool.identify.fit_result import PARAMETERS, SLIDING, Interval, SlidingFit
from frictool.identify.fit_warnings import (
    contradiction_warnings,
    doubt_warnings,
    replacement_warnings,
)
from frictool.identify.identification import Identification, NothingIdentified
from frictool.identify.rows.effects import WHAT
from frictool.identify.unmodelled_effects import WidenedFit
from frictool.presentation.line_breaking import INDENT, LONGEST, bounded
from frictool.verify.certified_intervals import outside_message
from studies.command_line import run
from tests.support.linear_axis import linear_bench
from tests.support.short_logs import first_part
from tests.support.statements import statements

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
def test_no_line_is_long(command: list[str], kind: str, tmp_path: Path) -> None:
    log = tmp_path / f"{kind}.csv"
    log.write_text(first_part(f"{kind}.csv", 6000))
    result = run(*command, log, "--bench", BENCH)
    text = result.stdout + result.stderr.replace(str(ROOT), "").replace(str(tmp_path), "")
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
    for node in statements(ast.parse(source)):
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            call = node.exc  # of `Error(...)`, or of `Error(...).at(...)`
            while isinstance(call.func, ast.Attribute) and isinstance(call.func.value, ast.Call):
                call = call.func.value
            yield node.lineno, max(map(text_length, call.args), default=0)


def too_long(modules: list[Path], lengths: Callable[[str], Iterator[tuple[int, int]]]) -> list[str]:
    """Return place and length of each text that is too long for a line with its place."""
    return [
        f"{path.relative_to(ROOT)}:{line}: {length} characters"
        for path in modules
        for line, length in lengths(path.read_text())
        if length > LONGEST_REFUSAL - PLACE
    ]


def test_no_refusal_is_long() -> None:
    modules = sorted((ROOT / "frictool").rglob("*.py"))
    assert modules
    assert not too_long(modules, refusals)


def messages(source: str) -> Iterator[tuple[int, int]]:
    """Yield the line and the length of each text of a module that is no docstring."""
    tree = ast.parse(source)
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant | ast.JoinedStr) and id(node) not in docstrings:
            yield node.lineno, text_length(node)


def test_no_message_of_identify_is_long() -> None:
    """Pages and the test plans of `excite` have longer texts."""
    modules = [
        path
        for path in sorted((ROOT / "frictool/identify").rglob("*.py"))
        if path.parent.name not in ("model_page", "excite") and path.name != "text_view.py"
    ]
    assert len(modules) > 50
    assert not too_long(modules, messages)


WIDE = Interval(-1.234e-05, -2.345e-05, -1.111e-05)
FIT = SlidingFit(dict.fromkeys(SLIDING, WIDE), {}, 0.5, None, 1.0, 1000, force_error=0.0123)


def known_bench() -> Bench:
    """Return a bench that contradicts WIDE in every parameter."""
    bench = linear_bench()
    known = Quantity(1.234e-05, 1.111e-05, 2.345e-05)
    names = dict.fromkeys((*PARAMETERS, "stribeck_velocity"), known)
    mechanics = msgspec.structs.replace(
        bench.mechanics,
        **{name: one for name, one in names.items() if hasattr(bench.mechanics, name)},
    )
    return msgspec.structs.replace(bench, mechanics=mechanics)


def test_a_warning_of_several_parameters_is_one_short_line() -> None:
    bench = known_bench()
    worse = replace(FIT, force_error=0.456)
    effect = WidenedFit(FIT, beyond=(max(WHAT.values(), key=len), SLIDING))
    warnings = [
        *contradiction_warnings(dict.fromkeys((*PARAMETERS, "stribeck_velocity"), WIDE), bench),
        *replacement_warnings(FIT, worse, {}),
        *doubt_warnings(worse, "least-squares"),
        *doubt_warnings(replace(FIT, residual=0.456), "least-squares"),
        *chain.from_iterable(effect.doubts(FIT.parameters).values()),
    ]
    assert len(warnings) >= 8
    assert max(map(len, warnings)) <= LONGEST_REFUSAL
    (replaced,) = replacement_warnings(FIT, worse, {})
    assert "inertia" in replaced
    assert "and 3 more" in replaced


def test_a_refusal_of_several_parameters_names_the_most_frequent_reason() -> None:
    reasons = [f"{name} {'is not determined by this log ' * 5}" for name in ("one", "two")]
    refused = dict.fromkeys(SLIDING, reasons[1]) | {"inertia": reasons[0]}
    error = NothingIdentified(
        Identification(refused=refused, method="auto", confidence=0.95, kinds={})
    )
    assert str(error).startswith("viscous, coulomb, offset: two ")
    assert str(error).endswith("(others: 1)")
    assert len(str(error)) <= LONGEST_REFUSAL
    assert list(error.reasons.values()) == [["inertia"], ["viscous", "coulomb", "offset"]]


def test_a_warning_about_a_plant_outside_the_certificate_is_one_short_line() -> None:
    phrases = [f"inertia {k}e-06 to 5.1e-06, verified 1.11e-05 to 1.53e-05" for k in range(9)]
    line = f"model {outside_message('controller', phrases)}"
    assert len(line) <= 200
    assert f"{phrases[0]} and 8 more" in line


def test_a_warning_of_example_values_is_one_short_line() -> None:
    keys = example_keys(StartingRig("rig", "linear"))
    (bench,) = (names for document, names in keys.items() if document == "bench.yaml")
    assert len(bench) > 9
    assert len(examples_words({"": bench})) <= LONGEST_REFUSAL
    assert len(examples_words({"bench": bench, "spec": bench, "scenario": bench})) <= (
        LONGEST_REFUSAL + PLACE
    )
