"""Alarms: what an interval says of a limit, in which direction or zone, and over what a unit was at
commissioning."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from frictool.errors import InputFileError
from frictool.observe.commissioning import commissioning_of_estimate, read_commissioning
from frictool.observe.wear_estimate import EstimateRange, WearEstimate, WearZone
from frictool.observe.wear_limit import judge

LIMIT = 1.25


def estimate(
    value: float, low: float, high: float, moves: int = 8, **fields: object
) -> WearEstimate:
    return WearEstimate(1.0, moves, EstimateRange(value, low, high), **fields)


@pytest.mark.parametrize(
    ("interval", "exceeded", "certain"),
    [
        ((1.3, 1.28, 1.32), True, True),
        ((1.0, 0.98, 1.02), False, True),
        ((1.26, 1.2, 1.32), True, False),
        ((1.24, 1.2, 1.28), False, False),
        ((1.3, 0.9, 1.7), None, False),  # a healthy unit's as well as a worn one's
        ((1.1, 1.0, 1.25), False, True),
    ],
)
def test_an_interval_against_a_limit(
    interval: tuple[float, float, float], exceeded: bool | None, certain: bool
) -> None:
    verdict = judge(estimate(*interval), LIMIT)
    assert (verdict.exceeded, verdict.certain) == (exceeded, certain)
    assert f"{interval[0]:.4g}" in verdict.reason


def test_no_move_tells_nothing_whatever_was_known_before() -> None:
    found = judge(WearEstimate(0.0, 0, EstimateRange(1.0, 0.99, 1.01)), 1.25)
    assert found.exceeded is None
    assert "no move" in found.reason


def test_a_log_that_may_be_of_another_rig_is_not_let_pass_and_an_alarm_stays_one() -> None:
    doubt = ("the inertia is 0.4 of the model's",)
    passed, alarmed = (
        judge(estimate(value, value - 0.05, value + 0.05), LIMIT, doubts=doubt)
        for value in (1.0, 1.5)
    )
    assert (passed.exceeded, passed.reason) == (None, doubt[0])
    assert alarmed.exceeded is True


def test_one_move_tells_only_what_is_certain() -> None:
    assert judge(estimate(1.26, 1.2, 1.3, moves=1), LIMIT).exceeded is None
    assert judge(estimate(1.4, 1.3, 1.5, moves=1), LIMIT).exceeded is True


@given(st.floats(0.8, 1.8), st.floats(0.0, 0.3), st.floats(0.0, 0.3), st.floats(1.05, 1.6))
def test_what_is_certain_does_not_depend_on_the_value(
    value: float, below: float, above: float, limit: float
) -> None:
    verdict = judge(estimate(value, value - below, value + above), limit)
    assume(verdict.certain)
    assert verdict.exceeded == (value - below > limit)


def test_the_ratio_is_judged_where_there_is_one_and_is_free_of_a_scale() -> None:
    # a constant that is 4.5 % too low makes all wear 4.5 % too large: 1.22 reads 1.275, and does
    # not exceed over its commissioning
    scale = 1.045
    then = commissioning_of_estimate(estimate(scale, 0.99 * scale, 1.01 * scale), "first.mcap")
    now = estimate(1.22 * scale, 0.99 * 1.22 * scale, 1.01 * 1.22 * scale)
    ratio = then.ratio(now)
    assert judge(now, LIMIT).exceeded is True
    assert judge(now, LIMIT, ratio).exceeded is False
    assert ratio.value == pytest.approx(1.22)
    assert ratio.low == pytest.approx(1.22 * (1.0 - 0.01 * 2**0.5), rel=1e-3)


def test_a_worn_zone_exceeds_though_the_mean_does_not() -> None:
    zones = (
        WearZone(0.0, 30.0, EstimateRange(1.0, 0.97, 1.03)),
        WearZone(30.0, 60.0, EstimateRange(1.35, 1.3, 1.4)),
    )
    worn = estimate(1.18, 1.16, 1.2, kind="zones", zones=zones)
    verdict = judge(worn, LIMIT)
    assert verdict.exceeded is True
    assert "30 to 60" in verdict.reason
    # over a commissioning at which all was 1.1, the zone is 1.23
    ratio = commissioning_of_estimate(estimate(1.1, 1.09, 1.11), "first.mcap").ratio(worn)
    assert judge(worn, LIMIT, ratio).exceeded is False
    assert judge(worn, 1.15, ratio).exceeded is True


def test_a_worn_direction_exceeds_for_certain_only() -> None:
    def sided(low: float) -> WearEstimate:
        return estimate(
            1.15,
            1.14,
            1.16,
            kind="directional",
            forward=EstimateRange(1.3, low, 1.4),
            backward=EstimateRange(1.0, 0.98, 1.02),
        )

    assert judge(sided(1.27), LIMIT).exceeded is True
    assert "forward" in judge(sided(1.27), LIMIT).reason
    assert judge(sided(1.2), LIMIT).exceeded is False


def test_a_commissioning_that_tells_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match="0 moves"):
        commissioning_of_estimate(estimate(1.0, 0.2, 1.8, moves=0), "first.mcap")
    path = tmp_path / "run.json"
    path.write_text(json.dumps({"wear": {"value": 1.0, "low": 0.98, "high": 1.02}}))
    assert read_commissioning(path).wear == EstimateRange(1.0, 0.98, 1.02)
    path.write_text(json.dumps({"wear": {"value": 1.0, "low": 1.0, "high": 1.0}}))
    assert read_commissioning(path).wear == EstimateRange(1.0, 1.0, 1.0)
    refused = (
        "{}",
        "[1]",
        *(
            json.dumps({"wear": {"value": 1.0, "low": low, "high": 3.0}})
            for low in (2.0, 0.0, -1.0)
        ),
    )
    for wrong in refused:
        path.write_text(wrong)
        with pytest.raises(InputFileError):
            read_commissioning(path)
