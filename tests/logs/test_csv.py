"""Raw text: how each layout is found and read, and how each kind of bad file is told."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from frictool.documents.bench import Layout
from frictool.errors import LogError
from frictool.logs.raw_table import BLOCK_ROWS, DataLoss
from frictool.logs.text import row_batches as text_batches_module
from frictool.logs.text import text_encoding as text_bytes_module
from frictool.logs.text.csv_format import NO_END, CsvTable, sniff, tables
from tests.logs.tables import columns, times

GOOD = "time [s],encoder [count],current [A]\n0.000,40,-0.080\n0.001,41,0.5\n0.002,42,1e-3\n"


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "raw.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def opened(folder: Path, text: str | bytes, layout: Layout | None = None) -> CsvTable:
    return tables(written(folder, text), layout)[0]


def read(
    folder: Path,
    text: str | bytes,
    wanted: Sequence[str | int] | None = None,
    layout: Layout | None = None,
) -> dict[str, list[float]]:
    return {
        name: values.tolist()
        for name, values in columns(opened(folder, text, layout), wanted).items()
    }


def test_names_units_and_numbers(tmp_path: Path):
    table = opened(tmp_path, GOOD)
    assert table.names == ("time", "encoder", "current")
    assert table.units == {"time": "s", "encoder": "count", "current": "A"}
    assert read(tmp_path, GOOD) == {
        "time": [0.0, 0.001, 0.002],
        "encoder": [40, 41, 42],
        "current": [-0.08, 0.5, 0.001],
    }
    assert (
        table.description
        == "UTF-8, comma between cells, decimal point, header in line 1, numbers from line 2"
    )


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "  "])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "latin-1"])
@pytest.mark.parametrize("quote", ["", '"'])
@pytest.mark.parametrize("mark", [".", ","])
def test_dialects(tmp_path: Path, delimiter: str, end: str, encoding: str, quote: str, mark: str):
    if mark == delimiter:
        mark = "."
    good = GOOD.replace("time [s]", f"{quote}Zeitµ [s]{quote}")
    text = end + good.replace(",", delimiter).replace(".", mark).replace("\n", end) + end
    table = opened(tmp_path, text.encode(encoding))
    assert table.names == ("Zeitµ", "encoder", "current")
    assert columns(table)["current"].tolist() == [-0.08, 0.5, 0.001]
    assert [table.line(row) for row in range(3)] == [3, 4, 5]
    assert sniff(text.encode(encoding)[:4096], tmp_path)


LAYOUTS = {
    "metadata and units in a second line": (
        "Timestamp,2020-03-16 17:04:51,Timestamp,2020-03-16 "
        "17:04:51\nInterval,0.0005,Interval,0.0005\n"
        'Channel name,"Force",Channel name,"Input '
        '1"\nUnit,"V",Unit,"V"\n0,-0.1,0,3\n0.0005,-0.2,0.0005,4\n',
        ("Channel name (column 1)", "Force", "Channel name (column 3)", "Input 1"),
        (None, "V", None, "V"),
        (3, 4, 5),
    ),
    "a drive's trace: a title, names of columns, names of signals": (
        "Axis1\nNumber of sampling data,3\nSampling time interval(ms),0.667\nTime,Analog 1,Analog "
        "2,Analog 3\n"
        "ms,Servo motor speed,Torque,Not "
        "selected\n0.0,0.0,-1.0,0\n0.667,1.0,-1.0,0\n1.333,2.0,-0.8,0\n",
        ("Time", "Servo motor speed", "Torque", "Not selected"),
        ("ms", None, None, None),
        (4, 5, 6),
    ),
    "an oscilloscope's increment": (
        "X,CH1,CH2,Start,Increment,\nSequence,VOLT,VOLT,-3.0e-3,1e-6\n0,1.2,0.4,,\n1,1.3,0.4,,\n"
        "2,1.3,0.4,,\n",
        ("Sequence", "CH1", "CH2", "Start", "Increment"),
        (None, "V", "V", None, None),
        (1, 2, 3),
    ),
    "an oscilloscope's increment, rows without its columns": (
        "X,CH1,Start,Increment,\nSequence,Volt,-3.0e-3,1e-6\n0,1.2,\n1,1.3,\n2,1.3,\n",
        ("Sequence", "CH1", "Start"),
        (None, "V", None),
        (1, 2, 3),
    ),
    "an oscilloscope's numbered channels": (
        "x-axis,1,2\nsecond,Volt,Volt\n-0.1,1,2\n0.1,3,4\n",
        ("x-axis", "1", "2"),
        ("s", "V", "V"),
        (1, 2, 3),
    ),
    "metadata as wide as the rows": (
        "Model,MSO4034\nSample Interval,1e-4,\nProbe Attenuation,10,10\nVertical Units,V,V\n\n"
        "TIME,CH1,CH2\n" + "".join(f"{k}e-4,{k % 5},1\n" for k in range(12)),
        ("TIME", "CH1", "CH2"),
        (None, None, None),
        (6, 0, 7),
    ),
    "numbers beside metadata": (
        "Record Length,3,,0.0,0.02,\nSample "
        "Interval,4e-7,,4e-7,0.04,\n,,,8e-7,0.02,\n,,,12e-7,0.02,\n,,,16e-7,0.02,\n",
        ("Time", "samples", "6"),
        (None,) * 6,
        (0, 0, 1),
    ),
    "a comment's sign": ("# t [s]  x [m]\n0 1\n1 2\n", ("t", "x"), ("s", "m"), (1, 0, 2)),
    "units in parentheses and after a slash": (
        "t (ms);n (1/min);F/kN;torque (filtered)\n0;1;2;3\n1;1;2;3\n",
        ("t", "n", "F", "torque (filtered)"),
        ("ms", "rpm", "kN", None),
        (1, 0, 2),
    ),
    "names that are units": ("s,V,A\n0,1,2\n1,2,3\n", ("s", "V", "A"), (None,) * 3, (1, 0, 2)),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_layouts_are_found(tmp_path: Path, name: str):
    text, names, units, (header, unit, first) = LAYOUTS[name]
    table = opened(tmp_path, text)
    assert table.names == names
    assert tuple(table.units.values()) == units
    assert (table.layout.header_line, table.layout.unit_line, table.layout.first_line) == (
        header,
        unit,
        first,
    )
    rows = columns(table, names[:2])
    assert all(
        np.isfinite(values).all() and values.size == len(text.splitlines()) - first + 1
        for values in rows.values()
    )


def test_columns_that_are_not_asked_for_may_be_text_or_blank(tmp_path: Path):
    text = "t,state,x,y\n0,idle,1,\n1,run,2,7\n"
    assert read(tmp_path, text, ["x", 1]) == {"x": [1, 2], "t": [0, 1]}
    found = (
        r"raw.csv:2: column 'state': found 'idle'; allowed: a number; `ingest "
        r"--salvage` keeps the readable part$"
    )
    with pytest.raises(LogError, match=found):
        read(tmp_path, text)


@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_a_file_without_a_header_has_numbers_for_names(tmp_path: Path, mark: str):
    table = opened(tmp_path, mark + "0,5\n\n1,6\n")
    assert table.names == ("1", "2")
    assert columns(table, [table.find(2) or ""])["2"].tolist() == [5, 6]
    assert [table.line(row) for row in range(2)] == [1, 3]
    assert read(tmp_path, "Run 7 of the rig\n0,5\n1,6\n") == {"1": [0, 1], "2": [5, 6]}


def test_one_column_and_one_row(tmp_path: Path):
    assert read(tmp_path, "x\n1\n2\n") == {"x": [1, 2]}
    assert read(tmp_path, "x,y\n1,2\n") == {"x": [1], "y": [2]}


def test_columns_of_one_name_are_told_apart(tmp_path: Path):
    text = "t,V,V,\n0,1,2,3\n"
    assert opened(tmp_path, text).names == ("t", "V (column 2)", "V (column 3)", "(column 4)")
    assert read(tmp_path, text, ["V (column 3)"]) == {"V (column 3)": [2]}


def test_rows_may_end_in_a_delimiter_and_the_header_not(tmp_path: Path):
    assert read(tmp_path, "t,x\n0,1,\n1,2,\n") == {"t": [0, 1], "x": [1, 2]}
    assert read(tmp_path, "t,x,\n0,1\n1,2\n") == {"t": [0, 1], "x": [1, 2]}


def test_rows_dated_by_iso_8601_are_exact(tmp_path: Path):
    start = 1584378291123456789
    text = "clock;x\n" + "".join(f"2020-03-16T17:04:51.{123456789 + k}Z;{k},5\n" for k in range(4))
    table = opened(tmp_path, text)
    assert table.clock == "clock"
    assert table.units["clock"] == "iso8601"
    assert times(table, ["x"]).tolist() == [start + k for k in range(4)]
    assert columns(table, ["x"])["x"].tolist() == [0.5, 1.5, 2.5, 3.5]
    with pytest.raises(
        LogError, match=r":3: column 'clock': found 'late'; allowed: a date and time such as 2026"
    ):
        times(opened(tmp_path, text.replace("2020-03-16T17:04:51.123456790Z", "late")))


@pytest.mark.parametrize(
    ("text", "clock", "start_ns", "period_ns"),
    [
        ("Interval,0.0005\n\nx,y\n1,2\n3,4\n5,6\n", "Interval", 0, 500_000),
        (
            "Sampling time interval(ms),0.667\nx,y\n1,2\n3,4\n5,6\n",
            "Sampling time interval",
            0,
            667_000,
        ),
        ("Sample rate:,2,kHz\nx,y,z\n1,2,3\n3,4,5\n5,6,7\n", "Sample rate", 0, 500_000),
        (
            "X,CH1,Start,Increment\nSequence,V,-3.0e-3,1e-6\n0,1,,\n1,2,,\n2,3,,\n",
            "increment",
            -3_000_000,
            1000,
        ),
    ],
)
def test_an_interval_above_the_numbers_dates_them(
    tmp_path: Path, text: str, clock: str, start_ns: int, period_ns: int
):
    table = opened(tmp_path, text)
    assert table.clock == clock
    assert times(table).tolist() == [start_ns + k * period_ns for k in range(3)]
    given = opened(tmp_path, text, Layout(period_s=0.25, start_s=-1.0))
    assert given.clock == "layout.period_s"
    assert times(given).tolist() == [-(10**9) + k * 250_000_000 for k in range(3)]


def test_an_interval_that_is_none_dates_nothing(tmp_path: Path):
    for interval in ("0", "-1", "inf", "nan", "1e999"):
        assert opened(tmp_path, f"Interval,{interval}\nx,y\n1,2\n3,4\n5,6\n").clock is None
    with pytest.raises(
        LogError, match=r"Interval results in times beyond 9e\+09 s; check this value"
    ):
        times(opened(tmp_path, "Interval,1e300\nx,y\n1,2\n3,4\n5,6\n"))


def test_the_layout_of_the_bench_is_not_looked_for(tmp_path: Path):
    text = "1;2\n3,25;4,5\n5;6\n"
    assert read(tmp_path, text) == {"1": [1, 3.25, 5], "2": [2, 4.5, 6]}
    assert read(tmp_path, text, layout=Layout(header_line=1)) == {"1": [3.25, 5], "2": [4.5, 6]}
    assert read(tmp_path, "a,b\ns,mm\n0,1\n1,2\n", layout=Layout(header_line=2)) == {
        "s": [0, 1],
        "mm": [1, 2],
    }
    assert read(tmp_path, "a,b\ns,mm\n0,1\n1,2\n", layout=Layout(header_line=0)) == {
        "1": [0, 1],
        "2": [1, 2],
    }
    table = opened(tmp_path, "a,b\nx,y\n0,1\n1,2\n", Layout(header_line=1, unit_line=2))
    assert (table.names, table.layout.header_line) == (("x", "y"), 1)
    text = "x;y\n1.234,5;1\n2.000;2\n"
    assert read(tmp_path, text, layout=Layout(thousands="point", decimal="comma")) == {
        "x": [1234.5, 2000],
        "y": [1, 2],
    }
    assert read(tmp_path, "x\ty\n1 234,5\t1\n2,0\t2\n", layout=Layout(thousands="blank")) == {
        "x": [1234.5, 2],
        "y": [1, 2],
    }
    assert read(tmp_path, "x,y\n0,1", layout=Layout(whole=True)) == {"x": [0], "y": [1]}
    with pytest.raises(LogError, match=r"has no row of numbers after line 4, the last header line"):
        opened(tmp_path, GOOD, Layout(header_line=4))
    with pytest.raises(LogError, match=r"layout.first_line is 9"):
        opened(tmp_path, GOOD, Layout(first_line=9))


BAD = {
    "ragged, too few": (
        GOOD + "0.003,43\n",
        ":5: has 2 cells, but the header in line 1 has 3; is the file cut off here",
    ),
    "cut in the last row": (
        GOOD + "0.003,4",
        ":5: has 2 cells, but the header in line 1 has 3; is the file cut off here",
    ),
    "ragged, too many": (
        GOOD.replace("0.5", "0.5,7"),
        ":3: has 4 cells, but the header in line 1 has 3",
    ),
    "text": (GOOD.replace("41", "n/a"), ":3: column 'encoder': found 'n/a'; allowed: a number"),
    "blank cell": (GOOD.replace("41", ""), ":3: column 'encoder': found an empty cell"),
    "decimal comma": (
        GOOD.replace(",", ";").replace("0.5", "0,5"),
        ":3: column 'current': found '0,5'; allowed: a number with a decimal point",
    ),
    "decimal point": (
        GOOD.replace(",", ";").replace(".", ",").replace("0,5", "0.5"),
        ":3: column 'current': found '0.5'; allowed: a number with a decimal comma",
    ),
    "underscore": (GOOD.replace("41", "4_1"), ":3: column 'encoder': found '4_1'"),
    "not a number of ASCII": (
        GOOD.replace("41", "\u0664\u0661"),
        ":3: column 'encoder': found '\u0664\u0661'",
    ),
    "header only": ("time [s],encoder,current\n", "has a header, but no rows"),
    "blank": ("\n\n  \n", "is empty"),
    "prose": (
        "the rig\nwas off\n",
        "has no row of numbers in its first 3 lines; if a table begins later",
    ),
    "not UTF-8": (GOOD.encode().replace(b"0.5", b"\xb5"), ":3: column 'current': found 'µ'"),
    "NUL": (GOOD.encode().replace(b"0.5", b"0\0005"), r":3: column 'current': found '0\\x005'"),
    "long first line": ("x" * 1_000_001, ":1: is longer than 1000000 characters"),
    "an open quote": (
        GOOD + '0.003,43,"' + "0,1,2\n" * 3_000_000,
        ":5: is longer than 16 MB; is a quote left open",
    ),
    "a second header": (GOOD + GOOD, ":5: column 'encoder': found 'encoder \\[count\\]'"),
}


@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("wanted", [None, ["encoder", "current"]])
def test_bad_files_name_line_column_and_what_was_found(
    tmp_path: Path, name: str, wanted: list[str] | None
):
    text, message = BAD[name]
    if name == "a second header" and wanted is None:
        message = ":5: column 'time': found 'time"
    with pytest.raises(LogError, match=message) as caught:
        read(tmp_path, text, wanted)
    assert "\n" not in str(caught.value)


def test_rows_that_are_ragged_beyond_the_columns_asked_for(tmp_path: Path):
    for row in ("1,2\n", "1,2,3,4\n"):
        with pytest.raises(LogError, match=r":3: has \d cells, but the header in line 1 has 3"):
            read(tmp_path, "a,b,c\n0,0,0\n" + row, ["a", "b"])


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_file_cut_anywhere_in_its_last_line_is_refused(tmp_path: Path, end: str):
    """Wherever it is cut, also where what is left of the last number looks like a whole one."""
    rows = "t,x\n\n" + "".join(f"{k / 1000:.3f},{k / 7:.3f}\n" for k in range(8))
    text = rows.replace("\n", end)
    last = text.rstrip().rindex("\n") + 1
    for kept in range(last + 1, len(text) - len(end) + 1):
        with pytest.raises(LogError, match=r"raw\.csv:10: ") as caught:
            read(tmp_path, text[:kept])
        if "," in text[last : kept - 1]:
            assert str(caught.value).endswith(f":10: {NO_END}")
    assert len(read(tmp_path, text)["x"]) == 8


def test_columns_before_the_last_do_not_hide_a_cut(tmp_path: Path):
    for wanted in (None, ["t"]):
        with pytest.raises(
            LogError,
            match=":2: the last line has no line end: the file may be cut off; if it is complete, "
            "add a line end",
        ):
            read(tmp_path, "t,x\n0,1", wanted)


def test_salvage_leaves_rows_out_and_cells_nan(tmp_path: Path):
    table = opened(tmp_path, "t,x\n0,1\n1,off\n2\n3,4,5\n4,\n5,6\n6,7")
    losses: list[DataLoss] = []
    blocks = [block for block, _ in table.blocks(["t", "x"], losses)]
    assert [block.first_row for block in blocks] == [0, 4]
    assert np.concatenate([block.columns["t"] for block in blocks]).tolist() == [0, 1, 4, 5]
    assert np.array_equal(
        np.concatenate([block.columns["x"] for block in blocks]),
        [1, np.nan, np.nan, 6],
        equal_nan=True,
    )
    assert [(loss.channels, loss.samples) for loss in losses] == [((), 1)] * 3
    assert [loss.reason.partition(";")[0].partition(":")[0] for loss in losses] == [
        "line 4",
        "line 5",
        "line 8",
    ]


@given(
    rows=st.lists(
        st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3), min_size=1, max_size=20
    ),
    delimiter=st.sampled_from(",;\t "),
    wanted=st.sampled_from([None, ["b"], ["c", "a"]]),
)
def test_what_repr_writes_is_read_bit_for_bit(
    rows: list[tuple[float, ...]], delimiter: str, wanted: list[str | int] | None
):
    text = "\n".join(delimiter.join(map(repr, row)) for row in rows)
    with tempfile.TemporaryDirectory() as folder:
        found = columns(opened(Path(folder), delimiter.join("abc") + "\n" + text + "\n"), wanted)
    expected: dict[str, NDArray[np.float64]] = dict(zip("abc", np.array(rows).T, strict=True))
    assert set(found) == set(wanted or "abc")
    for name, values in found.items():
        assert values.tobytes() == expected[name].tobytes()


def test_blocks_and_pieces_change_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """However small the pieces in which the file is read, and the blocks in which it is given."""
    rng = np.random.default_rng(3)
    text = "t [s];x\n" + "".join(
        f'{k}; "{x:.6f}" \r\n' + "\n" * (k % 7 == 0) for k, x in enumerate(rng.normal(size=300))
    )
    whole = columns(opened(tmp_path, text))
    lines = [opened(tmp_path, text).line(row) for row in (0, 150, 299)]
    for piece, rows in ((7, 11), (64, 300), (5000, 1)):
        monkeypatch.setattr(text_bytes_module, "READ_BYTES", piece)
        monkeypatch.setattr(text_batches_module, "BLOCK_ROWS", rows)
        table = opened(tmp_path, text)
        assert {name: values.tobytes() for name, values in columns(table).items()} == {
            n: v.tobytes() for n, v in whole.items()
        }
        assert [table.line(row) for row in (0, 150, 299)] == lines
        assert max(len(block.columns["x"]) for block, _ in table.blocks(["x"])) <= rows


@pytest.mark.parametrize("start", [86_390.0, 54_000.0, 86_400.0 - 0.25 * BLOCK_ROWS])
def test_times_of_day_go_on_over_midnight(tmp_path: Path, start: float):
    seconds = start + 0.25 * np.arange(1.5 * BLOCK_ROWS)
    rows = [
        f"{int(t // 3600) % 24:02d}:{int(t // 60) % 60:02d}:{t % 60:06.3f},{k}\n"
        for k, t in enumerate(seconds.tolist())
    ]
    assert np.array_equal(
        times(opened(tmp_path, "clock,x\n" + "".join(rows)), ["x"]),
        np.rint(1e9 * seconds).astype(np.int64),
    )


def test_a_time_of_day_that_is_wrong_moves_no_other(tmp_path: Path):
    seconds = 54_000.0 + np.arange(200)
    rows = [f"15:{k // 60:02d}:{k % 60:02d},{k}\n" for k in range(200)]
    rows[100] = "00:00:00,100\n"
    found = times(opened(tmp_path, "clock,x\n" + "".join(rows)), ["x"])
    assert np.flatnonzero(found != np.rint(1e9 * seconds)).tolist() == [100]


def test_a_date_that_is_not_read_and_a_missing_header_are_explained(tmp_path: Path):
    short = "when,x\n31.01.26 12:00:00,1\n31.01.26 12:00:01,2\n"
    with pytest.raises(
        LogError,
        match=r"column 'when': found '31.01.26 12:00:00'; allowed: a number or a date and time "
        r"such as 2026",
    ):
        read(tmp_path, short, ["when"])
    with pytest.raises(
        LogError,
        match=r"has no column 'x'; found: 1, 2 \(the file has no header; columns are "
        r"numbered from 1\)",
    ):
        read(tmp_path, "0,1\n1,2\n", ["x"])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("clock,x\n2026-01-31T12:00:01,250\n2026-01-31T12:00:02,251\n", [1.0, 2.0]),
        ("clock,x\n2026-01-31 12:00:01.5,250\n2026-01-31 12:00:02.5,251\n", [1.5, 2.5]),
        ('clock,x\n"2026-01-31T12:00:01,5",250\n"2026-01-31T12:00:02,5",251\n', [1.5, 2.5]),
        ("clock;x\n2026-01-31T12:00:01,5;250\n2026-01-31T12:00:02,5;251\n", [1.5, 2.5]),
    ],
    ids=["whole seconds", "point", "comma in quotes", "comma"],
)
def test_a_comma_behind_a_stamp_ends_its_cell_where_it_does_so_everywhere(
    tmp_path: Path, text: str, expected: list[float]
):
    table = opened(tmp_path, text)
    assert ((times(table, ["x"]) - 1_769_860_800 * 10**9) / 1e9).tolist() == expected
    assert columns(table, ["x"])["x"].tolist() == [250.0, 251.0]


def test_a_sign_for_thousands_is_named(tmp_path: Path):
    with pytest.raises(
        LogError,
        match=r"found '1\.000,5'; allowed: a number; .* layout\.thousands: point in bench\.yaml",
    ):
        read(tmp_path, "x;y\n1,5;2,5\n3,5;4,5\n1.000,5;2,5\n")
