"""A log as pieces: nothing lost, nothing invented, gaps told, and what cannot be observed refused
in one line."""

from __future__ import annotations

from pathlib import Path

import hypothesis.strategies as st
import msgspec
import numpy as np
import pytest
from hypothesis import given, settings

from frictool.documents.bench import Bench, Column
from frictool.errors import LogError
from frictool.logs.log import Log, Stream
from frictool.logs.log_assembly import TimeWindow
from frictool.observe.sample_stream import PIECE_SAMPLES, open_stream
from studies.rigs.fleet_logs import save
from tests.support.example_logs import bench as rig

UNITS = {"position": "rad", "current": "A", "effort": "N m", "velocity": "rad/s"}
PERIOD = 1e-3
COLUMNS = {"time": Column("t", "s"), "position": Column("x", "rad"), "current": Column("i", "A")}
BENCH: Bench = rig(COLUMNS)


def log(time: np.ndarray, topic: str = "/axis", seed: int = 0, **signals: np.ndarray) -> Log:
    """Positions and currents that are told apart at every sample."""
    draw = np.random.default_rng(seed)
    shown = {
        "position": draw.normal(size=time.size),
        "current": draw.normal(size=time.size),
        **signals,
    }
    return Log(
        (Stream(topic, time, shown, {name: UNITS[name] for name in shown}),),
        {"log": {"kind": "measured"}},
    )


@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.integers(1, 40_000), min_size=1, max_size=4),
    st.lists(st.sampled_from([0.0023, 0.5, 7200.0]), min_size=3, max_size=3),
)
def test_every_sample_comes_once_and_pieces_end_at_gaps(
    tmp_path_factory: pytest.TempPathFactory, lengths: list[int], gaps: list[float]
) -> None:
    lengths = [lengths[0] + 3, *lengths[1:]]
    starts, parts, at = [], [], 0.0
    for length, gap in zip(lengths, [*gaps, 0.0], strict=False):
        starts.append(at)
        parts.append(at + np.arange(length) * PERIOD)
        at = float(parts[-1][-1]) + gap
    time = np.concatenate(parts)
    written = log(time)
    found = open_stream(save(written, tmp_path_factory.mktemp("feed") / "log.mcap"), BENCH)
    pieces = list(found.pieces())
    signals = written.streams[0].signals
    np.testing.assert_allclose(np.concatenate([piece.time for piece in pieces]), time, atol=1e-9)
    np.testing.assert_array_equal(
        np.concatenate([piece.position for piece in pieces]), signals["position"]
    )
    np.testing.assert_array_equal(
        np.concatenate([piece.effort for piece in pieces]), 2.0 * signals["current"]
    )
    broken = [float(piece.time[0]) for piece in pieces if not piece.follows]
    np.testing.assert_allclose(broken, starts, atol=1e-9)
    assert all(np.diff(piece.time).max(initial=0.0) < 1.5 * PERIOD for piece in pieces)
    assert (found.gaps, found.samples) == (len(lengths) - 1, time.size)
    assert any("gap" in remark for remark in found.remarks()) == (len(lengths) > 1)


def test_a_long_log_comes_in_pieces_that_are_bounded(tmp_path: Path) -> None:
    time = np.arange(200_000) * PERIOD
    pieces = list(open_stream(save(log(time), tmp_path / "log.mcap"), BENCH).pieces())
    assert max(piece.time.size for piece in pieces) < 2 * PIECE_SAMPLES
    assert [piece.follows for piece in pieces] == [False, *[True] * (len(pieces) - 1)]


def test_a_raw_file_is_the_same_as_its_ingested_log(tmp_path: Path) -> None:
    written = log(np.arange(3000) * PERIOD).streams[0]
    rows = zip(written.time, written.signals["position"], written.signals["current"], strict=True)
    text = "t [s],x [rad],i [A]\n" + "".join(f"{t:.3f},{x:.17g},{i:.17g}\n" for t, x, i in rows)
    (tmp_path / "raw.csv").write_text(text)
    (piece,) = open_stream(tmp_path / "raw.csv", BENCH).pieces()
    np.testing.assert_array_equal(piece.position, written.signals["position"])
    np.testing.assert_array_equal(piece.effort, 2.0 * written.signals["current"])


def test_a_row_without_numbers_is_left_out_where_asked_and_told(tmp_path: Path) -> None:
    written = log(np.arange(3000) * PERIOD).streams[0]
    rows = [
        f"{t:.3f},{x:.17g},{i:.17g}"
        for t, x, i in zip(written.time, *written.signals.values(), strict=True)
    ]
    rows[1200] = f"{written.time[1200]:.3f},nan,1.0"
    (tmp_path / "hole.csv").write_text("\n".join(["t [s],x [rad],i [A]", *rows, ""]))
    with pytest.raises(LogError, match="found nan"):
        list(open_stream(tmp_path / "hole.csv", BENCH).pieces())
    found = open_stream(tmp_path / "hole.csv", BENCH, salvage=True)
    pieces = list(found.pieces())
    assert [piece.time.size for piece in pieces] == [1200, 1799]
    assert [loss.samples for loss in found.losses] == [1]


