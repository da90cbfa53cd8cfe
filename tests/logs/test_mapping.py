"""Columns to channels: counts, units, scale, the derived effort, and time."""

from __future__ import annotations

import math
import re
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.bench import Column, Encoder
from frictool.errors import LogError
from frictool.logs.arrays.memory_table import MemoryTable
from frictool.logs.log import Log
from tests.support import example_logs
from tests.support.example_logs import bench

STEP = 2.0 * math.pi / 100.0
POSITION = {"position": Column("encoder", "count")}
TIMED = {"time": Column("t", "s"), **POSITION}


def table(
    columns: dict[str, list[float]],
    units: dict[str, str | None] | None = None,
    first_line: int | None = None,
):
    vectors = {name: np.array(values, dtype=float) for name, values in columns.items()}
    return MemoryTable(vectors, units or {}, "raw.csv", first_line=first_line)


def mapped(
    raw: MemoryTable,
    columns: dict[str, Column],
    encoder: Encoder | None = None,
    axis: str = "rotary",
) -> Log:
    return example_logs.mapped(raw, bench(columns, encoder, axis=axis))


def test_counts_become_radians_in_the_encoders_direction():
    log = mapped(table({"encoder": [0, 1, -3]}), POSITION)
    assert log.main.signals["position"] == pytest.approx([0.0, STEP, -3 * STEP])
    assert log.main.units == {"position": "rad"}
    log = mapped(
        table({"encoder": [0, 1, -3]}), POSITION, Encoder(counts_per_revolution=100, direction=-1)
    )
    assert log.main.signals["position"] == pytest.approx([0.0, -STEP, 3 * STEP])


def test_linear_counts_become_metres():
    log = mapped(table({"encoder": [0, 2]}), POSITION, axis="linear")
    assert log.main.signals["position"] == pytest.approx([0.0, 0.02])
    assert log.main.units == {"position": "m"}


@given(
    bits=st.integers(8, 32),
    signed=st.booleans(),
    start=st.integers(-(2**31), 2**31),
    steps=st.lists(st.integers(-127, 127), min_size=1, max_size=50),
)
def test_a_wrapped_counter_moves_as_the_true_count(
    bits: int, signed: bool, start: int, steps: list[int]
):
    """Reference: the true count itself, up to the whole turns of the counter before the log
    began."""
    true = np.cumsum([start, *steps])
    seen = (true + (2 ** (bits - 1) if signed else 0)) % 2**bits - (
        2 ** (bits - 1) if signed else 0
    )
    log = mapped(
        table({"encoder": seen.tolist()}),
        POSITION,
        Encoder(counts_per_revolution=100, wrap_bits=bits),
    )
    found = log.main.signals["position"] / STEP
    assert np.abs(found - (true - true[0] + seen[0])).max() < 1e-5


def test_a_count_beyond_the_counter_is_refused():
    encoder = Encoder(counts_per_revolution=100, wrap_bits=8)
    with pytest.raises(
        LogError,
        match=r"raw.csv:7: column 'encoder': found 300; allowed: a counter of encoder.wrap_bits = "
        r"8",
    ):
        mapped(table({"encoder": [0, 300]}, first_line=6), POSITION, encoder)


def test_scale_and_offset_come_before_the_unit():
    columns = {"position": Column("p", "deg", scale=2.0, offset=10.0), "current": Column(2, "mA")}
    log = mapped(table({"p": [0.0, 40.0], "i": [1000.0, -500.0]}), columns)
    assert log.main.signals["position"] == pytest.approx(np.radians([10.0, 90.0]))
    assert log.main.signals["current"] == pytest.approx([1.0, -0.5])


def test_effort_is_derived_only_where_it_is_not_measured():
    raw = table({"encoder": [0, 1], "i": [1.0, 2.0], "m": [7.0, 8.0]})
    columns = {**POSITION, "current": Column("i", "A")}
    assert mapped(raw, columns).main.signals["effort"].tolist() == [2.0, 4.0]
    assert mapped(raw, columns).main.units["effort"] == "N m"
    assert mapped(raw, {**columns, "effort": Column("m", "N m")}).main.signals[
        "effort"
    ].tolist() == [7.0, 8.0]
    assert "effort" not in mapped(raw, POSITION).main.signals


