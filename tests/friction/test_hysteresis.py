"""Hysteresis operators: annex A's rules, wiping-out, closed loops, congruency; equal to slow
references."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.friction.masing import masing_force, masing_move
from frictool.friction.maxwell_bank import bank_force, bank_move, bank_tail, parabolic_bank
from frictool.friction.preisach import everett, preisach_force, preisach_move
from frictool.friction.preisach_cycles import (
    cell_weights,
    everett_tail,
    masing_cycles,
    masing_everett,
)
from frictool.friction.reversal_memory import COUNT, FORCE, FORGOTTEN, new_memory
from frictool.friction.status_codes import MEMORY_FULL, NOT_FINITE, OK
from frictool.friction.virgin_curve import virgin_force
from tests.support.plain_laws import Masing, Relays

BREAKAWAY, LIMIT = 1.5, 1e-5
TABLE = masing_everett()
PLACES = st.lists(
    st.integers(-20, 20), min_size=1, max_size=25
)  # in half cells of the 20 x 20 triangle


def masing_path(places: list[float], memory: np.ndarray | None = None) -> np.ndarray:
    """Forces along straight movements between places, in units of z_max."""
    memory = new_memory(64) if memory is None else memory
    forces = []
    for place in places:
        tried = masing_force(memory, place * LIMIT, BREAKAWAY, LIMIT)
        assert masing_move(memory, place * LIMIT, BREAKAWAY, LIMIT) == OK
        assert memory[FORCE] == tried
        forces.append(tried)
    return np.array(forces)


def preisach_path(
    places: list[float], table: np.ndarray = TABLE, memory: np.ndarray | None = None
) -> np.ndarray:
    memory = new_memory(64) if memory is None else memory
    forces = []
    for place in places:
        tried = preisach_force(memory, place * LIMIT, table, BREAKAWAY, LIMIT)
        assert preisach_move(memory, place * LIMIT, table, LIMIT) == OK
        assert BREAKAWAY * memory[FORCE] == pytest.approx(tried, rel=1e-15)
        forces.append(tried)
    return np.array(forces)


def unit_virgin(z: float) -> float:
    left = 1 - min(abs(z), 1)
    return float(np.sign(z)) * (1 - left * left)


@given(z=st.floats(-3, 3))
def test_virgin_curve(z: float) -> None:
    assert virgin_force(z * LIMIT, BREAKAWAY, LIMIT) == pytest.approx(
        BREAKAWAY * unit_virgin(z), rel=1e-12, abs=1e-15
    )


@given(
    places=st.lists(
        st.one_of(
            st.floats(-1.5, 1.5).map(lambda z: round(z, 6)),
            st.sampled_from([-0.5, 0.0, 0.5, 1.0, -1.0]),
        ),
        min_size=1,
    )
)
def test_masing_equals_the_rules_on_the_whole_history(places: list[float]) -> None:
    plain = Masing(unit_virgin)
    expected = BREAKAWAY * np.array([plain.force(place) for place in places])
    np.testing.assert_allclose(masing_path(places), expected, rtol=1e-9, atol=1e-12)


@settings(derandomize=True, deadline=None, max_examples=20)
@given(places=st.lists(st.floats(-1.3, 1.3), min_size=1, max_size=20))
def test_masing_is_the_limit_of_a_fine_maxwell_bank(places: list[float]) -> None:
    """The bank's virgin curve is off by F_s/(4 N^2) at most, each reversal adds twice that."""
    count = 1000
    z = np.arange(1, count + 1) / count
    tail, deflections, last, found = bank_tail(z, 1 - (1 - z) ** 2), np.zeros(count), 0.0, []
    for place in places:
        found.append(bank_force(deflections, (place - last) * LIMIT, tail, BREAKAWAY, LIMIT))
        bank_move(deflections, (place - last) * LIMIT, tail, LIMIT)
        assert found[-1] == pytest.approx(
            bank_force(deflections, 0.0, tail, BREAKAWAY, LIMIT), rel=1e-12, abs=1e-12
        )
        last = place
    assert (
        np.max(np.abs(masing_path(places) - found))
        <= (2 * len(places) + 1) * BREAKAWAY / (4 * count**2) + 1e-12
    )


@given(
    places=st.lists(st.floats(-3, 3), min_size=1, max_size=20),
    limits=st.lists(st.floats(0.1, 2.0), min_size=1, max_size=4),
)
def test_bank_equals_a_plain_loop(places: list[float], limits: list[float]) -> None:
    count = len(limits)
    weights = np.arange(1, count + 1) / sum(range(1, count + 1))
    tail, deflections, plain = np.concatenate([limits, weights]), np.zeros(count), [0.0] * count
    for before, after in zip([0.0, *places], places, strict=False):
        moved = after - before
        plain = [max(-d, min(d, x + moved)) for x, d in zip(plain, limits, strict=True)]
        expected = sum(w * x / d for w, x, d in zip(weights, plain, limits, strict=True))
        assert bank_force(deflections, moved * LIMIT, tail, 1.0, LIMIT) == pytest.approx(
            expected, rel=1e-9, abs=1e-12
        )
        bank_move(deflections, moved * LIMIT, tail, LIMIT)


