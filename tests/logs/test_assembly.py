"""Files to one log without holding it: the same log whatever the blocks, cut and dated as asked,
its chunks in the order of time."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

from frictool.documents.bench import Column, Encoder
from frictool.errors import LogError
from frictool.logs.arrays.memory_table import MemoryTable
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.canonical.sample_chunks import CHUNK_NS
from frictool.logs.clocks.longest_increasing import increasing
from frictool.logs.clocks.sample_intervals import SampleIntervals
from frictool.logs.log import Log
from frictool.logs.log_assembly import (
    LogAssembly,
    TimeWindow,
    add_tables,
    assemble,
    assemble_log,
    write,
)
from frictool.logs.quality.time_base import time_base
from frictool.logs.raw_table import DataLoss, RowBlock
from tests.support.example_logs import as_bytes, bench, golden_log, mapped, same

COLUMNS = {"time": Column("t", "s"), "position": Column("x", "count"), "current": Column("i", "A")}


@dataclass(frozen=True)
class Chopped(MemoryTable):
    """Given in blocks of so many rows, in turn."""

    rows: tuple[int, ...] = (1,)

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        size, low, number = next(iter(self.columns.values())).size, 0, 0
        while low < size:
            high = min(size, low + self.rows[number % len(self.rows)])
            dated = None if self.time_ns is None else self.time_ns[low:high]
            yield RowBlock(low, {name: self.columns[name][low:high] for name in wanted}, dated), 0
            low, number = high, number + 1


def samples(n: int, seed: int = 0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    counts = np.cumsum(rng.integers(-3, 4, n)) % 256
    return {
        "t": np.cumsum(rng.uniform(0.0008, 0.0012, n)),
        "x": counts.astype(float),
        "i": rng.normal(size=n),
    }


def written(
    made: LogAssembly, window: TimeWindow | None = None, period_ns: int | None = None
) -> Log:
    stream = io.BytesIO()
    write(made, stream, {}, window or TimeWindow(), period_ns)
    return read_bytes(stream.getvalue())


def read_bytes(data: bytes) -> Log:
    import tempfile

    with tempfile.NamedTemporaryFile(suffix=".mcap") as file:
        file.write(data)
        file.flush()
        return read_mcap(Path(file.name))


@given(
    n=st.integers(2, 300),
    rows=st.lists(st.integers(1, 90), min_size=1, max_size=4),
    seed=st.integers(0, 2**16),
)
def test_blocks_leave_no_trace(n: int, rows: list[int], seed: int):
    """A counter that wraps across block edges, jittery times, and the warnings: all as from one
    block."""
    rig, columns = bench(COLUMNS, Encoder(counts_per_revolution=100, wrap_bits=8)), samples(n, seed)
    one, made = mapped(MemoryTable(columns, {}, "raw"), rig), LogAssembly()
    add_tables(made, [Chopped(columns, {}, "raw", rows=tuple(rows))], rig)
    log = assemble_log(made)
    assert same(one, log)
    assert one.warnings == log.warnings
    out, again = io.BytesIO(), LogAssembly()
    add_tables(again, [Chopped(columns, {}, "raw", rows=tuple(rows))], rig)
    write(again, out, {})
    assert out.getvalue() == as_bytes(one)


def dated(start_ns: int, n: int, topic: str, names: Sequence[str], rows: int = 7) -> Chopped:
    rng = np.random.default_rng(3)
    time = start_ns + np.arange(n) * 1_000_000
    return Chopped(
        {name: rng.normal(size=n) for name in names},
        {},
        "raw",
        topic,
        "header.stamp",
        time,
        rows=(rows,),
    )


def test_clocks_count_from_the_first_sample_of_all():
    """In whole ns: a date of today in s has steps of 0.2 us."""
    epoch = 1_700_000_000_123_456_789
    tables = [
        dated(epoch + 5_000_007, 50, "/force", ["f"]),
        dated(epoch, 50, "/joints", ["x", "i"]),
    ]
    rig = bench(
        {"position": Column("x", "rad"), "current": Column("i", "A"), "effort": Column("f", "N m")}
    )
    made = LogAssembly()
    add_tables(made, tables, rig)
    log = written(made)
    assert [stream.topic for stream in log.streams] == ["/axis", "/axis/force"]
    assert log.main.time[0] == 0.0
    assert log.streams[1].time[0] == 0.005000007
    assert log.metadata["time"] == {
        "epoch_ns": str(epoch),
        "/axis": "header.stamp",
        "/axis/force": "header.stamp",
    }
    assert "effort" not in log.main.signals  # the bench has a sensor for it


def test_a_second_recording_is_put_where_its_clock_says(tmp_path: Path):
    rig = bench({"position": Column("x", "rad")})
    for number, name in enumerate(("early", "late")):
        made = LogAssembly()
        add_tables(
            made, [dated(1_700_000_000_000_000_000 + number * 250_000_000, 20, "", ["x"])], rig
        )
        with (tmp_path / f"{name}.mcap").open("wb") as stream:
            write(made, stream, {})
    log = written(assemble([tmp_path / "late.mcap", tmp_path / "early.mcap"], None))
    assert [stream.time[0] for stream in log.streams] == [0.0, -0.25]
    assert log.metadata["time"]["epoch_ns"] == "1700000000250000000"


def test_a_column_in_two_tables_has_to_be_named():
    rig = bench({"position": Column("x", "rad")})
    with pytest.raises(
        LogError, match=r"has 2 columns 'x', in /a, /b; write in columns.position a name"
    ):
        mapped([dated(0, 5, "/a", ["x"]), dated(0, 5, "/b", ["x"])], rig)
    with pytest.raises(LogError, match="found 1, but the file has 2 tables"):
        mapped(
            [dated(0, 5, "/a", ["x"]), dated(0, 5, "/b", ["y"])],
            bench({"position": Column(1, "rad")}),
        )


def test_chunks_of_all_streams_are_in_the_order_of_time():
    made, rig = (
        LogAssembly(),
        bench({"position": Column("x", "rad"), "current": Column("i", "A")}, sample_period_s=0.04),
    )
    tables = [
        Chopped(
            {"x": np.arange(1000.0)},
            {},
            "raw",
            "/a",
            "clock",
            np.arange(1000) * 40_000_000,
            rows=(400,),
        ),
        Chopped(
            {"i": np.arange(300.0)},
            {},
            "raw",
            "/b",
            "clock",
            np.arange(300) * 132_000_000 + 5,
            rows=(299,),
        ),
    ]
    add_tables(made, tables, rig)
    out = io.BytesIO()
    write(made, out, {})
    summary = make_reader(io.BytesIO(out.getvalue())).get_summary()
    assert summary is not None
    chunks = summary.chunk_indexes
    assert all(
        one.message_start_time <= other.message_start_time for one, other in pairwise(chunks)
    )
    assert all(one.message_end_time - one.message_start_time < CHUNK_NS for one in chunks)
    assert len(chunks) == 20


@given(start=st.integers(-2_000, 6_000), length=st.integers(0, 6_000))
def test_a_window_keeps_what_lies_within(start: int, length: int):
    """Times in ms; both ends belong to it."""
    time = golden_log().main.time * 1000.0
    inside = (time >= start) & (time <= start + length)
    made = LogAssembly()
    columns = {"t": golden_log().main.time, "x": np.arange(12.0)}
    rig = bench({"time": Column("t", "s"), "position": Column("x", "rad")}, sample_period_s=0.25)
    add_tables(made, [Chopped(columns, {}, "raw", rows=(5,))], rig)
    window = TimeWindow(start * 1_000_000, (start + length) * 1_000_000)
    if not inside.any():
        with pytest.raises(LogError, match=r"has no samples from .* s to .* s"):
            written(made, window)
        return
    assert (
        written(made, window).main.signals["position"].tolist() == np.flatnonzero(inside).tolist()
    )


def test_several_time_bases_become_one_where_asked():
    made, rig = LogAssembly(), bench({"position": Column("x", "rad"), "current": Column("i", "A")})
    slope = np.arange(101) * 1_000_000
    tables = [
        Chopped({"x": slope * 2e-9}, {}, "raw", "/a", "clock", slope, rows=(13,)),
        Chopped(
            {"i": np.arange(31.0)},
            {},
            "raw",
            "/b",
            "clock",
            np.arange(31) * 3_000_000 + 1_500_000,
            rows=(31,),
        ),
    ]
    add_tables(made, tables, rig)
    log = written(made, period_ns=500_000)
    (stream,) = log.streams
    assert stream.time[0] == 0.0015
    assert stream.time[-1] == 0.0915
    assert stream.signals["position"] == pytest.approx(2.0 * stream.time)
    assert np.array_equal(
        stream.signals["current"], np.floor((np.rint(stream.time * 1e6) - 1500) / 3000)
    )
    assert log.metadata["resampled"]["/axis.current"] == "held, from /axis/b.current"


@given(
    steps=st.lists(
        st.sampled_from([1_000_000, 1_000_001, 999_990, 1_100_000, 5_000_000]),
        min_size=1,
        max_size=300,
    ),
    rows=st.integers(1, 50),
)
def test_intervals_seen_in_blocks_are_as_seen_at_once(steps: list[int], rows: int):
    time = np.cumsum([0, *steps])
    seen = SampleIntervals()
    for low in range(0, time.size, rows):
        seen.add(time[low : low + rows])
    found, wanted = seen.base(), time_base(time / 1e9)
    assert (found.samples, found.gaps, found.duration_s) == (
        wanted.samples,
        wanted.gaps,
        pytest.approx(wanted.duration_s),
    )
    assert found.rate_hz == pytest.approx(wanted.rate_hz, rel=1e-3)
    assert found.jitter_s == pytest.approx(wanted.jitter_s, abs=1e-11)
    assert found.longest_gap_s == pytest.approx(wanted.longest_gap_s)


@given(time=st.lists(st.integers(-20, 20), max_size=12), after=st.none() | st.integers(-15, 5))
def test_the_most_samples_that_increase(time: list[int], after: int | None):
    """Reference: every choice."""
    kept = increasing(np.array(time, dtype=np.int64), after)
    chosen = [time[place] for place in kept]
    assert list(kept) == sorted(kept)
    assert all(one < other for one, other in pairwise(chosen))
    assert after is None or not chosen or chosen[0] > after
    best = [0] * len(time)
    for place, value in enumerate(time):
        if after is None or value > after:
            best[place] = 1 + max(
                (best[before] for before in range(place) if time[before] < value), default=0
            )
    assert len(chosen) == max(best, default=0)


def test_rows_that_cannot_be_used_are_left_out_and_told():
    rig, n = bench(COLUMNS), 100
    columns = {"t": np.arange(n) / 1000.0, "x": np.arange(float(n)), "i": np.zeros(n)}
    columns["x"][[10, 11, 40]] = np.nan
    columns["i"][99] = np.inf
    columns["t"][60] = 0.2  # a clock that leaps ahead once: not what follows is wrong
    made = LogAssembly(salvage=True)
    add_tables(made, [Chopped(columns, {}, "raw", rows=(33,))], rig)
    log = written(made)
    kept = np.setdiff1d(np.arange(n), [10, 11, 40, 60, 99])
    assert np.array_equal(np.rint(log.main.time * 1000.0).astype(int), kept)
    told = [(loss.start_s, loss.end_s, loss.samples) for loss in made.losses]
    assert told == [(0.009, 0.012, 2), (0.039, 0.041, 1), (0.059, 0.061, 1), (0.098, None, 1)]
    assert {loss.channels for loss in made.losses} == {
        ("/axis.position", "/axis.current", "/axis.effort")
    }
    with pytest.raises(
        LogError, match=r"raw: sample 11, column 'x': found nan; allowed: a finite number"
    ):
        mapped(MemoryTable(columns, {}, "raw"), rig)
