"""Channels A and B to counts: a slow table of transitions is the reference, and an axis that moves
comes back as it was."""

from __future__ import annotations

import itertools
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.bench import Column, Quadrature
from frictool.errors import LogError
from frictool.logs.kernels.quadrature import COUNT, ILLEGAL, UNKNOWN, count_quadrature
from frictool.logs.log_assembly import assemble, assemble_log
from frictool.logs.log_reader import read_log
from tests.support.example_logs import bench

ORDER = [(0, 0), (1, 0), (1, 1), (0, 1)]  # of (A, B) where the count rises


def counted(
    a: np.ndarray, b: np.ndarray, low: float = 0.5, high: float = 0.5, cut: int = 0
) -> tuple[list[float], int]:
    state, counts = np.array([UNKNOWN, UNKNOWN, 0, 0]), np.empty(a.size)
    for part in (slice(0, cut), slice(cut, None)):
        count_quadrature(a[part], b[part], low, high, state, counts[part])
    assert not counts.size or counts[-1] == state[COUNT]
    return counts.tolist(), int(state[ILLEGAL])


def reference(levels: list[tuple[int, int]]) -> tuple[list[float], int]:
    counts, illegal, count = [0.0], 0, 0.0
    for before, after in itertools.pairwise(levels):
        step = (ORDER.index(after) - ORDER.index(before)) % 4
        illegal += step == 2
        count += {0: 0, 1: 1, 2: 0, 3: -1}[step]
        counts.append(count)
    return counts, illegal


@given(levels=st.lists(st.sampled_from(ORDER), min_size=1, max_size=60), cut=st.integers(0, 60))
def test_counts_are_those_of_the_table_of_transitions(levels: list[tuple[int, int]], cut: int):
    a, b = np.array(levels, float).T
    assert counted(a, b, cut=min(cut, len(levels))) == reference(levels)


@given(
    seed=st.integers(0, 1000),
    noise=st.floats(0.0, 0.45),
    turns=st.floats(-20.0, 20.0).filter(lambda turns: abs(turns) > 0.1),
)
def test_noise_below_the_hysteresis_counts_nothing(seed: int, noise: float, turns: float):
    """Levels of 0 and 5 V, a hysteresis of 1 V: the count follows the motion within one, whatever
    the noise does at the edges."""
    rng, motion = np.random.default_rng(seed), np.linspace(0.0, 4.0 * turns, 4000)
    states = np.array(ORDER)[np.floor(motion).astype(int) % 4] * 5.0
    a, b = (states + rng.uniform(-noise, noise, states.shape)).T
    counts, illegal = counted(a, b, 2.0, 3.0)
    assert illegal == 0
    assert np.abs(np.array(counts) - np.floor(motion) + np.floor(motion[0])).max() == 0.0


def test_a_level_between_the_thresholds_stays_and_what_is_no_number_too():
    a = np.array([0.0, 2.6, 3.1, 2.4, np.nan, 1.9])
    assert counted(a, np.zeros(6), 2.0, 3.0) == ([0, 0, 1, 1, 1, 0], 0)


def scope(folder: Path, period: float, samples: int, speed: float) -> tuple[Path, np.ndarray]:
    """An export of a 10:1 probe at an encoder that turns at `speed` counts a second."""
    time = np.arange(samples) * period
    states = np.array(ORDER)[np.floor(speed * time).astype(int) % 4] * 0.5
    rows = "".join(f"{k},{a:.2f},{b:.2f},,\n" for k, (a, b) in enumerate(states))
    path = folder / "scope.csv"
    path.write_text(f"X,CH1,CH2,Start,Increment\nSequence,VOLT,VOLT,0,{period}\n" + rows)
    return path, time


RIG = msgspec.structs.replace(
    bench({"position": Column("encoder", "count")}),
    quadrature={"encoder": Quadrature("CH1", 3, threshold=2.5, hysteresis=1.0, probe=10.0)},
)


def test_an_oscilloscope_s_export_becomes_positions_at_the_bench_s_period(tmp_path: Path):
    path, time = scope(tmp_path, 1e-5, 30_000, 4000.0)
    made = assemble([path], RIG)
    log = assemble_log(made)
    assert made.warnings == ()
    assert log.main.time == pytest.approx(np.arange(300) * 1e-3, abs=1e-12)
    expected = np.floor(4000.0 * time[::100]) * 2.0 * np.pi / 100.0
    assert np.abs(log.main.signals["position"] - expected).max() < 1e-9


def test_too_slow_a_sampling_is_told(tmp_path: Path):
    path, _ = scope(tmp_path, 1e-4, 3000, 15_000.0)
    made = assemble([path], RIG)
    assemble_log(made)
    assert len(made.warnings) == 1
    assert "transitions change both channels together" in made.warnings[0]


@pytest.mark.parametrize("longest", [0.02, 0.0018])  # the latter has the bench's period as its mean
def test_what_a_logic_analyser_writes_on_change_is_held(tmp_path: Path, longest: float):
    """Rows only where a channel changes, the last at the end: between them the count stays."""
    path = tmp_path / "digital.csv"
    edges = np.cumsum(np.random.default_rng(2).uniform(0.0002, longest, 200))
    rows = "".join(
        f"{t:.9f},{a},{b}\n"
        for t, (a, b) in zip(edges, (ORDER[k % 4] for k in range(200)), strict=True)
    )
    path.write_text("Time [s],Channel 0,Channel 1\n" + rows)
    rig = msgspec.structs.replace(
        bench({"time": Column("Time", "s"), "position": Column("encoder", "count")}),
        quadrature={"encoder": Quadrature(2, "Channel 1")},
    )
    log = read_log(path, rig)
    edges = np.round(edges, 9)
    assert np.diff(log.main.time) == pytest.approx(1e-3, abs=1e-9)
    expected = np.searchsorted(edges, log.main.time + 1e-10, side="right") - 1
    assert np.abs(log.main.signals["position"] / (2 * np.pi / 100) - expected).max() < 1e-9


def test_a_channel_that_is_not_there_is_named(tmp_path: Path):
    path, _ = scope(tmp_path, 1e-3, 100, 100.0)
    rig = msgspec.structs.replace(RIG, quadrature={"encoder": Quadrature("CH1", "CH4")})
    with pytest.raises(
        LogError, match=r"has no column 'CH4' \(did you mean 'CH2'\?\); found: Sequence, CH1, CH2"
    ):
        read_log(path, rig)
