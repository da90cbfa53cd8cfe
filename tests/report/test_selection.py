"""A campaign of hundreds of plants: all are judged and counted, a page shows some of them."""

from __future__ import annotations

import json
import re

import pytest

from frictool.logs.log import Log, Stream
from frictool.report.json_view import as_json
from frictool.report.page import page
from frictool.report.requirement import Verdict
from frictool.report.stream_selection import MOST_SHOWN, select_streams
from frictool.report.verdict import judge
from studies.rigs.step_logs import clutch_spec, controller, stream
from tests.support.html_page import MADE, Page

SHORT = ((55.0, 0.5), (5.0, 0.5))
PLANTS, SOFT, SOFTEST = 120, (30, 77, 110), 77
SPEC = clutch_spec(rest=None, modulus_margin=None)


def campaign() -> Log:
    """The nominal plant and 119 more; three of them overshoot, one of these the most."""
    stiff = stream(references=SHORT)
    streams = []
    for k in range(PLANTS):
        plant = (
            stiff
            if k not in SOFT
            else stream(references=SHORT, damping=0.45 if k == SOFTEST else 0.55)
        )
        streams.append(
            Stream("/axis" if k == 0 else f"/axis/p{k:03d}", plant.time, plant.signals, plant.units)
        )
    return Log(tuple(streams), {"log": {"kind": "simulated"}}, "run.mcap")


@pytest.fixture(name="verdict", scope="module")
def _verdict() -> Verdict:
    return judge(SPEC, [campaign()])


def test_the_plants_that_meet_everything_are_counted(verdict: Verdict) -> None:
    assert [k for k, meets in enumerate(verdict.meets) if not meets] == list(SOFT)
    assert (
        verdict.headline
        == "FAIL: 4 of 5 requirements met, 1 broken, on 120 plants; 117 of 120 streams meet them "
        "all"
    )
    view = json.loads(json.dumps(as_json(verdict), allow_nan=False))
    assert view["streams_meeting_all"] == 117
    assert [found["meets_all"] for found in view["streams"]].count(False) == 3
    assert len(view["streams"]) == PLANTS


def test_a_plant_that_only_the_controller_s_margin_fails_meets_the_logs_requirements() -> None:
    log = Log((stream(), stream("/axis/v00")), {}, "run.mcap")
    verdict = judge(clutch_spec(), [log], controller((0.4,)))
    assert verdict.state == "fail"
    assert verdict.meets == (True, True)


def test_a_stream_that_decides_nothing_does_not_count_as_meeting() -> None:
    bare = stream(without=("position", "current", "command"))
    assert judge(clutch_spec(), [Log((stream(), bare), {}, "run.mcap")]).meets == (True, False)


def test_the_nominal_the_worst_and_the_failing_plants_are_shown(verdict: Verdict) -> None:
    topics = [evidence.stream.topic for evidence, _ in select_streams(verdict)]
    assert len(topics) == MOST_SHOWN
    assert topics == sorted(topics)
    assert {"/axis", *(f"/axis/p{k:03d}" for k in SOFT)} <= set(topics)
    assert max(int(topic[-3:]) for topic in topics[1:]) > 100  # spread over all of them


def test_few_streams_are_all_shown() -> None:
    verdict = judge(
        SPEC,
        [Log((stream(references=SHORT), stream("/axis/v00", references=SHORT)), {}, "run.mcap")],
    )
    shown = [evidence.stream.topic for evidence, *_ in select_streams(verdict)]
    assert shown == [evidence.stream.topic for evidence, *_ in verdict.evidence]


def test_more_failing_plants_than_are_shown_leave_the_nominal_one_in() -> None:
    soft = stream(references=SHORT, damping=0.5)
    many = tuple(Stream(f"/axis/p{k:03d}", soft.time, soft.signals, soft.units) for k in range(60))
    picked = select_streams(judge(SPEC, [Log((*many, stream(references=SHORT)), {}, "run.mcap")]))
    assert len(picked) == MOST_SHOWN
    assert picked[-1][0].stream.topic == "/axis"


def test_the_page_says_how_many_it_shows(verdict: Verdict) -> None:
    html = page(verdict, MADE)
    text = " ".join(Page(html).text.split())
    assert f"{MOST_SHOWN - 1} of its {PLANTS - 1} variants" in text
    assert f"Drawn and listed: {MOST_SHOWN} of {PLANTS} streams" in text
    assert len(re.findall(r"<td>run\.mcap /axis", html)) == MOST_SHOWN * (
        2 + 2 + 1
    )  # two holds in two tables, and one table of streams
    assert len(html) < 4_000_000
