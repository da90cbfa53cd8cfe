"""The answer, and the sentences that say it: at the terminal and for programs."""

from __future__ import annotations

import dataclasses
import json
import re

import numpy as np
import pytest

from frictool.campaign.statistics.clopper_pearson import lower
from frictool.campaign.statistics.findings import find
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED
from frictool.campaign.views.json_view import as_json
from frictool.campaign.views.messages import headline, percent
from frictool.campaign.views.text_view import lines
from tests.campaign.example_findings import CORNERS, HOSTILE, findings, stopped, trials


def test_every_trial_has_to_pass_unless_a_rate_is_asked_for() -> None:
    some = findings(trials())
    assert not some.passed
    assert some.outcome == "FAIL"
    assert findings(trials(slow=9.0)).passed is False  # the slowest never settle
    fine = findings(_told(trials(slow=np.inf)))
    assert fine.passed
    assert fine.outcome == "PASS"


def test_a_reason_to_doubt_the_trials_leaves_the_verdict_undecided() -> None:
    made, doubt = _told(trials(slow=np.inf)), "the model is valid above 4 rad only"
    found = find(made, "random", doubt=doubt)
    assert (found.outcome, found.passed) == ("UNDECIDED", False)
    assert headline(found).endswith(f"; {doubt}")
    assert doubt in as_json(found)["warnings"]
    assert find(_told(trials()), "random", doubt=doubt).outcome == "FAIL"


def _told(made):
    """Without the requirement that no trial tells."""
    keep = [0, 1, 3]
    return dataclasses.replace(
        made,
        metrics=tuple(made.metrics[j] for j in keep),
        metric_values=made.metric_values[:, keep],
        met=made.met[:, keep],
    )


@pytest.mark.parametrize("share", [0.5, 0.8, 0.9])
def test_a_rate_is_reached_by_its_lower_bound_and_not_by_the_rate(share: float) -> None:
    made = trials()
    passed = np.full(400, BROKEN, dtype=np.int8)
    passed[: int(400 * share)] = MET
    found = find(dataclasses.replace(made, passed=passed), "random", at_least=share)
    assert found.rate.share == share
    assert not found.passed
    assert found.outcome == "NOT SHOWN"
    bound = lower(int(400 * share), 400)
    assert find(dataclasses.replace(made, passed=passed), "random", at_least=bound).reached
    assert (
        find(dataclasses.replace(made, passed=passed), "random", at_least=0.999).outcome == "FAIL"
    )


def test_the_draws_that_would_show_a_rate_are_told() -> None:
    made = _told(trials(slow=np.inf))
    found = find(made, "random", at_least=0.999)
    assert found.outcome == "NOT SHOWN"
    assert found.draws_needed == 2995
    assert "2995 draws suffice" in headline(found)
    assert find(made, "random", at_least=0.99).passed
    assert "no number of draws can show this" in headline(find(made, "random", at_least=1.0))


def test_what_cannot_be_told_is_no_pass() -> None:
    made = _told(trials())
    none = dataclasses.replace(made, passed=np.full(400, UNDECIDED, dtype=np.int8))
    assert find(none, "random").outcome == "UNDECIDED"
    half = np.where(np.arange(400) < 200, UNDECIDED, MET).astype(np.int8)
    found = find(dataclasses.replace(made, passed=half), "random")
    assert not found.passed
    assert found.outcome == "UNDECIDED"
    assert "200 undecided" in headline(found)
    assert found.rate.low < 0.5 < found.rate.high == 1.0


def test_a_requirement_that_no_trial_tells_is_said_in_the_first_line() -> None:
    found = findings(trials(slow=np.inf))
    assert found.undecided_requirements == ("limit_cycle",)
    assert headline(found).startswith(
        "UNDECIDED: all 400 draws pass; at most 0.75 % fail (95 % confidence)"
    )
    assert headline(found).endswith("undecided in every trial: limit cycle")


def test_vertices_are_counted_and_have_no_rate() -> None:
    found = findings(trials(units=CORNERS), "vertices")
    assert headline(found).startswith(
        "FAIL: 4 of 8 vertices pass, 4 fail; undecided in every trial"
    )
    assert as_json(found)["pass_rate"]["low"] is None
    asked = findings(trials(units=CORNERS), "vertices", 0.5)
    assert asked.reached
    assert "50.0 % of the vertices pass" in headline(asked)
    part = findings(trials(units=CORNERS[[0, 1, 6]]), "vertices")
    assert "of all vertices" in headline(part)


