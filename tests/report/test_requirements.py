"""The requirements that the specification may ask beside those of 5.4.1: met, broken and undecided,
each with its reason."""

from __future__ import annotations

import math
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from frictool.documents.metric_table import Settling
from frictool.documents.quantity import Quantity
from frictool.documents.spec import Spec
from frictool.logs.log import Log, Stream
from frictool.report.requirement import Requirement
from frictool.report.verdict import judge
from frictool.report.worst_hold import limit_of
from studies.rigs.step_logs import ENCODER_STEP, clutch_spec, controller, smooth_log, stream
from studies.rigs.step_responses import overshoot_of

BACKLASH = 3.0  # of the clutch's bench (table 4.8)


def only(key: str, value: object) -> Spec:
    """The specification with this requirement alone."""
    unset = {
        name: None
        for name in Spec.__struct_fields__
        if name not in ("format", "name", "axis", "drive", "examples")
    }
    return clutch_spec(**(unset | {key: value}))


def asked(key: str, value: object, log: Log, *, bench: bool = True) -> Requirement:
    (found,) = judge(only(key, value), [log], controller() if bench else None).requirements
    assert found.key == key
    return found


def rad(value: float) -> Quantity:
    return Quantity(value=value, unit="rad")


def one(**options: object) -> Log:
    return Log((stream(**options),), {}, "run.mcap")


def test_rise_time_of_a_second_order_response() -> None:
    """0.8 of damping, 25 rad/s: from 10 to 90 % on a fine grid."""
    fine = np.arange(0.0, 0.5, 1e-6)
    damped = 25.0 * math.sqrt(1.0 - 0.8**2)
    response = 1.0 - np.exp(-20.0 * fine) * (
        np.cos(damped * fine) + 20.0 / damped * np.sin(damped * fine)
    )
    exact = fine[np.argmax(response >= 0.9)] - fine[np.argmax(response >= 0.1)]
    found = asked("rise_time_s", 0.2, one(encoder_step=0.0))
    assert found.value == pytest.approx(exact, rel=1e-3)
    assert (found.met, found.unit) == (True, "s")
    assert asked("rise_time_s", exact - 1e-3, one(encoder_step=0.0)).met is False
    assert asked("rise_time_s", 0.2, smooth_log()).met is None


def cycling(amplitude: float, period: float) -> Log:
    live = stream()
    late = live.time > 5.0
    live.signals["position"][late] += amplitude * np.sin(2 * math.pi * live.time[late] / period)
    return Log((live,), {}, "run.mcap")


def test_a_limit_cycle_is_judged_by_its_amplitude() -> None:
    found = asked("limit_cycle", rad(0.2), cycling(0.5, 2.0))
    assert found.value == pytest.approx(0.5, abs=0.02)
    assert (found.met, found.unit) == (False, "rad")
    assert str(found.where) == "run.mcap /axis, step 4 at 3.3 s"
    assert asked("limit_cycle", rad(0.6), cycling(0.5, 2.0)).met is True


def test_a_limit_cycle_is_told_absent_by_a_hold_of_15_s_and_by_no_shorter_one() -> None:
    found = asked("limit_cycle", rad(0.0), one())
    assert (found.met, found.value, found.reason) == (True, 0.0, "")
    found = asked("limit_cycle", rad(0.0), one(references=((55.0, 1.1), (5.0, 14.9))))
    assert (found.met, found.value) == (None, None)
    assert "excluded after 15 s" in found.reason


def test_the_rms_drive_is_over_the_whole_record_and_needs_no_step() -> None:
    found = asked("drive_rms", Quantity(value=2.0, unit="A"), smooth_log())
    assert found.value == pytest.approx(3.0 / math.sqrt(2.0), rel=0.02)
    assert (found.met, found.unit) == (False, "A")
    assert asked("drive_rms", Quantity(value=2.5, unit="A"), smooth_log()).met is True
    missing = asked("drive_rms", Quantity(value=2.5, unit="A"), one(without=("current", "command")))
    assert missing.met is None
    assert "no current" in missing.reason


