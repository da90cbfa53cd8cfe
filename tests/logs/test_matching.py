"""A canonical log beside a bench that may not be its own."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench, Column
from frictool.documents.quantity import Quantity
from frictool.errors import LogError
from frictool.logs.arrays.memory_table import MemoryTable
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log import Log, Stream
from tests.support.example_logs import bench, mapped

COLUMNS = {"position": Column("encoder", "count"), "current": Column("i", "A")}
CURRENT = np.array([0.5, -1.25, 3.0, 2.0])


def made(rig: Bench, **columns: np.ndarray) -> Log:
    """Return the log that `ingest` would make of four rows."""
    table = {"encoder": np.arange(4.0), "i": CURRENT, **columns}
    return mapped(MemoryTable(table, dict.fromkeys(table), "raw.csv"), rig)


def stronger(rig: Bench, constant: float) -> Bench:
    actuator = msgspec.structs.replace(rig.actuator, constant=Quantity(constant, unit="N m/A"))
    return msgspec.structs.replace(rig, actuator=actuator)


def test_a_log_of_this_bench_stays_as_it_is():
    rig = bench(COLUMNS)
    log = made(rig)
    again = match_bench(log, rig)
    assert again.warnings == ()
    for name, values in log.main.signals.items():
        assert np.array_equal(again.main.signals[name], values)


def test_a_constant_that_has_changed_is_applied_and_said():
    rig = bench(COLUMNS)
    log = match_bench(made(rig), stronger(rig, 3.0))
    assert log.main.signals["effort"] == pytest.approx(3.0 * CURRENT)
    assert log.warnings == (
        "effort is recomputed from current with actuator.constant of bench.yaml, 3 N m/A; "
        "the effort in the log was computed with 2 N m/A",
    )


def test_a_measured_effort_is_kept_whatever_the_constant():
    rig = bench({**COLUMNS, "effort": Column("sensor", "N m")})
    log = match_bench(
        made(rig, sensor=2.0 * CURRENT), stronger(rig, 3.0)
    )  # even one that is a multiple of the current
    assert log.main.signals["effort"] == pytest.approx(2.0 * CURRENT)
    assert log.warnings == ()


@pytest.mark.parametrize(
    ("effort", "kept"), [(2.0 * CURRENT, False), (2.0 * CURRENT + 1e-3 * np.arange(4.0), True)]
)
def test_without_columns_the_numbers_tell(effort: np.ndarray, kept: bool):
    units = {"current": "A", "effort": "N m"}
    log = Log(
        (Stream("/axis", np.arange(4) / 1000.0, {"current": CURRENT, "effort": effort}, units),)
    )
    found = match_bench(log, stronger(bench(COLUMNS), 3.0)).main.signals["effort"]
    assert found == pytest.approx(effort if kept else 3.0 * CURRENT)


def test_an_effort_made_from_another_drive_is_not_taken():
    rig = bench(COLUMNS)
    actuator = msgspec.structs.replace(rig.actuator, drive="voltage")
    log = match_bench(made(rig), msgspec.structs.replace(rig, actuator=actuator))
    assert "effort" not in log.main.signals
    with pytest.raises(LogError, match="has no voltage"):
        log.require(log.main, "voltage")


def test_a_rotary_log_is_none_of_a_linear_bench():
    with pytest.raises(
        LogError,
        match=r"/axis.position is in 'rad', but the linear axis of bench 'rig' needs 'm'",
    ):
        match_bench(made(bench(COLUMNS)), bench(COLUMNS, axis="linear"))


@pytest.mark.parametrize("period", [0.04, 2e-5, 1.0])
def test_a_period_of_another_unit_of_time_is_refused(period: float):
    with pytest.raises(
        LogError, match=r"the period is 0\.001 s, but sample_period_s in bench.yaml"
    ):
        match_bench(made(bench(COLUMNS)), bench(COLUMNS, sample_period_s=period))


@pytest.mark.parametrize("period", [0.0015, 0.0005])
def test_a_log_of_another_period_is_read_with_a_warning(period: float):
    log = match_bench(made(bench(COLUMNS)), bench(COLUMNS, sample_period_s=period))
    assert any("the period is 0.001 s" in warning for warning in log.warnings)


def test_a_period_that_is_a_little_off_is_a_warning_once():
    rig, other = bench(COLUMNS), bench(COLUMNS, sample_period_s=0.00105)
    log = match_bench(made(rig), other)
    assert len(log.warnings) == 1
    assert match_bench(log, other).warnings == log.warnings


def test_a_drive_that_is_zero_throughout_tells_no_other_constant():
    rig = bench(COLUMNS)
    still = made(rig)
    signals = {
        name: 0.0 * values if name in ("current", "effort") else values
        for name, values in still.main.signals.items()
    }
    assert (
        match_bench(replace(still, streams=(replace(still.main, signals=signals),)), rig).warnings
        == still.warnings
    )


def test_a_current_in_milliamperes_is_named_with_its_column_and_unit() -> None:
    """The bench states amperes: the values are 1000 times the drive's."""
    rig = bench(COLUMNS)
    limit = rig.actuator.limit.value
    milli = 1000.0 * 0.5 * limit * np.array([1.0, -1.0, 0.8, -0.2])
    log = made(rig, i=milli)
    assert log.warnings == (
        f"column 'i' is {milli.min():.4g} to {milli.max():.4g} A, but the drive's limit in "
        f"bench.yaml is {limit:.4g} A; if it is in mA, write unit: mA in columns.current",
    )
    with pytest.raises(LogError, match=r"column 'i' is .*; if it is in mA, write unit: mA"):
        match_bench(log, rig)
    right = bench({**COLUMNS, "current": Column("i", "mA")})
    assert match_bench(made(right, i=milli), right).warnings == ()


def test_a_drive_beyond_any_small_unit_asks_for_the_limit() -> None:
    rig = bench(COLUMNS)
    log = made(rig, i=1e5 * rig.actuator.limit.value * np.array([1.0, -1.0, 1.0, -1.0]))
    assert log.warnings[0].endswith("correct columns.current or actuator.limit")


def test_a_measured_effort_in_small_units_is_named() -> None:
    rig = bench({**COLUMNS, "effort": Column("sensor", "N m")})
    most = rig.actuator.limit.value * rig.actuator.constant.value
    log = made(rig, sensor=400.0 * most * np.array([1.0, -1.0, 1.0, -1.0]))
    assert "column 'sensor' is" in log.warnings[0]
    assert log.warnings[0].endswith("if it is in mN m, write unit: mN m in columns.effort")


def test_a_few_spikes_are_no_other_unit() -> None:
    rig = bench(COLUMNS)
    current = np.zeros(1000)
    current[500] = 1e3 * rig.actuator.limit.value
    log = made(rig, encoder=np.arange(1000.0), i=current)
    assert not any("drive's limit" in text for text in log.warnings)
