"""The documentation defines every metric and every requirement, and names the files that hold
them."""

from __future__ import annotations

import re

import pytest

from frictool.documents.metric_table import METRICS, REQUIREMENTS
from frictool.documents.spec import Spec
from studies.rigs.step_logs import ROOT

TEXT = (ROOT / "docs/metrics.md").read_text(encoding="utf-8")
REPORT = (ROOT / "docs/theory/report.md").read_text(encoding="utf-8")


SECTIONS = {
    "hold": "Metrics of a hold",
    "stream": "Metrics of a stream",
    "loop": "Metric of a loop",
}
SPECS = (
    Spec(format="spec/1", name="one", axis="rotary", drive="current"),
    Spec(format="spec/1", name="other", axis="linear", drive="voltage"),
)


def rows(heading: str, text: str = TEXT) -> list[str]:
    section = text.split(f"## {heading}\n")[1].split("\n## ")[0]
    return [line for line in section.splitlines() if line.startswith("| `")]


@pytest.mark.parametrize("scope", SECTIONS)
def test_every_metric_has_its_row_with_unit_code_and_test(scope: str) -> None:
    metrics = [metric for metric in METRICS if metric.scope == scope]
    listed = [[cell.strip() for cell in row.split("|")[1:-1]] for row in rows(SECTIONS[scope])]
    units = [dict.fromkeys(metric.unit(spec) for spec in SPECS) for metric in metrics]
    assert [row[:3] for row in listed] == [
        [f"`{metric.name}`", metric.definition, ", ".join(unit).replace("^2", "²")]
        for metric, unit in zip(metrics, units, strict=True)
    ]
    for _, _, _, code, tests in listed:
        for path in re.findall(r"`([\w/]+\.py)`", code):
            assert any(
                (ROOT / folder / path).exists() for folder in ("frictool", "frictool/metrics")
            )
        found = re.findall(r"`([\w/]+\.py)`", tests)
        assert found
        assert all(
            (ROOT / path).exists() or (ROOT / "tests/metrics" / path).exists() for path in found
        )


def test_every_requirement_has_its_row() -> None:
    named = re.findall(
        r"`(\w+)`", " ".join(row.split("|")[1] for row in rows("Requirements", REPORT))
    )
    assert sorted(named) == sorted(REQUIREMENTS)


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
