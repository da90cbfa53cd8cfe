"""Rows of text: Python's `csv` and `float`, cell by cell, are the reference; stamps are checked
against `datetime`."""

from __future__ import annotations

import csv
import io
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.logs.kernels.date_order import DAY_FIRST, MONTH_FIRST, YEAR_FIRST
from frictool.logs.kernels.decimal_parser import NO_NUMBER, NUMBER
from frictool.logs.kernels.iso8601 import scan_stamp
from frictool.logs.kernels.row_scanner import (
    CELL,
    CUT,
    ISSUE_FIELDS,
    PADDING,
    ROW,
    SKIP,
    STAMP,
    ScanProgress,
    read_rows,
)
from frictool.runtime.kernels import kernel

Issue = tuple[int, int, int, int]  # row, kind, line, column or cells


def padded(data: bytes) -> np.ndarray:
    text = np.full(len(data) + PADDING, 10, np.uint8)
    text[: len(data)] = np.frombuffer(data, np.uint8)
    return text


def read(
    data: bytes,
    slots: list[int],
    delimiter: str = ",",
    mark: str = ".",
    last: bool = True,
    rows: int = 64,
) -> tuple[ScanProgress, np.ndarray, np.ndarray, list[Issue]]:
    values = np.full((max([*slots, 0]) + 1, rows), -1.0)
    stamps = np.zeros(rows if STAMP in slots else 0, np.int64)
    issues = np.zeros((200, ISSUE_FIELDS), np.int64)
    progress = read_rows(
        padded(data),
        len(data),
        last,
        ord(delimiter),
        ord(mark),
        np.array(slots),
        values,
        stamps,
        issues,
        0,
        YEAR_FIRST,
    )
    listed = [tuple(int(field) for field in issue[:4]) for issue in issues[: progress.issues]]
    return progress, values[:, : progress.rows], stamps[: progress.rows], listed


def reference(
    text: str, slots: list[int], delimiter: str, mark: str
) -> tuple[list[list[float]], list[Issue]]:
    """Rows and issues of a text that ends in a line end, by Python's own reader."""
    rows: list[list[float]] = []
    issues: list[Issue] = []
    reader, line = (
        csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, skipinitialspace=True),
        0,
    )
    lines = text.splitlines()
    for cells in reader:
        start, line = line, reader.line_num
        if not lines[start].strip():
            continue
        values = [np.nan] * (max([*slots, 0]) + 1)
        found: list[Issue] = []
        for column, slot in enumerate(slots[: len(cells)]):
            cell = cells[column].strip()
            if slot == SKIP:
                continue
            try:
                if (mark == "," and "." in cell) or "_" in cell:
                    raise ValueError
                values[slot] = float(cell.replace(mark, "."))
            except ValueError:
                found.append((len(rows), CELL, start, column))
        if len(cells) < len(slots) or any(cell.strip() for cell in cells[len(slots) :]):
            found = [(len(rows), ROW, start, len(cells))]
        rows.append(values)
        issues += found
    return rows, issues


number = st.one_of(
    st.floats(-1e6, 1e6).map(lambda x: f"{x:.4f}"), st.integers(-(10**9), 10**9).map(str)
)


@given(
    rows=st.lists(
        st.lists(
            st.one_of(number, number, number, st.sampled_from(["", "x", "1_0", "4 5", "OVL"])),
            min_size=1,
            max_size=4,
        ),
        min_size=1,
        max_size=8,
    ),
    slots=st.sampled_from([[0, 1, 2], [0, SKIP, 1], [SKIP, 0], [1, 0, SKIP]]),
    delimiter=st.sampled_from(",;\t"),
    end=st.sampled_from(["\n", "\r\n"]),
    quote=st.booleans(),
    blanks=st.booleans(),
    comma=st.booleans(),
)
def test_rows_are_those_of_python(
    rows: list[list[str]],
    slots: list[int],
    delimiter: str,
    end: str,
    quote: bool,
    blanks: bool,
    comma: bool,
):
    mark = "," if comma and delimiter != "," else "."
    dress = ('"{}"' if quote else "{}").format
    cells = [
        [(" " if blanks else "") + dress(cell.replace(".", mark)) for cell in row] for row in rows
    ]
    text = end.join(delimiter.join(row) for row in cells) + end
    progress, values, _, issues = read(text.encode(), slots, delimiter, mark)
    expected, expected_issues = reference(text, slots, delimiter, mark)
    ragged = {row for row, kind, _, _ in expected_issues if kind == ROW}
    whole = [row for row in range(len(expected)) if row not in ragged]
    assert issues == expected_issues
    assert progress.used == len(text)
    assert progress.rows == len(expected)
    assert np.array_equal(
        values[:, whole].T, np.array(expected).reshape(-1, values.shape[0])[whole], equal_nan=True
    )


@given(text=st.text(alphabet='12.,;" \t\r\nx', max_size=60), cut=st.integers(0, 60))
def test_a_text_read_in_two_parts_is_the_text_read_at_once(text: str, cut: int):
    """Wherever it is parted, as long as each part is read as one that goes on."""
    data = (text + "\n").encode()
    cut = min(cut, len(data))
    whole, values, _, issues = read(data, [0, 1])
    first, before, _, some = read(data[:cut], [0, 1], last=False)
    second, after, _, others = read(data[first.used :], [0, 1])
    assert first.rows + second.rows == whole.rows
    assert first.lines + second.lines == whole.lines
    assert np.array_equal(np.hstack([before, after])[:, : whole.rows], values, equal_nan=True)
    assert (
        some
        + [(row + first.rows, kind, line + first.lines, what) for row, kind, line, what in others]
        == issues
    )


