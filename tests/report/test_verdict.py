"""The verdict: worst value, where it was, what cannot be told."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.metric_table import Energy, Rest, Settling
from frictool.documents.quantity import Quantity
from frictool.documents.spec import Spec
from frictool.errors import LogError
from frictool.logs.log import Log, Stream
from frictool.report.json_view import as_json
from frictool.report.requirement import Requirement, Verdict
from frictool.report.text_view import lines
from frictool.report.verdict import JUDGES, judge
from studies.rigs.step_logs import (
    ENCODER_STEP,
    PERIOD,
    REFERENCES,
    clutch_log,
    clutch_spec,
    controller,
    smooth_log,
    stream,
)
from studies.rigs.step_responses import overshoot_of


def named(verdict: Verdict, name: str) -> Requirement:
    return next(requirement for requirement in verdict.requirements if requirement.name == name)


def one(**options: object) -> Log:
    return Log((stream(**options),), {}, "run.mcap")


def test_every_key_of_the_specification_has_its_judge_in_order() -> None:
    assert ["format", "name", "axis", "drive", *JUDGES, "examples"] == list(Spec.__struct_fields__)
    full = clutch_spec(
        energy=Energy(0.28, 400.0),
        rise_time_s=0.2,
        load_static_error=Quantity(value=2.0, unit="rad"),
        limit_cycle=Quantity(value=0.0, unit="rad"),
        drive_rms=Quantity(value=20.0, unit="A"),
        saturation_time_s=0.1,
        tracking_error_peak=Quantity(value=1.0, unit="rad"),
        tracking_error_rms=Quantity(value=1.0, unit="rad"),
        settling_after_profile=Settling(
            Quantity(value=1.0, unit="rad"), Quantity(value=1.0, unit="s")
        ),
    )
    verdict = judge(full, [clutch_log()], controller())
    assert [r.key for r in verdict.requirements] == list(JUDGES)
    assert verdict.undecided == (
        "tracking_error_peak",
        "tracking_error_rms",
        "settling_after_profile",
    )  # its reference moves by steps only
    assert all(r.met for r in verdict.requirements if r.name not in verdict.undecided)
    assert verdict.headline == (
        "UNDECIDED: 13 of 16 requirements met, 3 undecided, on 1 recorded stream"
    )


def test_the_response_time_stands_beside_what_the_drive_alone_needs() -> None:
    """At the controller's vertices, for the longest step of the log; nothing without them."""
    log = clutch_log()
    judged = named(judge(clutch_spec(), [log], controller()), "response_time_95")
    least = judged.details["drive_worst_s"]
    assert judged.value is not None
    assert 0.0 < judged.details["drive_best_s"] <= least < judged.value
    length = judged.details["drive_step"]
    assert length == max(
        abs(one.hold.target - one.hold.origin)
        for _, holds in judge(clutch_spec(), [log]).evidence
        for one in holds
        if one.hold.origin is not None
    )
    assert judged.reason.endswith(
        f"at the drive's limit, a step of {length:.4g} rad takes at least {1e3 * least:.4g} "
        "ms on the slowest plant"
    )
    assert named(judge(clutch_spec(), [log]), "response_time_95").details == {}
    assert named(judge(clutch_spec(), [log], controller(())), "response_time_95").details == {}


def simulated(*topics: str) -> Log:
    return Log(tuple(stream(topic) for topic in topics), {"log": {"kind": "simulated"}}, "run.mcap")


@pytest.mark.parametrize(
    ("logs", "told"),
    [
        ([simulated("/axis")], "1 plant (the nominal one)"),
        ([simulated("/axis", *(f"/axis/v{k:02d}" for k in range(16)))], "17 plants"),
        ([simulated("/axis/v00")], "1 plant"),
        ([simulated("/axis"), simulated("/axis")], "1 plant (the nominal one)"),
        (
            [Log((stream(), stream("/axis/ramp")), {"log": {"kind": "measured"}}, "bench.mcap")],
            "2 recorded streams",
        ),
        ([simulated("/axis", "/axis/v00"), clutch_log()], "2 plants and 1 recorded stream"),
    ],
)
def test_the_verdict_says_on_what_it_was_found(logs: list[Log], told: str) -> None:
    verdict = judge(clutch_spec(modulus_margin=None), logs)
    assert verdict.headline == f"PASS: 6 of 6 requirements met, on {told}"
    assert lines(verdict)[-1] == verdict.headline
    assert as_json(verdict)["plants"] == (int(told.partition(" ")[0]) if "plant" in told else 0)