def saturated(samples: int, *, without: tuple[str, ...] = ()) -> Log:
    live = stream(without=without)
    for name in {"command", "current"} - set(without):
        live.signals[name][:] = 0.1
        live.signals[name][1100 : 1100 + samples] = -50.0
    return Log((live,), {}, "run.mcap")


@pytest.mark.parametrize("without", [(), ("command",)])
def test_saturation_is_the_time_at_the_drive_s_limit_in_the_worst_hold(
    without: tuple[str, ...],
) -> None:
    found = asked("saturation_time_s", 0.05, saturated(80, without=without))
    assert found.value == pytest.approx(0.08)
    assert found.met is False
    assert str(found.where) == "run.mcap /axis, step 2 at 1.1 s"
    assert asked("saturation_time_s", 0.05, saturated(40, without=without)).met is True
    assert asked("saturation_time_s", 0.0, saturated(0, without=without)).met is True


def test_saturation_cannot_be_told_without_the_drive_s_limit() -> None:
    found = asked("saturation_time_s", 0.05, saturated(80), bench=False)
    assert found.met is None
    assert "--bench" in found.reason


def test_a_record_that_is_never_held_counts_as_a_whole_for_saturation() -> None:
    log = smooth_log()
    log.streams[0].signals["current"][100:400] = 50.0
    found = asked("saturation_time_s", 0.1, log)
    assert found.value == pytest.approx(0.3)
    assert "never constant" in found.reason


def taken_along(log: Log, *, gap: float = 0.0, keep: bool = True) -> Log:
    """The log's position as a motor's, with the load that it takes along behind the clutch's
    backlash."""
    whole = log.streams[0]
    load, behind = float(whole.signals["position"][0]) + gap, []
    for value in whole.signals["position"]:
        load = min(max(load, value - BACKLASH / 2), value + BACKLASH / 2)
        behind.append(load)
    signals = {**whole.signals, "load_position": np.array(behind)} if keep else whole.signals
    return Log(
        (Stream(whole.topic, whole.time, signals, {**whole.units, "load_position": "rad"}),),
        log.metadata,
        log.source,
    )


@pytest.mark.parametrize("gap", [-1.5, 0.0, 1.4])
def test_the_load_s_static_error_is_exact_where_it_was_logged_and_within_its_bounds_where_not(
    gap: float,
) -> None:
    exact = asked("load_static_error", rad(2.0), taken_along(one(), gap=gap))
    overshot = (
        overshoot_of(0.8) / 100.0 * 20.0
    )  # the load stays where the motor has pushed it, 20 rad being the smallest step
    assert exact.value == pytest.approx(BACKLASH / 2 - overshot, abs=ENCODER_STEP)
    assert exact.met is True
    (bounded,) = judge(
        only("load_static_error", rad(2.0)), [taken_along(one(), keep=False)], controller()
    ).evidence
    evidence, holds = bounded
    (_, known) = judge(
        only("load_static_error", rad(2.0)), [taken_along(one(), gap=gap)], controller()
    ).evidence[0]
    assert evidence.load_is_bounded
    for measured, true in zip(holds, known, strict=True):
        for name in ("load_static_error", "load_overshoot"):
            low, high = measured.bounds[name]
            assert low - 1e-9 <= true.values[name] <= high + 1e-9
            assert (
                high - low
                <= 2.0
                * evidence.resolution
                * (1.0 if name == "load_static_error" else 100.0 / 20.0)
                + 1e-9
            )