def test_blanks_between_cells_quotes_over_lines_and_a_last_line_without_end():
    assert read(b"  1   2\n3\t4  \n", [0, 1], " ")[1].tolist() == [[1, 3], [2, 4]]
    progress, values, _, issues = read(b'"a\nb",1\n"c ""d""",2\n', [SKIP, 0])
    assert (values.tolist(), issues, progress.lines, progress.last_line) == ([[1, 2]], [], 3, 2)
    assert read(b"1,2\n3,4", [0, 1])[3] == [(1, CUT, 1, 2)]
    assert read(b"1,2\n3", [0, 1])[3] == [(1, ROW, 1, 1), (1, CUT, 1, 1)]
    assert read(b"1,2,,\n1,2,3\n", [0, 1])[3] == [(1, ROW, 1, 3)]


def test_full_rows_and_full_issues_stop_before_the_next_row():
    progress, *_ = read(b"1,2\n3,4\n5,6\n", [0, 1], rows=2)
    assert (progress.rows, progress.used, progress.lines) == (2, 8, 2)
    progress, *_ = read(b"x,y\n" * 300, [0, 1], rows=300)
    assert progress.issues <= 200
    assert progress.used == 4 * progress.rows < 1200


@kernel
def stamp_of(text, order=YEAR_FIRST):
    return scan_stamp(text, 0, True, order)


@given(
    moment=st.datetimes(datetime(1678, 1, 1), datetime(2261, 12, 31)),
    digits=st.integers(0, 9),
    between=st.sampled_from("T t"),
    zone=st.sampled_from([("", 0), ("Z", 0), ("+05:30", 330), ("-0800", -480), ("+01", 60)]),
)
def test_a_stamp_is_that_of_datetime(
    moment: datetime, digits: int, between: str, zone: tuple[str, int]
):
    nanoseconds = moment.microsecond * 1000 + 789
    fraction = f".{nanoseconds:09d}"[: digits + 1] if digits else ""
    text = moment.strftime(f"%Y-%m-%d{between}%H:%M:%S").zfill(19) + fraction + zone[0]
    whole = moment.replace(microsecond=0, tzinfo=timezone(timedelta(minutes=zone[1])))
    seconds = (whole - datetime(1970, 1, 1, tzinfo=UTC)) // timedelta(seconds=1)
    below = int(fraction[1:].ljust(9, "0")) if digits else 0
    assert stamp_of(padded(text.encode())) == (seconds * 10**9 + below, len(text), NUMBER)


@given(
    moment=st.datetimes(datetime(1678, 1, 1), datetime(2261, 12, 31)),
    mark=st.sampled_from("./-"),
    half=st.sampled_from(["", " %p"]),
)
def test_a_date_is_read_in_each_order(moment: datetime, mark: str, half: str):
    moment = moment.replace(microsecond=0)
    clock = f"{'%I' if half else '%H'}:%M:%S{half}"
    seconds = (moment - datetime(1970, 1, 1)) // timedelta(seconds=1)
    year = f"{moment.year:04d}"
    forms = {
        YEAR_FIRST: f"{year}{mark}%m{mark}%d {clock}",
        DAY_FIRST: f"%d{mark}%m{mark}{year} {clock}",
        MONTH_FIRST: f"%m{mark}%d{mark}{year} {clock}",
    }
    for order, form in forms.items():
        text = moment.strftime(form)
        assert stamp_of(padded(text.encode()), order) == (seconds * 10**9, len(text), NUMBER)


@pytest.mark.parametrize(
    ("text", "order"),
    [
        ("31.01.2026 12:00:00", YEAR_FIRST),
        ("31.01.2026 12:00:00", MONTH_FIRST),
        ("01/31/2026 12:00:00", DAY_FIRST),
        ("31.01/2026 12:00:00", DAY_FIRST),
        ("29.02.2026 12:00", DAY_FIRST),
        ("31.01.26 12:00", DAY_FIRST),
        ("31.01.2026 13:00 PM", DAY_FIRST),
        ("31.01.2026", DAY_FIRST),
    ],
)
def test_what_is_no_date_in_this_order(text: str, order: int):
    _, end, status = stamp_of(padded(text.encode()), order)
    assert status == NO_NUMBER or end < len(text)


def test_a_time_of_day_stands_alone():
    assert stamp_of(padded(b"01:02:03,5\n"))[0] == (3723 * 10 + 5) * 10**8
    assert stamp_of(padded(b"01:02\n"))[0] == 3720 * 10**9


@pytest.mark.parametrize(
    "text",
    [
        "",
        "2020",
        "2020-13-01T00:00",
        "2021-02-29T00:00",
        "2020-02-30 01:00",
        "2020-01-01",
        "24:00:00",
        "12:60",
        "1:2",
        "2020-01-01T12:00+25",
    ],
)
def test_what_is_no_stamp(text: str):
    assert stamp_of(padded(text.encode()))[2] == NO_NUMBER