def test_only_what_is_asked_is_judged() -> None:
    spec = clutch_spec(**(dict.fromkeys(JUDGES) | {"overshoot_percent": 5.0}))
    assert [r.name for r in judge(spec, [clutch_log()]).requirements] == ["overshoot"]


def test_the_worst_step_of_the_worst_variant_counts_and_is_named() -> None:
    log = Log(
        (stream(), stream("/axis/soft", damping=0.5), stream("/axis/stiff", damping=0.9)),
        {},
        "bench/run.mcap",
    )
    overshoot = named(judge(clutch_spec(), [log]), "overshoot")
    assert overshoot.met is False
    assert overshoot.value == pytest.approx(
        overshoot_of(0.5), abs=0.6
    )  # the encoder rounds by 0.56 % of the smallest step
    assert overshoot.where is not None
    assert (overshoot.where.log, overshoot.where.stream) == ("run.mcap", "/axis/soft")
    assert str(overshoot.where).startswith("run.mcap /axis/soft, step ")


def test_values_are_those_of_the_response() -> None:
    verdict = judge(clutch_spec(), [one(damping=0.6, encoder_step=0.0, noise=0.0)])
    assert named(verdict, "overshoot").value == pytest.approx(overshoot_of(0.6), rel=2e-3)
    assert named(verdict, "oscillations").value == 1.0
    assert named(verdict, "static_error").value == pytest.approx(0.0, abs=1e-3)
    assert named(verdict, "drive_peak").value == 50.0
    assert named(verdict, "rest").value == 0.0


def test_a_value_at_its_limit_is_met() -> None:
    verdict = judge(clutch_spec(drive_peak=Quantity(value=50.0, unit="A")), [clutch_log()])
    assert named(verdict, "drive_peak").met is True
    assert (
        named(judge(clutch_spec(), [clutch_log()], controller((0.5,))), "modulus_margin").met
        is True
    )


def test_without_a_controller_the_margin_is_undecided_and_so_is_the_verdict() -> None:
    verdict = judge(clutch_spec(), [clutch_log()])
    margin = named(verdict, "modulus_margin")
    assert (margin.met, margin.value) == (None, None)
    assert "--controller" in margin.reason
    assert not verdict.passed
    assert verdict.state == "undecided"
    assert verdict.undecided == ("modulus_margin",)
    assert (
        verdict.headline == "UNDECIDED: 6 of 7 requirements met, 1 undecided, on 1 recorded stream"
    )


def test_the_worst_vertex_gives_the_margin_and_an_unstable_one_is_worse_than_any() -> None:
    margin = named(
        judge(clutch_spec(), [clutch_log()], controller((0.7, 0.45, 0.6))), "modulus_margin"
    )
    assert (margin.value, margin.met, str(margin.where)) == (0.45, False, "vertex v01")
    margin = named(
        judge(clutch_spec(), [clutch_log()], controller((0.7, 0.6, 0.9), unstable=2)),
        "modulus_margin",
    )
    assert (margin.met, str(margin.where)) == (False, "vertex v02")
    assert "unstable" in margin.reason


def test_a_smooth_reference_decides_only_the_drive() -> None:
    verdict = judge(clutch_spec(), [smooth_log()])
    for name in ("response_time_95", "overshoot", "oscillations"):
        assert named(verdict, name).met is None
        assert "no step" in named(verdict, name).reason
    assert named(verdict, "static_error").met is None
    assert named(verdict, "drive_peak").value == pytest.approx(3.0, abs=0.01)