@pytest.mark.parametrize(
    ("count", "at_least", "confidence", "message"),
    [
        (0, None, 0.95, "no trial"),
        (9, 0.0, 0.95, "at_least: found 0"),
        (9, 1.01, 0.95, "1.01"),
        (9, None, 1.0, "confidence"),
        (9, 0.9, float("nan"), "nan"),
    ],
)
def test_what_makes_no_sense_is_refused(
    count: int, at_least: float | None, confidence: float, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        find(trials(count), "random", at_least=at_least, confidence=confidence)


def test_the_text_says_what_fails_where_and_why() -> None:
    told = lines(findings(stopped(trials(), (5, 9))))
    text = "\n".join(told)
    assert re.split(r" {2,}", told[0]) == [
        "requirement",
        "met",
        "broken",
        "undecided",
        "median",
        "5 to 95 %",
        "95 % of plants (95 % conf.)",
        "worst",
        "limit",
    ]
    assert told[-1].startswith("FAIL: ")
    assert "(2 could not be simulated)" in told[-1]
    assert "  2 x the position is beyond 1e3 rad (first: draw 5)" in told
    row = next(line for line in told if line.strip().startswith("Coulomb friction  high"))
    assert "chance below 1e-4" in row
    assert "never" in next(line for line in told if line.startswith("response 95 %"))
    assert "modulus margin  inertia 99 ± 2 % (falls)" in text
    assert "rest            the value is the same in every trial" in text
    assert "limit cycle     no trial has a value" in text
    assert (
        "response 95 % 0.47 s where <= 0.4 s is required: "
        "Coulomb friction 0.14 N m, lost counts -2" in text
    )
    assert (
        "    frictool simulate a/model.yaml --controller a/controller.yaml --scenario "
        "w/worst_response_time_95.yaml -o w/worst.mcap" in told
    )


def test_a_name_from_a_file_reaches_the_terminal_without_its_control_characters() -> None:
    text = lines(findings(trials(label=HOSTILE)))
    assert all(line.isprintable() for line in text)
    assert lines(findings(trials()), colour=True)[-1].startswith("\x1b[31m")


def test_the_json_has_every_figure_and_none_that_json_has_not() -> None:
    found = findings(stopped(trials(), (5, 9)))
    told = json.loads(json.dumps(as_json(found), allow_nan=False))
    assert told["verdict"] == "fail"
    assert told["passed"] + told["failed"] + told["undecided"] == told["trials"] == 400
    assert told["not_simulated"] == [
        {"draw": draw, "reason": "the position is beyond 1e3 rad"} for draw in (5, 9)
    ]
    response = told["metrics"][0]
    assert response["worst"]["value"] is None  # beyond any
    assert response["beyond_any_value"] > 0
    assert (
        sum(response["histogram"]["counts"])
        + response["histogram"]["outside"]
        + response["beyond_any_value"]
        + response["without_value"]
        == 400
    )
    assert told["failures"][0]["question"] == "any"
    assert told["failures"][0]["named"][0] == "coulomb"
    assert told["influences"][1]["factors"][0]["factor"] == "inertia"
    assert told["worst"][0]["values"] == {"coulomb": 0.14, "spread.lost": -2.0}


def test_the_same_trials_give_the_same_findings() -> None:
    assert json.dumps(as_json(findings(trials()))) == json.dumps(as_json(findings(trials())))


@pytest.mark.parametrize(
    ("share", "toward", "text"),
    [
        (1.0, "nearest", "100 %"),
        (0.0, "nearest", "0 %"),
        (0.8924, "nearest", "89.2 %"),
        (0.99702, "down", "99.70 %"),
        (0.002985, "up", "0.30 %"),
        (0.0000301, "up", "0.0031 %"),
        (0.9999999, "nearest", "99.999990 %"),
    ],
)
def test_shares_are_written_so_that_none_that_is_not_all_reads_as_all(
    share: float, toward: str, text: str
) -> None:
    assert percent(share, toward) == text
