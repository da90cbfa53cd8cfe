"""A value that differs needs a word, and one that agrees has none; what is missing or unknown is
told; the files fit each other."""

from __future__ import annotations

import json
import math
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

from studies.thesis import __main__ as thesis
from studies.thesis.comparison import agrees, compare
from studies.thesis.documents import HERE, KINDS, Documents, Figure, Row, Table, kind_of, read
from studies.thesis.page import called, page
from studies.thesis.results import ComputedValue, Part
from studies.thesis.summary import as_json, summary
from tests.support.html_page import without_own_scripts

FIGURE = Figure("Title", "shows", "1.1")
SVG = '<svg role="img"></svg>'


def documents(words: dict[str, str] | None = None, **rows: Row) -> Documents:
    return Documents(
        {"table_4_2": Table("Title", "4.2", "ours", rows)}, words or {}, {"4.1": FIGURE}
    )


def part(**values: float | str | ComputedValue) -> Part:
    found = Part()
    found.add("table_4_2", {**values})
    found.draw("4.1", "Caption.", SVG)
    return found


@pytest.mark.parametrize(
    ("found", "row", "good"),
    [
        (ComputedValue(1.04), Row(1.0, within=0.05), True),
        (ComputedValue(1.06), Row(1.0, within=0.05), False),
        (ComputedValue(-1.06), Row(-1.0, within=0.05), False),
        (ComputedValue(2.0, 0.9, 3.0), Row(1.0), True),
        (ComputedValue(2.0, 1.1, 3.0), Row(1.0), False),
        (ComputedValue(2.0, 1.1, 3.0), Row(1.0, within=0.2), True),
        (ComputedValue(math.nan), Row(1.0, within=9.0), False),
        (ComputedValue(math.inf), Row(1.0, within=9.0), False),
        (ComputedValue("+"), Row("+"), True),
        (ComputedValue("+"), Row("±"), False),
        (ComputedValue("28"), Row(">8"), True),
        (ComputedValue("8"), Row(">8"), False),
    ],
)
def test_what_agrees(found: ComputedValue, row: Row, good: bool) -> None:
    assert agrees(found, row) is good


def test_a_difference_needs_a_word_and_an_agreement_none() -> None:
    row = Row(1.0, within=0.05)
    assert compare(documents(m=row), part(m=1.0)).problems == ()
    assert "no reason in words.yaml" in compare(documents(m=row), part(m=2.0)).problems[0]
    assert compare(documents({"table_4_2 m": "why"}, m=row), part(m=2.0)).problems == ()
    assert (
        "agrees; remove the reason"
        in compare(documents({"table_4_2 m": "why"}, m=row), part(m=1.0)).problems[0]
    )


def test_a_difference_is_told_where_there_is_one_to_be_seen() -> None:
    told = {
        ours: compare(documents(m=Row(1.0, within=0.1)), part(m=ours)).lines[0].difference
        for ours in (1.0, 1.0004, 0.95, 3.0)
    }
    assert told == {1.0: "", 1.0004: "", 0.95: "-5.0 %", 3.0: "x 3"}


def test_what_is_missing_or_unknown_is_told() -> None:
    row = Row(1.0)
    assert any(
        "values not computed: n" in line
        for line in compare(documents(m=row, n=row), part(m=1.0)).problems
    )
    assert any(
        "not in published.yaml" in line
        for line in compare(documents(m=row), part(m=1.0, n=1.0)).problems
    )
    assert any(
        "no such value" in line
        for line in compare(documents({"table_4_2 q": "why"}, m=row), part(m=1.0)).problems
    )
    empty = part(m=1.0)
    empty.figures.clear()
    assert compare(documents(m=row), empty).problems == ("frictool did not draw figures 4.1",)