def test_an_effort_of_another_constant_is_made_anew_and_a_measured_one_kept(tmp_path: Path) -> None:
    time = np.arange(2000) * PERIOD
    current = np.random.default_rng(3).normal(size=time.size)
    current[:1500] = 0.0  # the drive is silent at first: that tells nothing of its constant
    derived = open_stream(
        save(log(time, current=current, effort=1.9 * current), tmp_path / "derived.mcap"), BENCH
    )
    (piece,) = derived.pieces()
    np.testing.assert_array_equal(piece.effort, 2.0 * current)
    assert any("effort is recomputed" in remark for remark in derived.remarks())
    effort = 1.9 * current + 0.1 * np.sin(time)
    measured = open_stream(
        save(log(time, current=current, effort=effort), tmp_path / "measured.mcap"), BENCH
    )
    (piece,) = measured.pieces()
    np.testing.assert_array_equal(piece.effort, effort)


def test_a_period_that_is_nearly_the_bench_s_is_the_log_s(tmp_path: Path) -> None:
    found = open_stream(save(log(np.arange(2000) * 1.1e-3), tmp_path / "log.mcap"), BENCH)
    assert len(list(found.pieces())) == 1
    assert found.period == pytest.approx(1.1e-3, rel=1e-9)
    assert any("the period is 0.0011 s" in remark for remark in found.remarks())


def test_only_the_window_is_taken(tmp_path: Path) -> None:
    path = save(log(np.arange(5000) * PERIOD), tmp_path / "log.mcap")
    (piece,) = open_stream(path, BENCH, TimeWindow(1_000_000_000, 2_000_000_000)).pieces()
    assert (piece.time[0], piece.time[-1], piece.time.size) == (1.0, 2.0, 1001)
    with pytest.raises(LogError, match="has no samples from 9 s"):
        open_stream(path, BENCH, TimeWindow(9_000_000_000, None))


def test_streams_are_chosen_by_name(tmp_path: Path) -> None:
    streams = [
        log(np.arange(100) * PERIOD, topic, seed).streams[0]
        for seed, topic in enumerate(("/axis", "/axis/light", "/axis/heavy"))
    ]
    path = save(Log(tuple(streams), {"log": {"kind": "simulated"}}), tmp_path / "log.mcap")
    for topic, stream in zip((None, "/axis/light", "/axis/heavy"), streams, strict=True):
        (piece,) = open_stream(path, BENCH, topic=topic).pieces()
        np.testing.assert_array_equal(piece.position, stream.signals["position"])
    with pytest.raises(
        LogError, match=r"no stream '/axis/heavey' \(did you mean '/axis/heavy'\?\)"
    ):
        open_stream(path, BENCH, topic="/axis/heavey")
    apart = save(Log(tuple(streams[1:]), {}), tmp_path / "apart.mcap")
    with pytest.raises(LogError, match="name one with --stream: /axis/light, /axis/heavy"):
        open_stream(apart, BENCH)


@pytest.mark.parametrize(
    ("period", "names", "words"),
    [
        (
            2e-3,
            ("position", "current"),
            r"the period is 0.002 s, but sample_period_s in bench.yaml is 0.001 s",
        ),
        (1e-3, ("position",), r"has no current \(the bench's drive\) or effort; it has position"),
        (1e-3, ("current",), r"has no position; it has current"),
        (1e-3, ("velocity", "current"), r"has no position; it has current, velocity"),
    ],
)
def test_what_cannot_be_observed_is_one_line(
    tmp_path: Path, period: float, names: tuple[str, ...], words: str
) -> None:
    time = np.arange(200) * period
    whole = log(time, velocity=np.ones(time.size)).streams[0]
    left = {name: values for name, values in whole.signals.items() if name in names}
    path = save(
        Log((Stream("/axis", time, left, {name: UNITS[name] for name in left}),), {}),
        tmp_path / "log.mcap",
    )
    with pytest.raises(LogError, match=words) as caught:
        open_stream(path, BENCH)
    assert "\n" not in str(caught.value)


def test_a_clock_that_jitters_is_refused_with_what_to_do(tmp_path: Path) -> None:
    time = np.cumsum(np.random.default_rng(0).uniform(0.5e-3, 1.5e-3, 4000))
    with pytest.raises(LogError, match=r"% of the intervals differ .* --resample 0.00"):
        open_stream(save(log(time), tmp_path / "log.mcap"), BENCH)
    late = np.concatenate(
        [
            np.arange(100_000) * PERIOD,
            100.0 + np.cumsum(np.random.default_rng(0).uniform(0.5e-3, 1.5e-3, 60_000)),
        ]
    )
    with pytest.raises(LogError, match=r"% of the intervals differ"):
        list(open_stream(save(log(late), tmp_path / "late.mcap"), BENCH).pieces())


def test_a_reversed_sensor_is_told_and_nonsense_is_refused(tmp_path: Path) -> None:
    time = np.arange(6000) * PERIOD
    position = 30.0 * (1.0 - np.cos(2.0 * np.pi * time))
    current = np.sign(np.sin(2.0 * np.pi * time))
    for sign, told in ((1.0, False), (-1.0, True)):
        found = open_stream(
            save(log(time, position=position, current=sign * current), tmp_path / "log.mcap"), BENCH
        )
        list(found.pieces())
        assert any("has the wrong sign" in remark for remark in found.remarks()) == told
    path = save(log(time, position=1e300 * position), tmp_path / "log.mcap")
    with pytest.raises(LogError, match=r"position is .*e\+301 at .* allowed: at most 1e\+12"):
        list(open_stream(path, BENCH).pieces())


def test_the_other_kind_of_axis_is_refused(tmp_path: Path) -> None:
    linear = msgspec.structs.replace(rig(COLUMNS, axis="linear"))
    with pytest.raises(LogError, match="give the bench of this log"):
        open_stream(save(log(np.arange(100) * PERIOD), tmp_path / "log.mcap"), linear)