def test_a_bounded_load_is_met_broken_or_open() -> None:
    log = taken_along(one(), keep=False)
    met, broken, undecided = (
        asked("load_static_error", rad(limit), log) for limit in (2.0, 0.5, 1.2)
    )
    assert (met.met, met.reason) == (True, "upper bound from the motor's position and the backlash")
    assert (broken.met, broken.reason) == (
        False,
        "lower bound from the motor's position and the backlash",
    )
    assert broken.value is not None
    assert met.value is not None
    assert broken.value < 1.2 < met.value
    assert (undecided.met, undecided.value) == (None, None)
    assert undecided.reason.startswith("between 1.")


def test_the_load_cannot_be_told_without_a_backlash() -> None:
    log = one()
    without = asked("load_static_error", rad(2.0), log, bench=False)
    assert without.met is None
    assert "no load_position, and the backlash is unknown without a bench" in without.reason
    bench = msgspec.structs.replace(
        controller().bench,
        mechanics=msgspec.structs.replace(controller().bench.mechanics, backlash=None),
    )
    (found,) = judge(only("load_static_error", rad(2.0)), [log], None, bench).requirements
    assert found.reason.endswith("the bench gives no backlash")


def test_a_bench_that_is_given_stands_before_the_controller_s_own() -> None:
    bench = controller().bench
    limited = msgspec.structs.replace(
        bench,
        actuator=msgspec.structs.replace(bench.actuator, limit=Quantity(value=30.0, unit="A")),
    )
    log = saturated(80)
    log.streams[0].signals["command"][1100:1180] = 30.0
    (found,) = judge(only("saturation_time_s", 0.05), [log], controller(), limited).requirements
    assert found.value == pytest.approx(0.08)


@pytest.mark.parametrize(
    "limit",
    [
        0.5,
        Quantity(0.5, unit="rad"),
        SimpleNamespace(window_s=2.0, limit=0.5),
        SimpleNamespace(window_s=2.0, limit=Quantity(0.5, unit="rad")),
    ],
)
def test_a_limit_is_a_number_or_a_quantity_with_or_without_a_window(limit: object) -> None:
    assert limit_of(SimpleNamespace(key=limit), "key") == 0.5


RAMP = np.interp(np.arange(2000) * 1e-3, [0.0, 0.5, 1.0], [0.0, 0.0, 20.0])


def moving(error: float, *, profile: bool = False) -> Log:
    """Return a log that follows a ramp with a constant error, which ends 0.2 s after the ramp.

    With `profile` the ramp is the profile towards a step of the reference.
    """
    time = np.arange(RAMP.size) * 1e-3
    position = RAMP - np.where(time < 1.2, error, 0.0)
    target = np.where(time < 0.5, 0.0, 20.0)
    signals = {"reference": RAMP, "position": position, "current": np.zeros(RAMP.size)}
    if profile:
        signals |= {"reference": target, "profile": RAMP}
    units = {name: "A" if name == "current" else "rad" for name in signals}
    return Log((Stream("/axis", time, signals, units),), {}, "run.mcap")


@pytest.mark.parametrize("profile", [False, True])
def test_tracking_is_judged_against_the_moving_reference_or_the_profile(profile: bool) -> None:
    log = moving(0.2, profile=profile)
    for key in ("tracking_error_peak", "tracking_error_rms"):
        met, broken = (asked(key, rad(limit), log) for limit in (0.21, 0.1))
        assert (met.met, broken.met) == (True, False)
        assert met.value is not None
    settling = Settling(rad(0.1), Quantity(value=0.25, unit="s"))
    found = asked("settling_after_profile", settling, log)
    assert (found.met, found.value, found.limit) == (True, pytest.approx(0.2), 0.25)


def test_tracking_of_steps_is_undecided_and_a_moving_stream_is_not_hidden_by_them() -> None:
    still = one()
    found = asked("tracking_error_peak", rad(100.0), still)
    assert (found.met, found.value) == (None, None)
    assert "by steps only" in found.reason
    spec = only("tracking_error_peak", rad(0.21))
    (both,) = judge(spec, [still, moving(0.2)], controller()).requirements
    assert (both.met, both.value) == (True, pytest.approx(0.2))