def test_the_page_and_the_summary_say_what_differs_and_why() -> None:
    given, ours = (
        documents({"table_4_2 m": "because of <it>"}, m=Row(1.0, name="mass", unit="kg")),
        part(m=2.0),
    )
    found = compare(given, ours)
    text = page(given, ours, found)
    assert "because of &lt;it&gt;" in text
    assert SVG in text
    assert "Table 4.2: " in text
    assert not re.search(r"https?://(?!www\.w3\.org)|<script", without_own_scripts(text))
    assert "table_4_2 m: 2 kg, published 1 kg: because of <it>" in summary(given, ours, found)
    value = json.loads(as_json(given, ours, found))["tables"]["table_4_2"]["values"]["m"]
    assert (value["ours"], value["published"], value["agrees"], value["why"]) == (
        2.0,
        1.0,
        False,
        "because of <it>",
    )


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("table_4_2", "Table 4.2"),
        ("section_5_4_3_1", "Thesis 5.4.3.1"),
        ("annex_c_5_2", "Annex C.5.2"),
    ],
)
def test_a_table_is_called_as_it_is_printed(name: str, said: str) -> None:
    assert called(name) == said


def test_every_word_is_of_a_value_and_every_table_has_its_place() -> None:
    found = read()
    known = {f"{name} {key}" for name, table in found.tables.items() for key in table.rows}
    assert found.words.keys() <= known
    assert all(
        table.title and table.where and table.ours and table.rows for table in found.tables.values()
    )


def test_computed_numbers_are_counted_apart_from_words_and_inputs() -> None:
    given = documents(m=Row(1.0), n=Row(2.0), order=Row("all"))
    given.tables["table_5_1"] = Table("Title", "5.1", "a file", {"k": Row(3.0)}, inputs=True)
    ours = part(m=1.0, n=2.5, order="all")
    ours.add("table_5_1", {"k": 3.0})
    found = compare(given, ours)
    assert found.counts == {"computed": (2, 1), "word": (1, 1), "input": (1, 1)}
    assert "          computed         2       1       1   computed numbers" in summary(
        given, ours, found
    )
    assert json.loads(as_json(given, ours, found))["counts"]["input"] == {"values": 1, "agree": 1}
    assert "2 values are computed numbers; 1 of them agree" in page(given, ours, found)


def test_the_documentation_has_the_counts_of_what_is_compared() -> None:
    kinds = [kind_of(table, row) for table in read().tables.values() for row in table.rows.values()]
    readme, coverage = (
        " ".join((HERE.parents[1] / path).read_text().split())
        for path in ("README.md", "docs/coverage.md")
    )
    assert f"{len(kinds)} values" in readme
    assert f"{len(kinds)} values" in coverage
    for kind in ("computed", "word", "input"):
        assert f"{kinds.count(kind)} {KINDS[kind].partition(' typed')[0]}" in coverage


def test_inputs_are_what_the_part_of_that_name_makes() -> None:
    """Every table that is typed is made by studies/thesis/parts/inputs.py, which computes nothing,
    and none of its tables counts as computed."""
    assert {name for name, table in read().tables.items() if table.inputs} == set(
        thesis.made("inputs")[0].values
    )


def test_a_file_that_is_wrong_is_named(tmp_path: Path) -> None:
    for name in ("published.yaml", "words.yaml", "figures.yaml"):
        (tmp_path / name).write_text((HERE / name).read_text())
    (tmp_path / "words.yaml").write_text("a b: [1]\n")
    with pytest.raises(ValueError, match=r"words\.yaml: "):
        read(tmp_path)


def test_a_part_is_made_into_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The rigs' own numbers, by the command: they are the printed ones, or a word says why not."""
    assert thesis.main([str(tmp_path / "out"), "inputs"]) == 0
    assert "table_5_2" in capsys.readouterr().out
    assert json.loads((tmp_path / "out/tables.json").read_text())["tables"]["table_4_8"]["values"][
        "beta"
    ]["agrees"]
    assert (tmp_path / "out/index.html").read_text().startswith("<!DOCTYPE html>")


def test_wrong_command_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert thesis.main([]) == 2
    assert thesis.main([str(tmp_path), "nothing"]) == 2
    assert "no part is called nothing; there are: laws" in capsys.readouterr().err
    (tmp_path / "file").write_text("")
    assert thesis.main([str(tmp_path / "file")]) == 2
    assert "name a folder" in capsys.readouterr().err


def test_a_part_that_breaks_is_told_and_hides_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = ModuleType("studies.thesis.parts.broken")
    monkeypatch.setattr(broken, "broken", lambda: 1 / 0, raising=False)
    monkeypatch.setitem(sys.modules, "studies.thesis.parts.broken", broken)
    whole, wrong = thesis.collected(["broken"])
    assert whole.values == {}
    assert wrong == ["broken: ZeroDivisionError: division by zero"]