def test_parabolic_bank_runs_through_the_virgin_curve() -> None:
    z = np.arange(1, 11) / 10
    found = [bank_force(np.zeros(10), point, parabolic_bank(), 1.0, 1.0) for point in z]
    np.testing.assert_allclose(found, [unit_virgin(point) for point in z], rtol=1e-12)


@pytest.mark.parametrize(
    ("displacements", "forces", "match"),
    [
        ([1.0, 0.5], [1.0, 1.2], "increase from 0"),
        ([1.0], [1.0, 2.0], "a finite force for each"),
        ([1.0, 2.0], [1.0, 3.0], "fall from point to point"),
        ([1.0, 2.0], [1.0, 0.5], "slopes >= 0"),
        ([1.0], [float("nan")], "finite"),
    ],
)
def test_a_virgin_curve_that_no_bank_has_is_refused(
    displacements: list[float], forces: list[float], match: str
) -> None:
    with pytest.raises(ValueError, match=match):
        bank_tail(np.array(displacements), np.array(forces))


def test_everett_of_centred_cycles_is_half_a_masing_branch() -> None:
    """On the nodes E(alpha, beta) = f((alpha - beta)/2)."""
    nodes = np.linspace(-1, 1, 21)
    for i, upper in enumerate(nodes):
        for lower in nodes[: i + 1]:
            assert everett(TABLE, upper, lower) == pytest.approx(
                unit_virgin((upper - lower) / 2), rel=1e-12, abs=1e-14
            )


def test_distribution_sums_to_the_breakaway_and_is_elastic_on_the_diagonal() -> None:
    weights = cell_weights(TABLE)
    assert weights.sum() == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(np.diag(weights), unit_virgin(0.05), rtol=1e-12)
    assert np.all(weights[np.tril_indices(20, -1)] < 0.0)  # clockwise loops


def test_cycles_measured_on_other_places_give_the_same_table() -> None:
    """Branches in metres and newtons, on a fine grid of their own: linear interpolation of the
    parabola is all that is lost."""
    cycles = []
    for k in range(1, 11):
        z = np.linspace(k / 10, -k / 10, 2001)
        force = np.array(
            [unit_virgin(k / 10) + 2 * unit_virgin((point - k / 10) / 2) for point in z]
        )
        cycles.append((z * LIMIT, BREAKAWAY * force))
    np.testing.assert_allclose(everett_tail(cycles), TABLE, atol=1e-7)


GOOD = masing_cycles(4)


