"""The mutants are edits of running code, drawn alike by one seed; a test that imports the module
comes before one that does not."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.mutation.mutants import draw, mutants_of
from tests.mutation.selection import files_that_reach, import_graph
from tests.mutation.tree import FAILED

SOURCE = '''"""A docstring - no code."""
def f(a: float | None, b: int = -3) -> float | None:
    return max(a, b) if a <= b and not a else a * 2.5
'''


def test_every_mutant_is_another_program_on_its_line():
    mutants = mutants_of("m.py", SOURCE)
    assert {mutant.original for mutant in mutants} == {
        "-",
        "3",
        "max",
        "<=",
        "and",
        "not ",
        "*",
        "2.5",
    }
    trees = {ast.dump(ast.parse(mutant.apply(SOURCE))) for mutant in mutants}
    assert len(trees) == len(mutants)
    assert ast.dump(ast.parse(SOURCE)) not in trees
    for mutant in mutants:
        changed = [
            i
            for i, (old, new) in enumerate(
                zip(SOURCE.split("\n"), mutant.apply(SOURCE).split("\n"), strict=True), 1
            )
            if old != new
        ]
        assert changed == [mutant.line]


def test_a_seed_draws_the_same_lines_and_each_once():
    root = Path(__file__).parents[2]
    drawn = draw(root, ["frictool/metrics"], 20, "seed")
    assert drawn == draw(root, ["frictool/metrics"], 20, "seed")
    assert drawn != draw(root, ["frictool/metrics"], 20, "another")
    assert len({(mutant.path, mutant.line) for mutant in drawn}) == 20


def test_a_rig_of_studies_links_a_test_to_the_package():
    graph = import_graph(Path(__file__).parents[2])
    assert "studies.rigs.clutch_model" in graph["tests.synth.test_weights"]
    assert "frictool.documents.model" in graph["studies.rigs.clutch_model"]


def test_the_nearest_tests_come_first():
    graph = {
        "frictool.a.x": set(),
        "frictool.b.y": {"frictool.a.x"},
        "tests.a.test_x": {"frictool.a.x"},
        "tests.c.test_x": {"frictool.a.x"},
        "tests.b.test_y": {"frictool.b.y"},
        "tests.docs.test_pages": {"frictool.a.x"},
        "tests.a.rig": {"frictool.a.x"},
    }
    assert files_that_reach(graph, "frictool.a.x") == [
        ["tests/a/test_x.py"],
        ["tests/c/test_x.py"],
        ["tests/b/test_y.py"],
    ]


@pytest.mark.parametrize(
    ("line", "test"),
    [
        ("FAILED tests/a/test_x.py::test_it - assert 1 == 2", "tests/a/test_x.py::test_it"),
        (
            "FAILED tests/a/test_x.py::test_it[full rank] - E: no",
            "tests/a/test_x.py::test_it[full rank]",
        ),
        ("ERROR tests/a/test_x.py", "tests/a/test_x.py"),
    ],
)
def test_a_failed_test_is_named_as_pytest_finds_it(line: str, test: str) -> None:
    found = FAILED.search(f"1 failed\n{line}\n2 passed")
    assert found is not None
    assert found.group(1) == test