@pytest.mark.parametrize(("limit", "met"), [(2.0, False), (8.0, None), (8.5, True)])
def test_an_oscillating_current_is_no_noise(limit: float, met: bool | None) -> None:
    """8 A at an eighth of the sampling rate, with 0.03 A of noise."""
    n = np.arange(4000)
    noise = 0.03 * np.random.Generator(np.random.PCG64(1)).normal(size=n.size)
    current = 8.0 * np.sin(2.0 * np.pi * 0.124 * n) + noise
    spec = clutch_spec(drive_peak=Quantity(value=limit, unit="A"))
    for others, expected in (({}, met), ({"command": 0.9 * current}, limit >= 8.0)):
        signals = {"position": 0.0 * n, "reference": 0.0 * n, "current": current, **others}
        log = Log((Stream("/axis", PERIOD * n, signals, {"current": "A"}),), {}, "run.mcap")
        peak = named(judge(spec, [log]), "drive_peak")
        assert (peak.met, peak.value) == (expected, pytest.approx(7.93, abs=0.06))
        assert ("log the command" in peak.reason) == (peak.met is None)


def test_where_nothing_is_decided_it_is_no_pass() -> None:
    verdict = judge(clutch_spec(drive_peak=None), [smooth_log()])
    assert not verdict.passed
    assert verdict.state == "undecided"


@pytest.mark.parametrize(
    ("without", "undecided", "words"),
    [
        (("current", "command"), {"drive_peak", "rest", "modulus_margin"}, "no current"),
        (
            ("reference",),
            {
                "response_time_95",
                "overshoot",
                "static_error",
                "oscillations",
                "rest",
                "modulus_margin",
            },
            "no reference",
        ),
        (
            ("position",),
            {
                "response_time_95",
                "overshoot",
                "static_error",
                "oscillations",
                "rest",
                "modulus_margin",
            },
            "no position",
        ),
    ],
)
def test_a_missing_channel_leaves_what_needs_it_undecided(
    without: tuple[str, ...], undecided: set[str], words: str
) -> None:
    verdict = judge(clutch_spec(), [one(without=without)])
    assert set(verdict.undecided) == undecided
    assert any(words in r.reason for r in verdict.requirements if r.met is None)


def test_values_that_are_not_finite_are_not_judged() -> None:
    broken = stream()
    broken.signals["position"][100] = np.nan
    verdict = judge(clutch_spec(), [Log((broken,), {}, "run.mcap")])
    assert named(verdict, "overshoot").met is None
    assert "not finite" in named(verdict, "overshoot").reason


def test_a_stalled_axis_fails_its_static_error() -> None:
    stalled = stream()
    stalled.signals["position"][:] = 5.0
    verdict = judge(clutch_spec(), [Log((stalled,), {}, "run.mcap")])
    assert named(verdict, "static_error").value == pytest.approx(50.0)
    assert named(verdict, "static_error").met is False
    assert named(verdict, "response_time_95").met is False
    assert named(verdict, "response_time_95").value is None


def test_a_limit_cycle_in_the_hold_breaks_rest_though_the_drive_is_silent() -> None:
    cycling = stream()
    late = cycling.time > 20.0
    cycling.signals["position"][late] += 0.3 * np.sin(10.0 * cycling.time[late])
    rest = named(judge(clutch_spec(), [Log((cycling,), {}, "run.mcap")]), "rest")
    assert rest.met is False
    assert "still moves" in rest.reason
    assert rest.details["motion"] > 0.5


def test_a_moving_axis_is_told_with_its_own_drive_and_not_with_another_s() -> None:
    cycling, live = stream(), stream("/axis/v00")
    cycling.signals["position"][cycling.time > 20.0] += 0.3 * np.sin(
        10.0 * cycling.time[cycling.time > 20.0]
    )
    live.signals["command"][-100:] = 0.2
    rest = named(judge(clutch_spec(), [Log((cycling, live), {}, "run.mcap")]), "rest")
    assert rest.where is not None
    assert (rest.met, rest.where.stream, rest.value) == (False, "/axis", 0.0)


def test_current_at_rest_breaks_rest() -> None:
    live = stream()
    live.signals["command"][-100:] = 0.2
    rest = named(judge(clutch_spec(), [Log((live,), {}, "run.mcap")]), "rest")
    assert (rest.met, rest.value) == (False, 0.2)
    allowed = clutch_spec(rest=Rest(15.0, 0.2))
    assert named(judge(allowed, [Log((live,), {}, "run.mcap")]), "rest").met is True


