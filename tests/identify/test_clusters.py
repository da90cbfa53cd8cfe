"""Independent parts of the data: strokes, repetitions of one stroke, parts of a stroke."""

from __future__ import annotations

import numpy as np

from frictool.identify.regression.clusters import clusters


def numbered(lengths: list[int], counts: list[float], signs: list[float]) -> list[int]:
    """The cluster of each stroke; every stroke lies in one cluster."""
    stroke = np.repeat(np.arange(len(lengths)), lengths)
    each = np.repeat(np.array(counts) / np.array(lengths), lengths)
    number = clusters(stroke, np.repeat(signs, lengths), each, 10)
    assert all(len(set(number[stroke == k])) == 1 for k in range(len(lengths)))
    return [int(number[stroke == k][0]) for k in range(len(lengths))]


def test_strokes_that_repeat_each_other_are_one_cluster() -> None:
    lengths = [
        100 + 10 * (k // 4) + k % 2 for k in range(60)
    ]  # 15 lengths, four strokes of each, two by two in either direction
    counts = [300.0 - 7.0 * (k // 4) + 0.9 * (k % 3) for k in range(60)]
    signs = [1.0, -1.0] * 30
    number = numbered(lengths, counts, signs)
    assert len(set(number)) == 30
    for k in range(0, 60, 4):
        assert number[k] == number[k + 2] != number[k + 1] == number[k + 3]


def test_strokes_that_differ_by_more_counts_are_their_own() -> None:
    number = numbered([100] * 20, [300.0 + 3.5 * k for k in range(20)], [1.0, -1.0] * 10)
    assert len(set(number)) == 20


def test_repetitions_are_not_merged_where_too_few_groups_were_left() -> None:
    assert len(set(numbered([100] * 30, [300.0] * 30, [1.0, -1.0] * 15))) == 30


def test_few_strokes_are_cut_into_parts() -> None:
    stroke = np.repeat([3, 5, 9], [100, 100, 7])
    number = clusters(stroke, np.ones(207), np.ones(207), 10)
    assert number[-1] == 8  # 4 + 4 + 1
    assert np.all(np.diff(number) >= 0)
    assert len(set(number[:100])) == 4
