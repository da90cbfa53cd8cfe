"""The verdict as text, JSON, JUnit and Markdown."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET

import msgspec
import pytest

from frictool.logs.log import Log
from frictool.report.junit import junit
from frictool.report.machine import as_json
from frictool.report.markdown import markdown
from frictool.report.requirement import Verdict
from frictool.report.text import lines
from frictool.report.verdict import judge
from tests.report.example import clutch_log, clutch_spec, controller, smooth_log, stream

HOSTILE = "/axis/<script>alert(1)</script>|`x`\x1b[31m"


@pytest.fixture(name="mixed")
def _mixed() -> Verdict:
    """One requirement broken, one undecided, the others met."""
    return judge(clutch_spec(), [Log((stream(damping=0.5),), {}, "run.mcap")])


def test_text_has_one_line_for_each_requirement_and_the_verdict_last(mixed: Verdict) -> None:
    shown = lines(mixed)
    assert [line[:12].strip() for line in shown[:-1]] == [r.outcome for r in mixed.requirements]
    assert {line[:12].strip() for line in shown[:-1]} == {"MET", "NOT MET", "CANNOT TELL"}
    assert shown[-1] == "NOT MET: 5 of 7 requirements met, 1 broken, 1 undecided, on 1 recorded stream"
    assert "\x1b" not in "".join(shown)


def test_colour_only_dresses_the_text(mixed: Verdict) -> None:
    import click

    painted = lines(mixed, colour=True)
    assert "\x1b[31m" in painted[1]
    assert [click.unstyle(line) for line in painted] == lines(mixed)


def test_json_carries_each_requirement_and_each_hold(mixed: Verdict) -> None:
    view = json.loads(json.dumps(as_json(mixed)))
    assert view["verdict"] == "fail"
    assert view["undecided"] == ["modulus_margin"]
    by_name = {r["name"]: r for r in view["requirements"]}
    assert by_name["overshoot"]["met"] is False
    assert by_name["overshoot"]["unit"] == "%"
    assert by_name["modulus_margin"]["met"] is None
    assert {"name", "value", "limit", "unit", "met", "reason", "where"} <= set(by_name["rest"])
    (only,) = view["streams"]
    assert [hold["to"] for hold in only["holds"]] == [55.0, 5.0, 35.0, 15.0]
    assert only["encoder_step"] == pytest.approx(0.1122, abs=1e-4)


def test_json_says_pass_where_nothing_is_broken() -> None:
    assert as_json(judge(clutch_spec(), [clutch_log()], controller()))["verdict"] == "pass"
    assert as_json(judge(clutch_spec(drive_peak=None), [smooth_log()]))["verdict"] == "fail"


def test_junit_counts_its_cases(mixed: Verdict) -> None:
    suite = ET.fromstring(junit(mixed)).find("testsuite")
    assert suite is not None
    cases = suite.findall("testcase")
    assert [case.get("name") for case in cases] == [r.name for r in mixed.requirements]
    assert suite.get("tests") == str(len(cases)) == "7"
    assert suite.get("failures") == str(len(suite.findall("testcase/failure"))) == "1"
    assert suite.get("skipped") == str(len(suite.findall("testcase/skipped"))) == "1"
    failure = suite.find("testcase/failure")
    assert failure is not None
    assert "limit <= 5 %, run.mcap /axis, step" in failure.get("message", "")


def test_junit_of_an_undecided_verdict_is_no_success() -> None:
    suite = ET.fromstring(junit(judge(clutch_spec(drive_peak=None), [smooth_log()]))).find("testsuite")
    assert suite is not None
    assert suite.get("errors") == str(len(suite.findall("testcase/error"))) == "1"
    assert suite.get("tests") == str(len(suite.findall("testcase")))


def test_markdown_is_one_table_row_for_each_requirement(mixed: Verdict) -> None:
    rows = markdown(mixed).splitlines()
    assert rows[0] == "### clutch: NOT MET: 5 of 7 requirements met, 1 broken, 1 undecided, on 1 recorded stream"
    assert len(rows) == 4 + 7
    assert all(row.count(" | ") == 4 for row in rows[4:])


def test_names_from_files_stay_names() -> None:
    spec = msgspec.structs.replace(clutch_spec(), name="a & b <i>")
    verdict = judge(spec, [Log((stream(HOSTILE, damping=0.5),), {}, "run.mcap")])
    assert "\x1b" not in "\n".join(lines(verdict))
    text = markdown(verdict)
    assert "<script>" not in text
    assert "<i>" not in text
    assert all(row.replace("\\|", "").count("|") == 6 for row in text.splitlines()[4:])
    suite = ET.fromstring(junit(verdict)).find("testsuite")
    assert suite is not None
    assert suite.get("name") == "a & b <i>"
