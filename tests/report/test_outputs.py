"""The verdict as text, JSON, JUnit and Markdown."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from frictool.documents.certificate import CertifiedWeights, Filter
from frictool.documents.metric_table import HOLD_METRICS, STREAM_METRICS, Energy, requirement_title
from frictool.documents.quantity import Quantity
from frictool.logs.log import Log
from frictool.report.json_view import as_json
from frictool.report.junit_view import junit
from frictool.report.markdown_view import markdown
from frictool.report.requirement import ValueLocation, Verdict
from frictool.report.text_view import lines
from frictool.report.verdict import judge
from frictool.verify.vertex_transfers import sensitivities
from studies.rigs.step_logs import clutch_log, clutch_spec, controller, smooth_log, stream

HOSTILE = "/axis/<script>alert(1)</script>|`x`\x1b[31m"


@pytest.fixture(name="mixed")
def _mixed() -> Verdict:
    """One requirement broken, one undecided, the others met."""
    return judge(clutch_spec(), [Log((stream(damping=0.5),), {}, "run.mcap")])


def test_text_has_one_line_for_each_requirement_and_the_verdict_last(mixed: Verdict) -> None:
    shown = lines(mixed)
    assert [line[:12].strip() for line in shown[:-1]] == [r.outcome for r in mixed.requirements]
    assert {line[:12].strip() for line in shown[:-1]} == {"MET", "NOT MET", "UNDECIDED"}
    assert shown[-1] == "FAIL: 5 of 7 requirements met, 1 broken, 1 undecided, on 1 recorded stream"
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


def test_json_has_every_metric_of_every_hold_and_stream_or_says_why_not() -> None:
    """For logs with and without a load, for a smooth one, and for one with next to nothing."""
    bare = Log((stream(without=("load_position", "current", "command")),), {}, "bare.mcap")
    for log in (
        clutch_log(1),
        bare,
        smooth_log(),
        Log((stream(references=((55.0, 0.1), (5.0, 0.1))),), {}, "short.mcap"),
    ):
        for controlled in (None, controller()):
            view = json.loads(
                json.dumps(as_json(judge(clutch_spec(), [log], controlled)), allow_nan=False)
            )
            for found in view["streams"]:
                assert all(
                    found[name] is not None or found["missing"][name] for name in STREAM_METRICS
                )
                for hold in found["holds"]:
                    for name in HOLD_METRICS:
                        told = (
                            hold[name] is not None,
                            name in hold["bounds"],
                            bool(hold["missing"].get(name)),
                        )
                        assert sum(told) == 1, name
    assert set(view["units"]) == {*HOLD_METRICS, *STREAM_METRICS}


def test_json_tells_a_response_that_never_comes_as_null_with_the_reason() -> None:
    stalled = stream()
    stalled.signals["position"][:] = 31.0
    stalled.signals["position"][:40] = np.linspace(5.0, 31.0, 40)
    hold = as_json(judge(clutch_spec(), [Log((stalled,), {}, "run.mcap")]))["streams"][0]["holds"][
        1
    ]
    assert hold["response_time_95"] is None
    assert "less than half" in hold["missing"]["response_time_95"]
    assert hold["static_error"] == pytest.approx(26.0)


def test_json_tells_how_far_each_transfer_is_into_its_template() -> None:
    controlled = msgspec.structs.replace(
        controller(), weights=CertifiedWeights(Filter(31.5, 40.0, 0.63), 0.03, 0.5)
    )
    verdict = judge(clutch_spec(), [clutch_log()], controlled)
    view = as_json(verdict, sensitivities(controlled))["sensitivity"]
    assert list(view["transfers"]) == ["error", "drive", "disturbance", "output"]
    assert view["transfers"]["error"]["worst_of_template"] > 0.0
    assert view["transfers"]["error"]["vertex"] in {"v00", "v01", "v02"}
    assert view["transfers"]["output"]["worst_of_template"] is None
    assert as_json(verdict)["sensitivity"] is None
    assert as_json(verdict, "no vertex")["sensitivity"] == {"missing": "no vertex"}


def test_junit_has_one_case_for_each_requirement_that_can_be_asked() -> None:
    quantity = Quantity(value=3.0, unit="rad")
    spec = clutch_spec(
        rise_time_s=0.2,
        load_static_error=quantity,
        limit_cycle=quantity,
        drive_rms=Quantity(value=20.0, unit="A"),
        saturation_time_s=0.1,
        energy=Energy(0.28, 400.0),
    )
    verdict = judge(spec, [clutch_log()], controller())
    cases = [case.get("name") for case in ET.fromstring(junit(verdict)).iter("testcase")]
    assert cases == [
        "response_time_95",
        "rise_time",
        "overshoot",
        "static_error",
        "load_static_error",
        "oscillations",
        "limit_cycle",
        "modulus_margin",
        "drive_peak",
        "drive_rms",
        "saturation_time",
        "rest",
        "energy",
    ]
    titles = [row.split(" | ")[0].strip("| ") for row in markdown(verdict).splitlines()[4:]]
    assert titles == list(map(requirement_title, cases))
    assert titles[:4] == ["response 95 %", "rise 10-90 %", "overshoot", "static error"]
    assert "rest" in titles


def test_columns_of_the_text_never_run_together(mixed: Verdict) -> None:
    """Also with a limit of many digits in a long unit."""
    first, *others = mixed.requirements
    long = replace(first, name="load_static_error_of_all", value=1.234e-5, limit=1.234e-5)
    long = replace(long, unit="rad s^2", where=ValueLocation("run.mcap", "/axis/v06"))
    shown = lines(replace(mixed, requirements=(long, *others)))
    assert re.split(r" {2,}", shown[0])[1:] == [
        "load static error of all",
        "1.234e-05 rad s²",
        "<= 1.234e-05 rad s²",
        "run.mcap /axis/v06",
    ]
    starts = {line.index("= ") for line in shown[: len(mixed.requirements)]}
    assert len(starts) == 1


def test_json_says_pass_only_if_every_requirement_is_met() -> None:
    assert as_json(judge(clutch_spec(), [clutch_log()], controller()))["verdict"] == "pass"
    assert as_json(judge(clutch_spec(), [clutch_log()]))["verdict"] == "undecided"
    assert as_json(judge(clutch_spec(drive_peak=None), [smooth_log()]))["verdict"] == "undecided"


def test_junit_counts_its_cases(mixed: Verdict) -> None:
    suite = ET.fromstring(junit(mixed)).find("testsuite")
    assert suite is not None
    cases = suite.findall("testcase")
    assert [case.get("name") for case in cases] == [r.name for r in mixed.requirements]
    assert suite.get("tests") == str(len(cases)) == "7"
    assert suite.get("failures") == str(len(suite.findall("testcase/failure"))) == "1"
    assert suite.get("errors") == str(len(suite.findall("testcase/error"))) == "1"
    assert suite.get("skipped") == "0"
    failure = suite.find("testcase/failure")
    assert failure is not None
    assert "limit <= 5 %, run.mcap /axis, step" in failure.get("message", "")


def test_junit_of_an_undecided_verdict_is_no_success() -> None:
    suite = ET.fromstring(junit(judge(clutch_spec(drive_peak=None), [smooth_log()]))).find(
        "testsuite"
    )
    assert suite is not None
    assert (
        suite.get("errors")
        == suite.get("tests")
        == str(len(suite.findall("testcase/error")))
        == "6"
    )
    assert suite.get("tests") == str(len(suite.findall("testcase")))


def test_markdown_is_one_table_row_for_each_requirement(mixed: Verdict) -> None:
    rows = markdown(mixed).splitlines()
    assert (
        rows[0]
        == "### clutch: FAIL: 5 of 7 requirements met, 1 broken, 1 undecided, on 1 recorded stream"
    )
    assert len(rows) == 4 + 7
    assert all(row.count(" | ") == 5 for row in rows[4:])


def test_names_from_files_stay_names() -> None:
    spec = msgspec.structs.replace(clutch_spec(), name="a & b <i>")
    verdict = judge(spec, [Log((stream(HOSTILE, damping=0.5),), {}, "run.mcap")])
    assert "\x1b" not in "\n".join(lines(verdict))
    text = markdown(verdict)
    assert "<script>" not in text
    assert "<i>" not in text
    assert all(row.replace("\\|", "").count("|") == 7 for row in text.splitlines()[4:])
    suite = ET.fromstring(junit(verdict)).find("testsuite")
    assert suite is not None
    assert suite.get("name") == "a & b <i>"