def test_without_a_command_the_measured_drive_counts_above_its_noise() -> None:
    assert named(judge(clutch_spec(), [one(without=("command",))]), "rest").met is True
    driven = stream(without=("command",))
    driven.signals["current"][-4000:] += 1.0
    rest = named(judge(clutch_spec(), [Log((driven,), {}, "run.mcap")]), "rest")
    assert rest.met is False
    assert rest.value == pytest.approx(1.0, abs=0.2)


def test_a_hold_that_is_too_short_leaves_rest_undecided() -> None:
    rest = named(judge(clutch_spec(), [one(references=REFERENCES[:3])]), "rest")
    assert rest.met is None
    assert "15 s" in rest.reason


def test_a_step_cut_short_by_the_end_of_the_log_is_not_held_against_the_axis() -> None:
    verdict = judge(clutch_spec(), [one(references=((55.0, 1.0), (5.0, 0.1)))])
    response = named(verdict, "response_time_95")
    assert response.met is True
    assert response.where is not None
    assert response.where.step == 1
    assert "held for 0.099 s only" in response.reason
    assert named(verdict, "static_error").where == response.where


def test_energy_is_judged_over_its_window_in_the_unit_of_the_drive() -> None:
    spec = clutch_spec(energy=Energy(0.28, 1.0))
    log = one(noise=0.0)
    energy = named(judge(spec, [log]), "energy")
    count = round(0.28 / PERIOD)
    drive = log.streams[0].signals["current"]
    starts = [
        round(sum(duration for _, duration in REFERENCES[:k]) / PERIOD)
        for k in range(len(REFERENCES))
    ]
    expected = max(float(np.mean(drive[start : start + count] ** 2)) for start in starts)
    assert energy.value == pytest.approx(expected, rel=1e-6)
    assert (energy.unit, energy.met) == ("A^2", False)


def test_several_logs_are_judged_together_and_told_apart() -> None:
    first, second = one(), Log((stream(damping=0.4),), {}, "other/run.mcap")
    where = named(judge(clutch_spec(), [first, second]), "overshoot").where
    assert where is not None
    assert where.log == "run.mcap (2)"


def test_a_log_of_another_kind_of_axis_is_refused() -> None:
    linear = msgspec.structs.replace(clutch_spec(), axis="linear")
    with pytest.raises(
        LogError, match=r"is in rad; the specification describes a linear axis, which needs m"
    ):
        judge(linear, [clutch_log()])


def test_a_log_without_samples_is_refused() -> None:
    with pytest.raises(LogError, match="no stream"):
        judge(clutch_spec(), [Log((), {}, "run.mcap")])
    with pytest.raises(LogError, match="no samples"):
        judge(clutch_spec(), [Log((Stream("/axis", np.zeros(0), {}, {}),), {}, "run.mcap")])


def test_a_resting_axis_may_flicker_between_two_counts() -> None:
    flicker = stream()
    late = np.flatnonzero(flicker.time > 20.0)
    flicker.signals["position"][late[::7]] += ENCODER_STEP
    assert named(judge(clutch_spec(), [Log((flicker,), {}, "run.mcap")]), "rest").met is True
    flicker.signals["position"][late[::7]] += ENCODER_STEP
    assert named(judge(clutch_spec(), [Log((flicker,), {}, "run.mcap")]), "rest").met is False


def test_a_hold_alone_shows_no_lattice_and_the_bench_tells_the_encoder() -> None:
    time = np.arange(16_000) * PERIOD
    position = np.where(np.arange(time.size) % 50 == 0, 131 * ENCODER_STEP, 130 * ENCODER_STEP)
    signals = {
        "position": position,
        "reference": np.full(time.size, 15.0),
        "command": np.zeros(time.size),
    }
    log = Log(
        (Stream("/axis", time, signals, {"position": "rad", "reference": "rad", "command": "A"}),),
        {},
        "hold.mcap",
    )
    assert named(judge(clutch_spec(), [log]), "rest").met is False
    assert named(judge(clutch_spec(), [log], controller()), "rest").met is True
