"""The documentation defines every metric and every requirement, and names the files that hold
them."""

from __future__ import annotations

import ast
import re
from dataclasses import replace
from pathlib import Path

import pytest

from frictool.documents.metric_table import METRICS, REQUIREMENTS, Metric
from frictool.documents.quantity import positive, si_unit
from frictool.documents.spec import Spec
from frictool.report.metric_samples import function_of
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


def constants(path: Path) -> list[str]:
    """The texts of several words in a module, without docstrings and messages of errors."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    skipped = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.Raise | ast.Expr)
        for inner in ast.walk(node)
    }
    return [
        node.value.strip()
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and id(node) not in skipped
        if isinstance(node.value, str) and " " in node.value.strip()
    ]


def test_every_reason_on_the_page_is_one_that_is_printed_and_no_reason_is_left_out() -> None:
    folders = (ROOT / "frictool/report", ROOT / "frictool/metrics")
    printed = [
        text for folder in folders for path in folder.glob("*.py") for text in constants(path)
    ]
    section = TEXT.split("## Undecided\n")[1]
    cells = [line.split("|")[2] for line in section.splitlines() if line.startswith("| ")]
    reasons = [
        quoted for cell in cells for quoted in re.findall(r"`([^`]*)`", cell) if " " in quoted
    ]
    pieces = [piece.strip() for reason in reasons for piece in reason.split("...") if piece.strip()]
    assert len(pieces) > 15
    assert [piece for piece in pieces if not any(piece in text for text in printed)] == []
    sources = [
        *(ROOT / "frictool/metrics").glob("*.py"),
        ROOT / "frictool/report/metric_samples.py",
        ROOT / "frictool/report/evidence.py",
    ]
    needed = [text for path in sources for text in constants(path)]
    assert "there is no limit cycle" in needed
    assert [text for text in needed if not any(text in reason for reason in reasons)] == []


def test_every_metric_has_a_function_with_known_needs_and_parameters() -> None:
    computed = [metric for metric in METRICS if metric.compute]
    assert len(computed) > 20
    for metric in computed:
        function_of(metric)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"dimension": "tme"}, "metric rise_time: dimension 'tme'; allowed: .*time"),
        ({"needs": ("stp",)}, "metric rise_time: need 'stp'; allowed: .*step"),
        ({"compute": "rise_time.rise"}, "metric rise_time: compute 'rise_time.rise': .*rise"),
        ({"compute": "rise.rise_time"}, "metric rise_time: compute 'rise.rise_time': .*rise"),
        (
            {"compute": "load_position_bounds.load_bounds"},
            "metric rise_time: parameter 'backlash'; allowed: .*position",
        ),
    ],
)
def test_a_misspelt_field_of_a_metric_is_named_with_the_metric(
    change: dict[str, object], message: str
) -> None:
    (metric,) = (metric for metric in METRICS if metric.name == "rise_time")
    with pytest.raises(ValueError, match=message):
        function_of(replace(metric, **change))


def test_a_misspelt_dimension_of_a_limit_is_named() -> None:
    with pytest.raises(ValueError, match="dimension 'tme'; allowed: drive"):
        positive("tme")


@pytest.mark.parametrize("dimension", ["inertia", "viscous"])
def test_a_metric_takes_each_dimension_of_a_quantity(dimension: str) -> None:
    units = [Metric("one", "one", dimension, "").unit(spec) for spec in SPECS]
    assert units == [si_unit(dimension, spec.axis) for spec in SPECS]
