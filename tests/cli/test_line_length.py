"""No line that a command prints for people about ordinary logs is longer than 240 characters."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.identify.line_breaking import INDENT, LONGEST, bounded
from studies.command_line import run

ROOT = Path(__file__).parents[2]
BENCH = ROOT / "configs/clutch/bench.yaml"


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
