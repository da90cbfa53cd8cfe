"""Elements that stick in several places at once, and their starts: against Gauss's principle tried
face by face, and against results by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.engine.mechanism.events import BREAKS_AWAY, SEPARATES
from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.mechanism.state import STUCK
from studies.rigs.mechanism_builder import Builder
from tests.engine.mechanism.least_constraint import accelerations
from tests.support.mechanism_forces import forces
from tests.support.mechanism_runs import instants, moved, ready


def row_of_blocks(count: int, coulomb: float = 1.0) -> Builder:
    """Blocks in a row, each with friction, between which there are gaps of 20 mm; the first is
    driven."""
    b = Builder()
    for i in range(count):
        b.block(1.0)
        b.friction(i, "coulomb", coulomb=coulomb)
        if i > 0:
            b.joint(i - 1, i, gap=0.01)
    b.source(0)
    return b


@pytest.mark.parametrize(
    ("effort", "moves"),
    [(2.999999, False), (3.000001, True), (-0.999999, False), (-1.000001, True)],
)
def test_a_row_in_contact_starts_where_its_frictions_together_give_way(
    effort: float, moves: bool
) -> None:
    result, _, state = moved(row_of_blocks(3), [[effort]], start=[0.0, -0.01, -0.02])
    assert (result.speeds[0, -1] != 0.0) == moves
    if effort > 3.0:
        assert result.speeds[:, -1] == pytest.approx((effort - 3.0) / 3.0 * 1e-3, rel=1e-6)
    if effort < -1.0:
        assert np.all(state.modes[1:3] == STUCK)  # the others stay where they are
        assert np.all(result.positions[1:, -1] == [-0.01, -0.02])


def test_breakaways_of_a_row_are_crossed_one_after_another() -> None:
    # gaps of 20 mm from one to the next: each block is taken along when it is met; its friction is
    # crossed then, not before
    b = row_of_blocks(3)
    result, _, _ = moved(b, np.full((400, 1), 3.5))
    times = [instants(result, BREAKS_AWAY, i)[0] for i in (1, 2)]
    assert times[0] == pytest.approx(math.sqrt(2.0 * 0.01 / 2.5), rel=1e-9)
    assert times[1] > times[0]
    assert result.positions[2, -1] > result.positions[1, 0]


def test_at_rest_the_forces_pass_what_friction_leaves() -> None:
    machine, state = ready(row_of_blocks(3), [0.0, -0.01, -0.02])
    run(machine, state, [[2.5]], 1e-3)
    found = forces(machine, state)
    assert found.links == pytest.approx([1.5, 0.5])
    assert found.holds == pytest.approx([1.0, 1.0, 0.5])


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_starts_are_those_of_the_least_constraint(seed: int) -> None:
    rng = np.random.default_rng(seed)
    b, n, sides = Builder(), int(rng.integers(2, 5)), []
    levels = np.where(rng.random(n) < 0.7, rng.uniform(0.1, 2.0, n), 0.0)
    start = np.zeros(n)
    for i in range(n):
        b.block(rng.uniform(0.2, 3.0))
        b.friction(i, "coulomb", coulomb=float(levels[i]))
        if i > 0:
            a, c, ratio = (
                int(rng.integers(i)),
                i,
                float(rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0)),
            )
            side = int(rng.choice([-1, 0, 1]))
            start[i] = ratio * start[a] + side * 0.01
            if rng.random() < 0.5:  # against the direction in which the tree is walked
                a, c = c, a
                start[i] = (start[c] - side * 0.01) / ratio
            b.joint(a, c, ratio, gap=0.01 if side else 0.0)
            sides.append(side)
    efforts = rng.uniform(-4.0, 4.0, n)
    expected = accelerations(b, efforts, levels, sides)
    machine, state = ready(b, start)
    run(machine, state, np.zeros((1, 0)), 1e-6, efforts[None])
    assert state.y[n:] / 1e-6 == pytest.approx(expected, abs=2e-5)


def test_a_flank_lets_go_when_its_force_has_gone() -> None:
    # two blocks pushed apart by nothing: the driven one is braked, the other coasts on
    b = Builder()
    b.block(1.0)
    b.block(1.0)
    b.joint(0, 1, gap=0.01)
    b.source(0)
    result, _, _ = moved(b, np.repeat([1.0, -1.0], 100)[:, None], start=[0.0, -0.01])
    assert instants(result, SEPARATES, 0) == pytest.approx([0.1], abs=1e-12)
    assert result.speeds[1, -1] == pytest.approx(0.05, rel=1e-12)
    assert result.speeds[0, -1] == pytest.approx(0.05 - 0.1, rel=1e-9)