@pytest.mark.parametrize(
    ("cycles", "match"),
    [
        ([], "found no centred cycle"),
        (
            [(0.9 * GOOD[0][0], GOOD[0][1]), GOOD[1]],
            r"cycle 1 runs from 0\.45 to -0\.45; allowed: from 0\.5 to -0\.5",
        ),
        ([(GOOD[0][0][::-1], GOOD[0][1]), GOOD[1]], "positions that fall"),
        ([(z, 0.0 * f) for z, f in GOOD], "must fall from the first to the last position"),
    ],
)
def test_cycles_that_give_no_triangle_are_refused(cycles: list, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        everett_tail(cycles)
    with pytest.raises(ValueError, match="cells is 5; allowed: an even number"):
        masing_cycles(5)


@given(places=PLACES, seed=st.integers(0, 3))
def test_preisach_equals_a_bank_of_relays(places: list[int], seed: int) -> None:
    """Thresholds in the middle of quarter cells, inputs on their borders: equal to rounding, for
    any odd distribution."""
    table = TABLE
    if seed:
        draw = np.random.default_rng(seed)
        cycles = [
            (z, f + np.concatenate([[0.0], draw.normal(0, 0.1, f.size - 2), [0.0]]))
            for z, f in masing_cycles()
        ]
        table = everett_tail(cycles)
    relays = Relays(cell_weights(table), 2)
    expected = BREAKAWAY * np.array([relays.force(place / 20) for place in places])
    np.testing.assert_allclose(
        preisach_path([place / 20 for place in places], table), expected, rtol=0, atol=1e-12
    )


@given(places=st.lists(st.integers(-10, 10), min_size=1, max_size=25))
def test_preisach_of_masing_cycles_is_masing_on_the_nodes(places: list[int]) -> None:
    steps = [place / 10 for place in places]
    np.testing.assert_allclose(preisach_path(steps), masing_path(steps), rtol=0, atol=1e-12)


@pytest.mark.parametrize("path", [masing_path, preisach_path])
@given(
    first=st.lists(st.floats(-0.9, 0.9), max_size=8),
    second=st.lists(st.floats(-0.9, 0.9), max_size=8),
    after=st.lists(st.floats(-1, 1), min_size=1, max_size=8),
)
def test_a_larger_extreme_wipes_out_what_came_before(
    path, first: list[float], second: list[float], after: list[float]
) -> None:
    """-0.95, then 0.92: two histories end alike, in force and in memory."""
    one, other = new_memory(64), new_memory(64)
    path([*first, -0.95, 0.92], memory=one)
    path([*second, -0.95, 0.92], memory=other)
    assert one[COUNT] == other[COUNT] == 1
    np.testing.assert_allclose(
        path(after, memory=one), path(after, memory=other), rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("path", [masing_path, preisach_path])
@given(
    first=st.lists(st.floats(-1, 1), max_size=8),
    second=st.lists(st.floats(-1, 1), max_size=8),
    low=st.floats(-0.9, 0.8),
    width=st.floats(0.05, 1.0),
)
def test_loops_between_the_same_extremes_are_congruent_and_closed(
    path, first: list[float], second: list[float], low: float, width: float
) -> None:
    high = min(low + width, 1.0)
    cycle = [high, low, high, 0.5 * (low + high), low, 0.3 * low + 0.7 * high, high]
    one, other = (
        path([*first, *cycle])[len(first) + 1 :],
        path([*second, *cycle])[len(second) + 1 :],
    )
    np.testing.assert_allclose(one[1:] - one[0], other[1:] - other[0], rtol=0, atol=1e-12)
    assert one[0] == pytest.approx(one[3], abs=1e-12)
    assert one[1] == pytest.approx(one[5], abs=1e-12)


@pytest.mark.parametrize("path", [masing_path, preisach_path])
@given(corners=st.lists(st.floats(-1.2, 1.2), min_size=1, max_size=12))
def test_every_movement_from_virgin_costs_energy(path, corners: list[float]) -> None:
    """int F dz >= 0 from the virgin contact to anywhere; closed loops dissipate (annex A)."""
    z = np.concatenate(
        [np.linspace(a, b, 60)[1:] for a, b in zip([0.0, *corners], corners, strict=False)]
    )
    force = path(list(z))
    work = np.cumsum(np.diff(z, prepend=0.0) * 0.5 * (force + np.concatenate([[0.0], force[:-1]])))
    assert work.min() >= -1e-3 * BREAKAWAY


@pytest.mark.parametrize("path", [masing_path, preisach_path])
@given(places=st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=12), cuts=st.integers(2, 5))
def test_only_the_extremes_matter(path, places: list[float], cuts: int) -> None:
    """Rate independence: the same path in more steps ends alike; oddness: its mirror image is the
    mirror image."""
    fine = [
        p
        for a, b in zip([0.0, *places], places, strict=False)
        for p in [*np.linspace(a, b, cuts + 1)[1:-1], b]
    ]
    coarse = path(places)
    np.testing.assert_allclose(path(fine)[cuts - 1 :: cuts], coarse, rtol=0, atol=1e-12)
    np.testing.assert_allclose(path([-p for p in places]), -coarse, rtol=0, atol=1e-12)


def test_a_full_memory_and_a_place_that_is_no_number_are_reported_and_change_nothing() -> None:
    memory = new_memory(2)
    for place in (0.9, -0.8, 0.7):
        assert masing_move(memory, place, 1.0, 1.0) == OK
    before = memory.copy()
    assert masing_move(memory, -0.6, 1.0, 1.0) == MEMORY_FULL
    assert masing_move(memory, float("nan"), 1.0, 1.0) == NOT_FINITE
    assert preisach_move(memory, float("nan"), TABLE, 1.0) == NOT_FINITE
    np.testing.assert_array_equal(memory, before)


def ringing(count: int) -> list[float]:
    """Reversals at 0.9, -0.9 q, 0.9 q^2 ..., q = 0.99, nested in one another."""
    return [0.9 * (-0.99) ** k for k in range(count)]


@pytest.mark.parametrize("path", [masing_path, preisach_path])
def test_a_slow_ringing_does_not_overflow_the_memory(path) -> None:
    """200 nested reversals in a memory of 64: the forces while it rings are exact, and so are they
    after all is wiped out."""
    short, long = new_memory(64), new_memory(256)
    np.testing.assert_array_equal(path(ringing(200), memory=short), path(ringing(200), memory=long))
    assert short[COUNT] <= 64
    assert short[FORGOTTEN] > 0
    assert long[FORGOTTEN] == 0
    back = list(np.linspace(0.0, 0.89, 500))
    assert np.max(np.abs(path(back, memory=short) - path(back, memory=long))) < 0.01 * BREAKAWAY
    after = [0.95, -0.3, 0.2]
    np.testing.assert_allclose(
        path(after, memory=short), path(after, memory=long), rtol=0, atol=1e-12
    )
