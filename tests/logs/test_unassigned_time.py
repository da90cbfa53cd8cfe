"""Time columns that the bench does not assign."""

from __future__ import annotations

import re

import numpy as np
import pytest
import yaml
from hypothesis import assume, given
from hypothesis import strategies as st

from frictool.documents.bench import Column
from frictool.logs.arrays.memory_table import MemoryTable
from frictool.logs.channels.unassigned_time import unassigned_time
from frictool.logs.quality.time_base import coarse_period
from tests.support.example_logs import bench, mapped

PERIOD = 0.02  # s, of the bench
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
PROPOSED = re.compile(r"add time: (\{.*\}) to columns")


def table(time: np.ndarray, name: str = "Time", unit: str | None = None) -> MemoryTable:
    columns = {"encoder": np.arange(time.size) % 7.0, name: time}
    return MemoryTable(columns, {name: unit}, "raw.csv")


@given(
    period=st.floats(0.001, 0.2),
    unit=st.sampled_from(sorted(SECONDS)),
    start=st.sampled_from([0.0, 1.7e9]),
    named=st.booleans(),
    seed=st.integers(0, 99),
)
def test_only_times_with_another_period_are_reported(
    period: float, unit: str, start: float, named: bool, seed: int
):
    """The clock jitters by half a period; a column without a unit may be in any unit."""
    assume(abs(period / PERIOD - 1.0) > 0.03)
    jitter = np.random.default_rng(seed).uniform(-0.25, 0.25, 400)

    def doubt(real: float) -> str | None:
        time = (start + real * (np.arange(400) + jitter)) / SECONDS[unit]
        return unassigned_time(table(time, unit=unit if named else None), PERIOD)

    assert doubt(PERIOD) is None
    text = doubt(period)
    assert text is not None
    assert len(text) <= 190
    proposed = yaml.safe_load(PROPOSED.search(text)[1])
    if named:
        assert proposed == {"column": "Time", "unit": unit}
        assert float(re.search(r"increases by (\S+) s", text)[1]) == pytest.approx(period, rel=2e-3)


@pytest.mark.parametrize("name", ["cycle", "index", "time", "t"])
def test_a_row_number_is_no_time(name: str):
    assert unassigned_time(table(np.arange(50.0), name), PERIOD) is None


def test_rounded_times_and_a_second_clock_agree():
    exact = 1.0 / 60.0
    short = table(np.round(exact * np.arange(12.0), 2), unit="s")
    assert unassigned_time(short, exact) is None
    assert unassigned_time(short, 3.0 * exact) is not None
    both = {**short.columns, "log_time": 1.7e12 + 60.0 * np.arange(12.0)}
    logged = MemoryTable(both, {"Time": "ms", "log_time": "ms"}, "raw.csv")
    assert unassigned_time(logged, 0.06) is None


def test_an_assigned_time_is_read_without_a_doubt():
    raw = table(0.003 * np.arange(50.0), "sample time", "s")
    columns = {"position": Column("encoder", "count")}
    (text,) = mapped(raw, bench(columns)).warnings
    proposed = Column(**yaml.safe_load(PROPOSED.search(text)[1]))
    log = mapped(raw, bench({**columns, "time": proposed}))
    assert np.allclose(log.main.time, raw.columns["sample time"])
    assert not any(PROPOSED.search(one) for one in log.warnings)


@pytest.mark.parametrize(("rate", "jitter"), [(50.0, 0.0), (17.3, 0.2), (4.0, 0.1)])
def test_whole_seconds_have_the_period_of_their_rows(rate: float, jitter: float):
    shift = np.random.default_rng(5).uniform(-jitter, jitter, 2000)
    time = np.floor((0.3 + np.arange(2000) + shift) / rate)
    period, error = coarse_period(time)
    assert abs(period * rate - 1.0) <= 2.0 * error / period < 0.003
    assert unassigned_time(table(time, unit="s"), 1.0 / rate) is None
    assert "period" in unassigned_time(table(time, unit="s"), 3.0 / rate)


def test_a_row_for_each_change_has_no_period():
    """A counter of operating seconds that stands still, and times without repetitions."""
    rng = np.random.default_rng(6)
    assert coarse_period(np.cumsum(rng.random(2000) < 0.1).astype(float)) is None
    assert coarse_period(0.02 * np.arange(50.0)) is None
