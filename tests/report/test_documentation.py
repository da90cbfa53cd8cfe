"""The documentation defines every metric and every requirement, and names the files that hold
them."""

from __future__ import annotations

import re

from frictool.documents.spec import Spec
from frictool.report.metric_table import HOLD_METRICS, STREAM_METRICS
from studies.rigs.step_logs import ROOT

TEXT = (ROOT / "docs/metrics.md").read_text(encoding="utf-8")
REPORT = (ROOT / "docs/theory/report.md").read_text(encoding="utf-8")


def rows(heading: str, text: str = TEXT) -> list[str]:
    section = text.split(f"## {heading}\n")[1].split("\n## ")[0]
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
        assert all(
            (ROOT / path).exists() or (ROOT / "tests/metrics" / path).exists() for path in found
        )
    named = re.findall(
        r"`(\w+)`", " ".join(row.split("|")[1] for row in rows("Metrics of a stream"))
    )
    assert sorted(named) == sorted(STREAM_METRICS)


def test_every_requirement_has_its_row() -> None:
    asked = [
        name
        for name in Spec.__struct_fields__
        if name not in ("format", "name", "axis", "drive", "examples")
    ]
    named = re.findall(
        r"`(\w+)`", " ".join(row.split("|")[1] for row in rows("Requirements", REPORT))
    )
    assert sorted(named) == sorted(asked)


def test_every_file_of_the_metrics_is_in_the_table_or_in_the_vocabulary() -> None:
    files = {path.name for path in (ROOT / "frictool/metrics").glob("*.py")} - {"__init__.py"}
    assert {name for name in files if name not in TEXT} == set()


def test_every_reason_is_one_that_is_printed() -> None:
    folders = (ROOT / "frictool/report", ROOT / "frictool/metrics")
    source = "\n".join(
        path.read_text(encoding="utf-8") for folder in folders for path in folder.glob("*.py")
    )
    section = TEXT.split("## Undecided\n")[1]
    cells = [line.split("|")[2] for line in section.splitlines() if line.startswith("| ")]
    reasons = [
        quoted for cell in cells for quoted in re.findall(r"`([^`]*)`", cell) if " " in quoted
    ]
    pieces = [piece.strip() for reason in reasons for piece in reason.split("...") if piece.strip()]
    assert len(pieces) > 15
    assert [piece for piece in pieces if piece not in source] == []
