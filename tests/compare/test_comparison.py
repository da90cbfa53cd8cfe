"""From trajectories to verdicts, text, JSON and the page, with laws whose behaviour is known."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from frictool.compare.comparison import Comparison, compare
from frictool.compare.comparison_setting import table_3_1
from frictool.compare.json_view import as_json
from frictool.compare.page import page
from frictool.compare.text_view import lines
from frictool.documents.provenance import provenance_of_command
from frictool.errors import NoSolutionError
from tests.compare.scripted_simulator import Failing, Told
from tests.support.html_page import without_own_scripts


@pytest.fixture(scope="module")
def found() -> Comparison:
    return compare(table_3_1(), Told(), Told().names())


def test_each_law_is_judged_against_the_reference(found: Comparison) -> None:
    tests = ("stick_slip", "limit_cycle", "presliding", "drift")
    assert {
        law: tuple(tested.verdicts[test] for test in tests) for law, tested in found.laws.items()
    } == {
        "stribeck": ("+", "+", "-", "+"),
        "lugre": ("+", "+", "±", "-"),
        "hybrid_a": ("-", "+", "-", "+"),
    }
    assert found.reference.period_s == pytest.approx(6.5)
    assert found.laws["lugre"].drift.z_max_units == pytest.approx(86.0)


def test_the_reference_is_there_when_it_is_not_asked_for(found: Comparison) -> None:
    calls: list[tuple[int, int]] = []
    alone = compare(table_3_1(), Told(), ("hybrid_a",), lambda *call: calls.append(call))
    assert list(alone.laws) == ["hybrid_a"]
    assert alone.laws["hybrid_a"].verdicts == found.laws["hybrid_a"].verdicts
    assert calls == [(0, 1), (1, 1)]


def test_processes_change_no_figure(found: Comparison) -> None:
    shared = compare(table_3_1(), Told(), Told().names(), workers=2)
    assert as_json(shared) == as_json(found)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_law_that_cannot_be_simulated_ends_the_comparison(workers: int) -> None:
    with pytest.raises(NoSolutionError, match="lugre: at 1 s it fails"):
        compare(table_3_1(), Failing(), Failing().names(), workers=workers)


def test_measured_cells_of_table_2_1_replace_what_is_told(found: Comparison) -> None:
    """The reference does not drift, where the table prints a minus for its regularised form."""
    told = {(d.table, d.law, d.row, d.printed, d.computed) for d in found.differences}
    assert ("2.1", "stribeck", "non_drift", "-", "+") in told
    assert ("2.1", "stribeck", "parameters", "6", "7") in told
    assert ("3.2", "hybrid_a", "stick_slip", "+", "-") in told
    assert not any(law == "lugre" for _, law, *_ in told)


def test_json_has_the_keys_that_programs_look_for(found: Comparison) -> None:
    view = json.loads(json.dumps(as_json(found), allow_nan=False))
    lugre = view["laws"]["lugre"]
    assert lugre["stick_slip"]["sticks"] == 9
    assert lugre["stick_slip"]["period_s"] == pytest.approx(6.5 * 1.01)
    assert lugre["limit_cycle"]["amplitude_m"] == pytest.approx(0.067, rel=1e-3)
    assert lugre["limit_cycle"]["period_s"] == pytest.approx(24.24, rel=1e-4)
    assert lugre["presliding"]["closure"] == pytest.approx(0.2 / 1.5)
    assert lugre["drift"]["z_max_units"] == pytest.approx(86.0)
    assert lugre["verdicts"] == {
        "stick_slip": "+",
        "limit_cycle": "+",
        "presliding": "±",
        "drift": "-",
    }
    assert view["laws"]["stribeck"]["presliding"] == {
        "compliance": False,
        "closure": None,
        "area": None,
    }


def test_text_says_what_json_says(found: Comparison) -> None:
    text = lines(found, explain=True)
    row = next(line.split() for line in text if line.startswith("lugre"))
    assert row[:3] == ["lugre", "9", "6.565"]
    assert row[-1] == "86"
    assert any(
        line.startswith(
            "table 3.2, hybrid_a, stick-slip: computed -, printed +: caused by these parameters"
        )
        for line in text
    )


@pytest.fixture(scope="module")
def html(found: Comparison) -> str:
    """The page of a setting whose name has a sign of HTML."""
    named = replace(found, setting=replace(found.setting, name="<b>x"))
    return page(named, provenance_of_command("frictool compare", []))


def test_the_page_holds_the_figures_of_the_thesis_and_nothing_from_elsewhere(html: str) -> None:
    html = without_own_scripts(html)
    for number in ("3.11", "3.13", "3.15", "3.17", "3.18", "3.22"):
        assert f"Thesis {number}." in html
    assert "Thesis 3.21." not in html  # hybrid C was not compared
    assert (
        html.count("<svg") == html.count("</svg>") == 6 + 3 + 1 + 1
    )  # and every test of a law that the thesis does not show
    assert "<script" not in html
    assert "http" not in html.replace("http://www.w3.org/", "").replace("http-equiv", "")


def test_a_name_from_a_file_is_escaped_in_the_page(html: str) -> None:
    assert "<b>x" not in html
    assert "&lt;b&gt;x" in html
