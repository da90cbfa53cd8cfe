"""A logged channel as the reference: what is held, what is interpolated, what cannot be
replayed."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Replay, Scenario
from frictool.errors import LogError
from frictool.logs.log import Log, Stream
from frictool.logs.log_reader import read_log
from frictool.simulate.logged_reference import gaps_of, reference_from_log
from frictool.typing import Vector

T = 1e-3


def logged(time: Vector, values: Vector, channel: str = "reference", unit: str = "rad") -> Log:
    return Log((Stream("/axis", time, {channel: values}, {channel: unit}),), source="bench.csv")


def steps(time: Vector) -> Vector:
    return np.where(time < 0.5, 10.0, np.where(time < 1.2, 40.0, 15.0))


def test_at_the_same_period_every_sample_is_replayed_once() -> None:
    values = np.random.default_rng(1).uniform(0.0, 60.0, 500)
    np.testing.assert_array_equal(
        reference_from_log(Replay("x"), logged(3.0 + T * np.arange(500), values), "rotary", T),
        values,
    )


@given(seed=st.integers(0, 10_000), part=st.floats(0.0, 0.24))
def test_jitter_neither_doubles_nor_drops_a_sample(seed: int, part: float) -> None:
    rng = np.random.default_rng(seed)
    time, values = T * (np.arange(400) + rng.uniform(-part, part, 400)), rng.uniform(0.0, 60.0, 400)
    found = reference_from_log(Replay("x"), logged(time, values), "rotary", T)
    assert abs(found.size - 400) <= 1
    np.testing.assert_array_equal(found[:399], values[:399])


@pytest.mark.parametrize("period", [1e-4, 7e-4, 1e-3, 3e-3, 10e-3])
def test_a_reference_keeps_its_steps_within_a_sample(period: float) -> None:
    """Held, so that no value lies between those of the log, and each step is where it was to half a
    sample of each clock."""
    time = period * np.arange(round(2.0 / period))
    found = reference_from_log(Replay("x"), logged(time, steps(time)), "rotary", T)
    assert set(np.unique(found)) == {10.0, 15.0, 40.0}
    for before, after in ((10.0, 40.0), (40.0, 15.0)):
        told = float(
            time[np.flatnonzero((steps(time)[:-1] == before) & (steps(time)[1:] == after))[0] + 1]
        )
        played = T * (np.flatnonzero((found[:-1] == before) & (found[1:] == after))[0] + 1)
        assert -0.5 * T - 1e-9 <= played - told <= 0.5 * T + 1e-9


def test_a_measured_position_is_a_straight_line_between_its_samples() -> None:
    time = 7e-3 * np.arange(200)
    found = reference_from_log(
        Replay("x", channel="position"), logged(time, 20.0 + 3.0 * time, "position"), "rotary", T
    )
    np.testing.assert_allclose(found, 20.0 + 3.0 * T * np.arange(found.size), rtol=1e-12)
    assert found.size == round(time[-1] / T) + 1


def test_a_part_of_it_shifted_and_then_held() -> None:
    time = T * np.arange(3000)
    replay = Replay("x", from_s=1.0, to_s=2.0, shift=Quantity(value=2.0, unit="rad"), hold_s=15.0)
    found = reference_from_log(replay, logged(time, 10.0 * time), "rotary", T)
    assert (found[0], found[1000], found.size) == (
        pytest.approx(12.0),
        pytest.approx(22.0),
        1001 + 15_000,
    )
    assert np.all(found[1000:] == found[1000])


@pytest.mark.parametrize(
    ("replay", "log", "words"),
    [
        (
            Replay("x", channel="wanted"),
            logged(T * np.arange(9), np.ones(9)),
            "has no wanted; found: reference",
        ),
        (
            Replay("x"),
            logged(T * np.arange(9), np.ones(9), unit="A"),
            "has reference in 'A'; allowed as a reference: a channel in rad",
        ),
        (
            Replay("x", from_s=1.0),
            logged(T * np.arange(9), np.ones(9)),
            "has a duration of 0.008 s, but the scenario replays 1 s to 0.008 s",
        ),
        (
            Replay("x", to_s=1.0),
            logged(T * np.arange(9), np.ones(9)),
            "has a duration of 0.008 s, but the scenario replays 0 s to 1 s",
        ),
        (
            Replay("x"),
            logged(T * np.arange(9), np.where(np.arange(9) == 4, np.nan, 1.0)),
            "no number for reference at 0.004 s",
        ),
    ],
)
def test_what_cannot_be_replayed_is_named(replay: Replay, log: Log, words: str) -> None:
    with pytest.raises(LogError, match=words):
        reference_from_log(replay, log, "rotary", T)


def test_gaps_are_told_where_they_are_replayed() -> None:
    time = np.concatenate([T * np.arange(100), 0.3 + T * np.arange(100)])
    log = logged(time, np.ones(200))
    (told,) = gaps_of(Replay("x"), log)
    assert "has 1 gap, the longest of 0.201 s at 0.099 s" in told
    assert gaps_of(Replay("x", from_s=0.3), log) == []
    assert reference_from_log(Replay("x"), log, "rotary", T).size == 400


def test_the_reference_of_a_measured_record_is_replayed_sample_by_sample() -> None:
    """EMPS, read from its own file by the columns of its bench."""
    root = Path(__file__).parents[2]
    data = Path(os.environ.get("FRICTOOL_DATA", root / "../shared/data")) / "emps/DATA_EMPS.mat"
    if not data.is_file():
        pytest.skip(
            "the EMPS record is not here; set FRICTOOL_DATA to the folder that holds "
            "emps/DATA_EMPS.mat"
        )
    log = read_log(data, load(root / "configs/emps/bench.yaml", Bench))
    scenario = load(root / "configs/emps/scenarios/replay.yaml", Scenario)
    np.testing.assert_array_equal(
        reference_from_log(scenario.reference, log, "linear", T), log.main.signals["reference"]
    )
    assert gaps_of(scenario.reference, log) == []
