"""Plotted curves are the logged signals."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.logs.log import Log, Stream
from frictool.metrics.reference_holds import find_holds
from frictool.presentation.decimation import COLUMNS, decimated_indices, decimated_path_indices
from frictool.report.curve_figures import overview_figures
from frictool.report.evidence import gather_evidence
from frictool.report.hold_metrics import HoldMetrics
from frictool.report.step_figures import same_steps, step_views, window
from frictool.report.tables import hold_tables
from frictool.report.verdict import judge
from studies.rigs.step_logs import ENCODER_STEP, clutch_spec, stream


@given(st.integers(1, 20_000), st.integers(0, 10**6))
def test_thinning_loses_no_peak(count: int, seed: int) -> None:
    signal = np.random.default_rng(seed).standard_normal(count)
    kept = decimated_indices(signal)
    assert np.all(np.diff(kept) > 0)
    assert (kept[0], kept[-1]) == (0, count - 1)
    assert signal[kept].min() == signal.min()
    assert signal[kept].max() == signal.max()
    assert kept.size <= max(2, 4) * COLUMNS


def test_a_path_is_followed_closely_and_standing_still_costs_nothing() -> None:
    angle = np.concatenate((np.zeros(50_000), np.linspace(0.0, 2 * np.pi, 20_000)))
    x, y = 3.0 * np.cos(angle), 0.1 * np.sin(angle)
    kept = decimated_path_indices(x, y)
    assert kept.size < 5 * COLUMNS
    assert np.max(np.hypot(np.diff(x[kept]) / 6.0, np.diff(y[kept]) / 0.2)) < 2.0 / COLUMNS
    assert decimated_path_indices(np.zeros(10), np.zeros(10)).tolist() == [0, 9]


def test_the_log_s_own_velocity_is_shown() -> None:
    (item,) = gather_evidence(clutch_spec(), [Log((stream(),), {}, "run.mcap")])
    shown = item.velocity
    assert shown is not None
    assert np.array_equal(shown[0], item.stream.signals["velocity"])
    assert shown[1] == "velocity in the log"


def test_without_it_the_encoder_difference_is_near_and_says_what_it_is() -> None:
    (with_velocity,) = gather_evidence(clutch_spec(), [Log((stream(),), {}, "run.mcap")])
    (without,) = gather_evidence(
        clutch_spec(), [Log((stream(without=("velocity",)),), {}, "run.mcap")]
    )
    shown = without.velocity
    assert shown is not None
    velocity, source = shown
    true = with_velocity.stream.signals["velocity"]
    assert velocity.shape == true.shape
    assert source.startswith("position difference over ")
    assert np.sqrt(np.mean((velocity - true) ** 2)) < 0.04 * np.max(np.abs(true))


def test_a_steady_speed_is_shown_exactly_to_the_ends() -> None:
    steady = stream(without=("velocity",))
    steady.signals["position"][:] = 2.0 * steady.time
    (item,) = gather_evidence(clutch_spec(), [Log((steady,), {}, "run.mcap")])
    shown = item.velocity
    assert shown is not None
    np.testing.assert_allclose(shown[0], 2.0, rtol=1e-9)


def test_a_step_is_shown_past_its_response_and_whole_where_it_never_settles() -> None:
    spec = clutch_spec()
    ((item, holds),) = judge(spec, [Log((stream(),), {}, "run.mcap")]).evidence
    shown = window(spec, [(item, holds[0])])
    assert holds[0].values["response_time_95"] < shown < 0.5
    ringing = stream(damping=0.01)
    ((item, holds),) = judge(spec, [Log((ringing,), {}, "run.mcap")]).evidence
    assert window(spec, [(item, holds[0])]) == pytest.approx(1.1, abs=2e-3)


def test_several_logs_are_aligned_at_the_steps_that_they_have_in_common() -> None:
    """The same steps at other times, one more in between, and one step played twice."""
    plan = ((55.0, 1.1), (5.0, 1.1), (35.0, 1.1), (15.0, 2.0))
    other = (
        (55.0, 2.0),
        (5.0, 1.3),
        (25.0, 1.0),
        (5.0, 1.0),
        (35.0, 1.1),
        (15.0, 1.0),
        (35.0, 1.0),
        (15.0, 1.0),
    )
    logs = [
        Log((stream(references=plan),), {}, "one.mcap"),
        Log((stream(references=other, start=5.0),), {}, "two.mcap"),
    ]
    groups = same_steps(judge(clutch_spec(), logs).evidence)
    shared = [
        [(e.source, round(m.start_s, 3), m.hold.target) for e, m in group]
        for group in groups
        if len({e.source for e, _ in group}) == 2
    ]
    assert shared == [
        [("one.mcap", 0.0, 55.0), ("two.mcap", 0.0, 55.0)],
        [("one.mcap", 1.1, 5.0), ("two.mcap", 2.0, 5.0)],
        [("one.mcap", 2.2, 35.0), ("two.mcap", 5.3, 35.0)],
        [("one.mcap", 3.3, 15.0), ("two.mcap", 6.4, 15.0)],
    ]
    alone = [[m.hold.target for _, m in group] for group in groups if len(group) == 1]
    assert alone == [[25.0], [5.0], [35.0], [15.0]]
    titles = [
        picture.title for picture in step_views(clutch_spec(), judge(clutch_spec(), logs).evidence)
    ]
    assert titles[0].endswith("at 0 s")
    assert titles[1] == "Step 2: 55 to 5 rad, aligned at the step"


def test_a_load_that_differs_from_the_sensor_has_a_picture_and_one_that_does_not_has_none() -> None:
    signals = {**stream().signals, "load_position": stream().signals["position"]}
    together = Stream("/axis", stream().time, signals, stream().units)
    behind = Stream(
        "/axis",
        stream().time,
        {**signals, "load_position": signals["position"] - 1.5},
        stream().units,
    )
    found = [
        gather_evidence(clutch_spec(), [Log((one,), {}, "run.mcap")])[0].has_backlash
        for one in (stream(), together, behind)
    ]
    assert found == [False, False, True]


def test_a_sensor_that_is_wrong_by_more_than_its_rounding_has_a_picture() -> None:
    """As after lost counts: simulated logs know the true position."""
    plain = stream()
    rounding = plain.signals["position"] + 0.9 * ENCODER_STEP
    lost = plain.signals["position"] + np.where(plain.time > 2.0, 9 * ENCODER_STEP, 0.0)
    for true, pictured in ((rounding, False), (lost, True)):
        signals = {**plain.signals, "position_true": true}
        evidence = gather_evidence(
            clutch_spec(),
            [Log((Stream("/axis", plain.time, signals, plain.units),), {}, "run.mcap")],
        )
        assert (
            "Sensor error"
            in [picture.title for picture in overview_figures(clutch_spec(), evidence)]
        ) is pictured


def test_thousands_of_steps_are_sorted_and_listed_in_part() -> None:
    """A durability test: one record of 3000 steps, another of as many."""
    hold = find_holds(np.repeat([5.0, 55.0], 40), np.zeros(80))[1]
    (item,) = gather_evidence(
        clutch_spec(), [Log((stream(references=((55.0, 0.5),)),), {}, "run.mcap")]
    )
    holds = tuple(HoldMetrics(hold, k, float(k), {"overshoot": 1.0}) for k in range(3000))
    judged = tuple(
        (dataclasses.replace(item, source=name), holds) for name in ("one.mcap", "two.mcap")
    )
    groups = same_steps(judged)
    assert [[m.number for _, m in group] for group in groups] == [[k, k] for k in range(3000)]
    (table,) = hold_tables(clutch_spec(), judged)
    assert (len(table.rows), table.left_out) == (400, 5600)
