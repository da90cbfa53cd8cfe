"""Streams on one grid: held signals keep their value, the others lie on the line between their
samples, nothing is made up at the ends."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.logs.canonical.mcap_layout import StreamHeader
from frictool.logs.clocks.resampling import grid, resampled
from frictool.logs.stream_source import SampleBlock

AXIS = StreamHeader("/axis", ("position", "current", "effort"), ("rad", "A", "N m"))
FORCE = StreamHeader("/axis/force", ("effort", "position"), ("N m", "rad"))


def pieces(
    time: np.ndarray, values: tuple[np.ndarray, ...], sizes: list[int]
) -> Iterator[SampleBlock]:
    """A stream in pieces of these sizes in turn."""
    low = number = 0
    whole = SampleBlock(time, values)
    while low < time.size:
        high = min(time.size, low + sizes[number % len(sizes)])
        yield whole.part(low, high)
        low, number = high, number + 1


times = st.builds(
    lambda start, steps: np.cumsum(np.array([start, *steps], dtype=np.int64)),
    st.integers(-5_000_000, 5_000_000),
    st.lists(st.integers(1, 4_000_000), min_size=1, max_size=60),
)


@given(
    one=times,
    other=times,
    period=st.integers(100_000, 3_000_000),
    sizes=st.lists(st.integers(1, 20), min_size=1, max_size=4),
)
def test_against_plain_interpolation(
    one: np.ndarray, other: np.ndarray, period: int, sizes: list[int]
):
    """Reference: numpy.interp, and a search for the last sample, over the whole streams at once;
    whatever the pieces."""
    rng = np.random.default_rng(1)
    a, b = tuple(rng.normal(size=(3, one.size))), tuple(rng.normal(size=(2, other.size)))
    on = grid([AXIS, FORCE], [], period)
    found = [*resampled([pieces(one, a, sizes), pieces(other, b, sizes[::-1])], on)]
    first, last = max(one[0], other[0]), min(one[-1], other[-1])
    wanted = np.arange(first, last + 1, period) if first <= last else np.empty(0, np.int64)
    time = np.concatenate([np.empty(0, np.int64), *(piece.time for piece in found)])
    assert np.array_equal(time, wanted)
    if not found:
        return
    values = [
        np.concatenate(vectors) for vectors in zip(*(piece.values for piece in found), strict=True)
    ]
    assert values[0] == pytest.approx(np.interp(wanted, one, a[0]), abs=1e-9)
    assert np.array_equal(values[1], a[1][np.searchsorted(one, wanted, side="right") - 1])
    assert values[3] == pytest.approx(np.interp(wanted, other, b[0]), abs=1e-9)


def test_what_is_held_is_said():
    on = grid([AXIS, FORCE], ["/axis"], 1_000_000)
    assert on.head.fields == ("position", "current", "effort", "force_effort", "force_position")
    assert on.head.units == ("rad", "A", "N m", "N m", "rad")
    assert on.note == {
        "period_s": "0.001",
        "/axis.position": "linear",
        "/axis.current": "held",
        "/axis.effort": "held",
        "/axis.force_effort": "linear, from /axis/force.effort",
        "/axis.force_position": "linear, from /axis/force.position",
    }
    assert (
        grid([AXIS], [], 1_000_000).note["/axis.effort"] == "linear"
    )  # a sensor's, not the drive's


def test_its_own_grid_changes_nothing():
    time = np.arange(200) * 1_000_000 + 7
    values = tuple(np.random.default_rng(2).normal(size=(3, 200)))
    (found,) = [*resampled([iter([SampleBlock(time, values)])], grid([AXIS], [], 1_000_000))]
    assert np.array_equal(found.time, time)
    assert all(np.array_equal(one, other) for one, other in zip(found.values, values, strict=True))