@pytest.mark.parametrize(
    ("given", "unit"), [("A", "A"), ("ampere", "A"), ("mA", "milliampere"), (None, "A")]
)
def test_a_unit_in_the_file_that_agrees_passes(given: str | None, unit: str):
    raw = table({"encoder": [0, 1], "i": [1.0, 2.0]}, {"i": given})
    assert "current" in mapped(raw, {**POSITION, "current": Column("i", unit)}).main.signals


@pytest.mark.parametrize(("given", "unit"), [("mA", "A"), ("V", "A"), ("count", "A"), ("foo", "A")])
def test_a_unit_in_the_file_that_contradicts_the_bench_is_refused(given: str, unit: str):
    raw = table({"encoder": [0, 1], "i": [1.0, 2.0]}, {"i": given})
    with pytest.raises(
        LogError,
        match=rf"column 'i' is in '{given}', but columns.current.unit of bench 'rig' is '{unit}'",
    ):
        mapped(raw, {**POSITION, "current": Column("i", unit)})
    probe = Column(
        "i", unit, scale=100.0
    )  # a current probe: volts in the file, amperes after the scale
    assert mapped(raw, {**POSITION, "current": probe}).main.signals["current"].tolist() == [
        100.0,
        200.0,
    ]


def test_a_column_in_per_cent_needs_the_full_scale():
    raw = table({"encoder": [0, 50]}, {"encoder": "%"})
    with pytest.raises(LogError, match=r"write scale: \(full scale in deg\) / 100"):
        mapped(raw, {"position": Column("encoder", "deg")})
    log = mapped(raw, {"position": Column("encoder", "deg", scale=0.9)})
    assert log.main.signals["position"] == pytest.approx([0.0, math.pi / 4.0])


def test_a_position_in_radians_is_no_count():
    with pytest.raises(LogError, match="column 'encoder' is in 'rad'"):
        mapped(table({"encoder": [0, 1]}, {"encoder": "rad"}), POSITION)


def test_a_unit_of_another_dimension_is_refused():
    with pytest.raises(
        LogError,
        match=r"columns.position.unit of bench 'rig': unit 'mm' does not measure position of a "
        r"rotary axis",
    ):
        mapped(table({"encoder": [0, 1]}), {"position": Column("encoder", "mm")})


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused_where_it_stands(bad: float):
    with pytest.raises(
        LogError, match=r"raw.csv:4: column 'encoder': found -?(nan|inf); allowed: a finite number"
    ):
        mapped(table({"encoder": [0, 1, bad]}, first_line=2), POSITION)
    with pytest.raises(LogError, match=r"raw\.csv: sample 3, column 'encoder'"):
        mapped(table({"encoder": [0, 1, bad]}), POSITION)


def test_without_a_time_column_the_bench_gives_the_rate():
    assert mapped(table({"encoder": [0, 1, 2]}), POSITION).main.time == pytest.approx(
        [0.0, 0.001, 0.002]
    )


def test_time_in_other_units():
    log = mapped(
        table({"t": [5.0, 6.0, 7.0], "encoder": [0, 1, 2]}), {**POSITION, "time": Column("t", "ms")}
    )
    assert log.main.time == pytest.approx([0.005, 0.006, 0.007])


@pytest.mark.parametrize("again", [0.001, 0.0005])
def test_time_that_does_not_increase_names_the_line(again: float):
    with pytest.raises(
        LogError, match=rf"raw.csv:4: time does not increase: {again:g} s after 0.001 s"
    ):
        mapped(table({"t": [0, 0.001, again, 0.003], "encoder": [0, 1, 2, 3]}, first_line=2), TIMED)


def test_another_rate_warns_and_a_very_different_one_is_refused():
    def at(period: float) -> Log:
        return mapped(table({"t": [k * period for k in range(5)], "encoder": [0] * 5}), TIMED)

    assert at(0.001).warnings == ()
    assert "the period is 0.0011 s" in at(0.0011).warnings[0]
    assert "the period is 0.01 s" in at(0.01).warnings[0]
    for period in (0.00003, 0.04, 1.0):
        with pytest.raises(
            LogError,
            match=r"sample_period_s in bench.yaml is 0.001 s; allowed: a factor of at most 30",
        ):
            at(period)


def test_gaps_are_counted():
    log = mapped(
        table({"t": [0, 0.001, 0.002, 0.01, 0.011, 0.02, 0.021, 0.022], "encoder": [0] * 8}), TIMED
    )
    assert log.warnings == ("2 gaps in time, the longest 0.009 s",)


