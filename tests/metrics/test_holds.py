"""Holds and steps of a reference."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from frictool.metrics.reference_holds import MIN_SAMPLES, find_holds


def test_a_sequence_of_steps_is_cut_at_its_jumps() -> None:
    reference = np.repeat([55.0, 5.0, 35.0], [100, 200, 50])
    position = np.linspace(5.0, 55.0, 350)
    found = [(h.start, h.stop, h.origin, h.target) for h in find_holds(reference, position)]
    assert found == [(0, 100, None, 55.0), (100, 300, 55.0, 5.0), (300, 350, 5.0, 35.0)]


def test_a_record_that_begins_with_its_step_has_it_from_the_initial_position() -> None:
    reference = np.full(200, 55.0)
    moving = np.concatenate((np.linspace(5.0, 55.0, 100), np.full(100, 55.0)))
    (hold,) = find_holds(reference, moving)
    assert hold.origin == 5.0
    (still,) = find_holds(reference, np.full(200, 53.6))
    assert still.origin is None


def test_a_start_within_one_count_of_the_reference_is_no_step() -> None:
    """A load moves the resting axis by a count or more while the loop holds the position."""
    reference = np.full(200, 1.0)
    position = 1.0 + 0.01 * np.repeat([-1.0, 1.0, 0.0], [10, 20, 170])
    for resolution, origin in ((0.01, None), (0.005, 0.99)):
        (hold,) = find_holds(reference, position, resolution)
        assert hold.origin == origin


def test_a_smooth_reference_has_no_hold() -> None:
    time = np.arange(2000) * 1e-3
    assert find_holds(np.sin(time), np.sin(time)) == ()


def test_a_ramp_between_two_holds_is_no_step() -> None:
    reference = np.concatenate((np.zeros(100), np.linspace(0.0, 1.0, 50), np.ones(100)))
    holds = find_holds(reference, reference)
    assert [(h.target, h.origin) for h in holds] == [(0.0, None), (1.0, None)]


def test_a_resampled_edge_is_a_step_from_its_first_sample() -> None:
    reference = np.concatenate((np.zeros(100), [0.4, 0.9], np.ones(100)))
    holds = find_holds(reference, reference)
    assert (holds[1].start, holds[1].origin, holds[1].target) == (100, 0.0, 1.0)


def test_a_staircase_of_short_treads_is_no_step() -> None:
    reference = np.repeat(np.arange(50.0), MIN_SAMPLES - 1)
    assert find_holds(reference, reference) == ()


def test_a_short_record_has_no_hold() -> None:
    assert find_holds(np.zeros(MIN_SAMPLES - 1), np.zeros(MIN_SAMPLES - 1)) == ()


@given(
    st.lists(st.tuples(st.integers(-20, 20), st.integers(1, 80)), min_size=1, max_size=12),
    st.floats(0.01, 100.0),
    st.floats(-1e3, 1e3),
)
def test_holds_do_not_depend_on_units_nor_on_the_origin(
    pieces: list[tuple[int, int]], scale: float, offset: float
) -> None:
    reference = np.repeat([float(level) for level, _ in pieces], [count for _, count in pieces])
    position = np.concatenate((reference[:1] - 1.0, reference[:-1]))
    plain = find_holds(reference, position)
    changed = find_holds(scale * reference + offset, scale * position + offset)
    assert [(h.start, h.stop, h.origin is None) for h in plain] == [
        (h.start, h.stop, h.origin is None) for h in changed
    ]
    assert all(
        np.ptp(h.of(reference)[-MIN_SAMPLES:]) == 0.0 and h.stop - h.start >= MIN_SAMPLES
        for h in plain
    )


def test_counts_of_a_replayed_encoder_are_no_steps_and_larger_jumps_are() -> None:
    count = 0.1
    reference = count * np.repeat([100.0, 101.0, 102.0, 104.0, 103.0, 50.0], 30)
    amplitudes = [
        None if h.origin is None else round((h.target - h.origin) / count)
        for h in find_holds(reference, reference, count)
    ]
    assert amplitudes == [None, None, None, 2, None, -53]
    assert [h.origin is not None for h in find_holds(reference, reference)] == [
        False,
        True,
        True,
        True,
        True,
        True,
    ]
