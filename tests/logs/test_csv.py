"""Raw CSV: what is read, and how each kind of bad file is told."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.errors import LogError
from frictool.logs.csv_format import NO_END, read_csv

GOOD = "time [s],encoder [count],current [A]\n0.000,40,-0.080\n0.001,41,0.5\n0.002,42,1e-3\n"


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "raw.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_names_units_and_numbers(tmp_path: Path):
    table = read_csv(written(tmp_path, GOOD))
    assert table.names == ("time", "encoder", "current")
    assert table.units == {"time": "s", "encoder": "count", "current": "A"}
    assert table.columns["time"].tolist() == [0.0, 0.001, 0.002]
    assert table.columns["encoder"].tolist() == [40, 41, 42]
    assert table.columns["current"].tolist() == [-0.08, 0.5, 0.001]


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("quote", ["", '"'])
def test_dialects(tmp_path: Path, delimiter: str, end: str, mark: str, quote: str):
    text = mark + end + GOOD.replace("time [s]", f"{quote}time [s]{quote}").replace(",", delimiter).replace("\n", end)
    table = read_csv(written(tmp_path, text + end))
    assert table.names == ("time", "encoder", "current")
    assert table.columns["current"].tolist() == [-0.08, 0.5, 0.001]
    assert [table.line(row) for row in range(3)] == [3, 4, 5]


def test_columns_that_are_not_asked_for_may_be_text(tmp_path: Path):
    path = written(tmp_path, "t,state,x\n0,idle,1\n1,run,2\n")
    assert read_csv(path, ["x", 1]).columns.keys() == {"x", "t"}
    assert read_csv(path, ["x", 1]).columns["x"].tolist() == [1, 2]
    with pytest.raises(LogError, match=r"raw.csv:2: column 'state': found 'idle'; allowed: a number$"):
        read_csv(path)


def test_a_file_without_a_header_has_numbers_for_names(tmp_path: Path):
    for mark in ("", "\ufeff"):
        table = read_csv(written(tmp_path, mark + "0,5\n\n1,6\n"), [2, 1])
        assert table.names == ("1", "2")
        assert table.columns["2"].tolist() == [5, 6]
        assert [table.line(row) for row in range(2)] == [1, 3]


def test_one_column_and_one_row(tmp_path: Path):
    assert read_csv(written(tmp_path, "x\n1\n2\n")).columns["x"].tolist() == [1, 2]
    assert {name: values.tolist() for name, values in read_csv(written(tmp_path, "x,y\n1,2\n")).columns.items()} == {"x": [1], "y": [2]}


def test_columns_of_one_name_are_told_apart(tmp_path: Path):
    path = written(tmp_path, "t,V,V,\n0,1,2,3\n")
    assert read_csv(path).names == ("t", "V (column 2)", "V (column 3)", "(column 4)")
    assert read_csv(path, [3]).columns["V (column 3)"].tolist() == [2]
    with pytest.raises(LogError, match=r"no column 'V'; found: t, V \(column 2\), V \(column 3\)"):
        read_csv(path, ["V"])


BAD = {
    "ragged, too few": (GOOD + "0.003,43\n", ":5: has 2 cells, the header has 3; is the file cut off here"),
    "cut in the last row": (GOOD + "0.003,4", ":5: has 2 cells, the header has 3; is the file cut off here"),
    "ragged, too many": (GOOD.replace("0.5", "0.5,7"), ":3: has 4 cells, the header has 3"),
    "text": (GOOD.replace("41", "n/a"), ":3: column 'encoder': found 'n/a'; allowed: a number"),
    "blank cell": (GOOD.replace("41", ""), ":3: column 'encoder': found an empty cell"),
    "decimal comma": (
        GOOD.replace(",", ";").replace("0.5", "0,5"),
        ":3: column 'current': found '0,5'; allowed: a number with a decimal point",
    ),
    "underscore": (GOOD.replace("41", "4_1"), ":3: column 'encoder': found '4_1'"),
    "header only": ("time [s],x\n", "has a header and no rows"),
    "blank": ("\n\n  \n", "is empty"),
    "not UTF-8": (GOOD.encode().replace(b"0.5", b"\xb5"), r"is not UTF-8 text \(byte 0xb5\)"),
    "long first line": ("x" * 1_000_001, "longer than 1000000 characters"),
    "spaces": (GOOD + "   \n", ":5: has 1 cells"),
}


@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("wanted", [None, ["encoder", "current"]])
def test_bad_files_name_line_column_and_what_was_found(tmp_path: Path, name: str, wanted: list[str] | None):
    text, message = BAD[name]
    if wanted and name == "header only":
        wanted = ["x"]
    with pytest.raises(LogError, match=message) as caught:
        read_csv(written(tmp_path, text), wanted)
    assert "\n" not in str(caught.value)


def test_rows_that_are_ragged_beyond_the_columns_asked_for(tmp_path: Path):
    for row in ("1,2\n", "1,2,3,4\n"):
        with pytest.raises(LogError, match=r":3: has \d cells, the header has 3"):
            read_csv(written(tmp_path, "a,b,c\n0,0,0\n" + row), ["a", "b"])


def test_a_missing_column_lists_what_there_is(tmp_path: Path):
    with pytest.raises(LogError, match=r"has no column 'curent' \(did you mean 'current'\?\); found: time, encoder, current"):
        read_csv(written(tmp_path, GOOD), ["curent"])
    with pytest.raises(LogError, match="has no column 4; it has 3"):
        read_csv(written(tmp_path, GOOD), [4])


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_file_cut_anywhere_in_its_last_line_is_refused(tmp_path: Path, end: str):
    """Wherever it is cut, also where what is left of the last number looks like a whole one."""
    rows = "t,x\n\n" + "".join(f"{k / 1000:.3f},{k / 7:.3f}\n" for k in range(8))
    text = rows.replace("\n", end)
    last = text.rstrip().rindex("\n") + 1
    for kept in range(last + 1, len(text) - len(end) + 1):
        with pytest.raises(LogError, match=r"raw\.csv:10: ") as caught:
            read_csv(written(tmp_path, text[:kept]))
        if "," in text[last : kept - 1]:
            assert str(caught.value).endswith(f":10: {NO_END}")
    assert read_csv(written(tmp_path, text)).columns["x"].size == 8


@pytest.mark.parametrize("wanted", [None, ["t"]])
def test_columns_before_the_last_do_not_hide_a_cut(tmp_path: Path, wanted: list[str | int] | None):
    with pytest.raises(LogError, match=":2: the last line has no line end: the file may be cut; add a line end if it is whole"):
        read_csv(written(tmp_path, "t,x\n0,1"), wanted)


@settings(max_examples=60)
@given(
    rows=st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3), min_size=1, max_size=20),
    delimiter=st.sampled_from(",;\t"),
    wanted=st.sampled_from([None, ["b"], [3, "a"]]),
)
def test_what_repr_writes_is_read_bit_for_bit(rows: list[tuple[float, ...]], delimiter: str, wanted: list[str | int] | None):
    text = "\n".join(delimiter.join(map(repr, row)) for row in rows)
    with tempfile.TemporaryDirectory() as folder:
        table = read_csv(written(Path(folder), delimiter.join("abc") + "\n" + text + "\n"), wanted)
    expected = dict(zip("abc", np.array(rows).T, strict=True))
    for name, values in table.columns.items():
        assert np.array_equal(values, expected[name])
    assert set(table.columns) == (set("abc") if wanted is None else {"b"} if wanted == ["b"] else {"a", "c"})