def test_columns_of_different_length_are_refused():
    with pytest.raises(LogError, match="'t' has 2 samples, 'encoder' has 3"):
        mapped(table({"t": [0, 1], "encoder": [0, 1, 2]}), TIMED)


def test_one_row_is_no_log():
    with pytest.raises(LogError, match="has 1 row"):
        mapped(table({"encoder": [0]}), POSITION)


def test_a_bench_that_maps_nothing_is_refused():
    for columns in ({}, {"time": Column("encoder", "s")}):
        with pytest.raises(LogError, match="bench 'rig' maps no channel"):
            mapped(table({"encoder": [0, 1]}), columns)


def test_the_log_remembers_its_columns():
    log = mapped(table({"t": [0, 0.001], "encoder": [0, 1]}), {"time": Column(1, "s"), **POSITION})
    assert log.metadata["columns"] == {"/axis.time": "t [s]", "/axis.position": "encoder [count]"}
    assert log.metadata["log"] == {"kind": "measured", "bench": "rig", "axis": "rotary"}


@pytest.mark.parametrize(
    ("unit", "start", "period", "told"),
    [
        ("s", 1.7e9, 1e-4, True),
        ("ns", 1.7e18, 1e5, True),
        ("s", 1.7e9, 1e-3, False),
        ("s", 1e5, 1e-4, False),
    ],
)
def test_times_that_a_double_rounds_are_told(unit: str, start: float, period: float, told: bool):
    """Times since 1970: what is read is within twice the rounding that is told of what was
    meant."""
    meant = [
        Decimal(start)
        + Decimal(period) * k
        + Decimal("1e-7") / (Decimal("1e-9") if unit == "ns" else 1)
        for k in range(50)
    ]
    seconds = [time * (Decimal("1e-9") if unit == "ns" else 1) for time in meant]
    log = example_logs.mapped(
        table({"t": [float(time) for time in meant], "encoder": [0.0] * 50}),
        bench(
            POSITION | {"time": Column("t", unit)},
            sample_period_s=float(seconds[1] - seconds[0]),
        ),
    )
    if not told:
        assert log.warnings == ()
        return
    (warning,) = log.warnings
    rounding = float(re.findall(r"resolves only (\S+) s", warning)[0])
    assert 1e-7 < rounding < 3e-7
    off = [
        abs(float(Decimal(found) - one))
        for found, one in zip(log.main.time.tolist(), seconds, strict=True)
    ]
    assert 1e-9 < max(off) <= 2.0 * rounding  # the number itself, and its conversion to ns and back


@pytest.mark.parametrize(
    ("unit", "boiling", "freezing"),
    [("degC", 100.0, 0.0), ("K", 373.15, 273.15), ("degF", 212.0, 32.0)],
)
def test_a_temperature_is_in_degrees_celsius(unit: str, boiling: float, freezing: float):
    """Water at 1 bar: a unit of temperature has a factor and another zero."""
    columns = {**POSITION, "temperature": Column("motor", unit)}
    raw = {"encoder": [0.0, 1.0], "motor": [boiling, freezing]}
    for declared in (None, unit):
        log = mapped(table(raw, {"motor": declared}), columns)
        assert log.main.signals["temperature"] == pytest.approx([100.0, 0.0], abs=1e-9)
        assert log.main.units["temperature"] == "degC"
    with pytest.raises(LogError, match=f"is in 'degRe', but .* is '{unit}'"):
        mapped(table(raw, {"motor": "degRe"}), columns)


def test_a_kelvin_is_no_degree_celsius():
    columns = {**POSITION, "temperature": Column("motor", "degC")}
    with pytest.raises(LogError, match="is in 'K'"):
        mapped(table({"encoder": [0, 1], "motor": [300, 300]}, {"motor": "K"}), columns)
    with pytest.raises(LogError, match="does not measure temperature; allowed: degC, K or degF"):
        mapped(
            table({"encoder": [0, 1], "motor": [300, 300]}),
            {**POSITION, "temperature": Column("motor", "A")},
        )


def test_a_temperature_that_is_no_number_is_refused_with_its_row():
    columns = {**POSITION, "temperature": Column("motor", "degC")}
    with pytest.raises(LogError, match="column 'motor': found nan; allowed: a finite number"):
        mapped(table({"encoder": [0, 1], "motor": [30, math.nan]}), columns)
