"""The documentation defines every metric and every requirement, and names the files that hold them."""

from __future__ import annotations

import re

from frictool.documents.spec import Spec
from frictool.report.metric_table import HOLD_METRICS, STREAM_METRICS
from tests.report.example import ROOT

TEXT = (ROOT / "docs/theory/report.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[str]:
    section = TEXT.split(f"## {heading}\n")[1].split("\n## ")[0]
    return [line for line in section.splitlines() if line.startswith("| `")]


def test_every_metric_has_its_row_with_code_and_test() -> None:
    held = rows("Metrics of a hold")
    assert [re.findall(r"`(\w+)`", row)[0] for row in held] == list(HOLD_METRICS)
    for row in held:
        _, name, definition, _, code, tests, _ = (part.strip() for part in row.split("|"))
        assert name
        assert len(definition) > 20
        for path in re.findall(r"`([\w/]+\.py)`", code):
            assert (ROOT / "frictool/metrics" / path).exists(), path
        found = re.findall(r"`([\w/]+\.py)`", tests)
        assert found
        assert all((ROOT / path).exists() or (ROOT / "tests/metrics" / path).exists() for path in found)
    named = re.findall(r"`(\w+)`", " ".join(row.split("|")[1] for row in rows("Metrics of a stream")))
    assert sorted(named) == sorted(STREAM_METRICS)


def test_every_requirement_has_its_row() -> None:
    asked = [name for name in Spec.__struct_fields__ if name not in ("format", "name", "axis", "drive")]
    named = re.findall(r"`(\w+)`", " ".join(row.split("|")[1] for row in rows("Requirements")))
    assert sorted(named) == sorted(asked)


def test_every_file_of_the_metrics_is_in_the_table_or_in_the_vocabulary() -> None:
    files = {path.name for path in (ROOT / "frictool/metrics").glob("*.py")} - {"__init__.py"}
    assert {name for name in files if name not in TEXT} == set()
