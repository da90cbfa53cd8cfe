"""Where a key stands in a document's file."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.documents.key_lines import line_of

TEXT = """\
# a comment
format: scenario/1
steps:
  - {reference: {value: 1, unit: rad}, duration_s: 1}
  -
    reference:
      value: 2
      unit: rad
start: {value: 5,
  unit: rad}
"""


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("format", 2),
        ("steps", 3),
        ("steps[0]", 4),
        ("steps[0].duration_s", 4),
        ("steps[1].reference.unit", 8),
        ("start.unit", 10),
        (
            "steps[1].nothing",
            6,
        ),  # the last that is there: the item, whose text begins below its dash
        ("steps[7].reference", 3),
        ("nothing", 2),
        ("", 2),
    ],
)
def test_the_line_of_a_key(key: str, line: int, tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text(TEXT)
    assert line_of(path, key) == line


def test_a_file_that_is_gone_or_broken_has_no_lines(tmp_path: Path) -> None:
    assert line_of(tmp_path / "none.yaml", "format") is None
    (tmp_path / "broken.yaml").write_text("a: [1, 2")
    assert line_of(tmp_path / "broken.yaml", "a") is None
