"""Decimal text to double: Python's `float` is the reference, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from frictool.logs.kernels.decimal_parser import NO_NUMBER, NUMBER, UNDECIDED, scan_number
from frictool.runtime.kernels import kernel


@kernel
def scan(text, mark):
    return scan_number(text, 0, mark)


def scanned(text: str, mark: str = ".", after: str = "\n") -> tuple[float, int, int]:
    return scan(np.frombuffer((text + after).encode(), np.uint8), ord(mark))


decimals = st.from_regex(
    r"[+-]?([0-9]{1,22}(\.[0-9]{0,22})?|\.[0-9]{1,22})([eE][+-]?[0-9]{1,3})?", fullmatch=True
)


@given(text=st.one_of(decimals, st.floats(allow_nan=False, allow_infinity=False).map(repr)))
@example("9007199254740993")  # half-way between two doubles
@example("9007199254740992.5")
@example("1e23")
@example("-0.0")
@example("2.2250738585072014e-308")
@example("0.1e-99999999")
def test_a_number_is_python_s_or_left_to_python(text: str):
    value, end, status = scanned(text)
    assert end == len(text)
    assert status in (NUMBER, UNDECIDED)
    if status == NUMBER:
        assert np.float64(value).tobytes() == np.float64(text).tobytes()


def test_few_numbers_are_left_to_python():
    values = np.random.default_rng(5).normal(size=2000)
    left = sum(scanned(repr(float(value)))[2] == UNDECIDED for value in values)
    assert left < 20  # 1 in 512 is expected
    assert all(scanned(f"{value:.6f}")[2] == NUMBER for value in values)


@pytest.mark.parametrize("text", ["", "-", ".", "+.", "e5", "1e", "1e+", "nan", "inf", "x"])
def test_what_is_no_number(text: str):
    assert scanned(text)[2] == NO_NUMBER


def test_the_scan_stops_where_the_number_ends():
    for text, after, end in [("1.5", ",2", 3), ("1", "_2", 1), ("1.5", ".2", 3), ("12", " 3", 2)]:
        assert scanned(text, after=after) == (float(text), end, NUMBER)
    assert scanned("1,5", mark=",") == (1.5, 3, NUMBER)
    assert scanned("1.5", mark=",") == (1.0, 1, NUMBER)
