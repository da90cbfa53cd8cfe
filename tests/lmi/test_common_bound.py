"""The bound by one Lyapunov matrix: its limits, and loops whose parameters really move."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from frictool.lmi.common_bound import common_bound
from frictool.plant.lti import Lti, tustin
from frictool.verify.hinf_norm import norm
from tests.support.position_loop import corner_loops, minimax_controller, sampled


def _corners(seed: int, n: int = 3, spread: float = 0.4) -> list[Lti]:
    """Four loops that are multi-affine in two parameters."""
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n))
    a -= (np.max(np.linalg.eigvals(a).real) + 1.0) * np.eye(n)
    first, second = spread * random.normal(size=(2, n, n))
    b, c, d = random.normal(size=(n, 2)), random.normal(size=(1, n)), random.normal(size=(1, 2))
    return [
        Lti(a + p * first + q * second, b, (1.0 + 0.2 * p) * c, d, 0.0)
        for p in (0.0, 1.0)
        for q in (0.0, 1.0)
    ]


@pytest.mark.parametrize("period", [0.0, 0.5])
@pytest.mark.parametrize("seed", range(4))
def test_of_one_loop_it_is_the_norm(seed: int, period: float) -> None:
    loop = _corners(seed)[0]
    loop = tustin(loop, period) if period else loop
    assert common_bound([loop]) == pytest.approx(norm(loop)[0], rel=1e-4)


@pytest.mark.parametrize("seed", [0, 1, 5])
def test_no_loop_of_the_hull_exceeds_the_bound(seed: int) -> None:
    loops, random = _corners(seed), np.random.default_rng(seed)
    common = common_bound(loops)
    assert max(norm(loop)[0] for loop in loops) <= common * (1.0 + 1e-9)
    for p, q in random.uniform(size=(50, 2)):
        shares = np.array([(1 - p) * (1 - q), (1 - p) * q, p * (1 - q), p * q])
        inside = Lti(
            *(
                sum(s * getattr(loop, part) for s, loop in zip(shares, loops, strict=True))
                for part in "abcd"
            ),
            0.0,
        )
        assert norm(inside)[0] <= common * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_parameters_that_jump_keep_the_common_bound_in_simulation(seed: int) -> None:
    """Energy of the output over energy of the input, with corners drawn anew at every step: never
    above gamma squared."""
    loops, random, step = _corners(seed), np.random.default_rng(seed), 0.02
    gamma, x, seen, given = common_bound(loops), np.zeros(3), 0.0, 0.0
    for _ in range(2000):
        loop = loops[random.integers(4)]
        u = random.normal(size=2)
        n = loop.order
        whole = np.zeros((n + 2, n + 2))
        whole[:n] = np.hstack([loop.a, loop.b])
        fine = expm(whole * step / 8)
        state = np.concatenate([x, u])
        for _ in range(8):
            seen += float(np.sum((loop.c @ state[:n] + loop.d @ u) ** 2)) * step / 8
            state = fine @ state
        given += float(u @ u) * step
        x = state[:n]
    assert seen <= (1.02 * gamma) ** 2 * given


def test_an_unstable_corner_has_no_bound() -> None:
    unstable = Lti(np.array([[1.0]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), 0.0)
    assert common_bound([unstable]) == np.inf


def test_clutch_whose_parameters_move_at_any_speed() -> None:
    """2.63 is the trial's figure for this controller."""
    loops = corner_loops(minimax_controller())
    assert common_bound(loops) == pytest.approx(2.63, rel=5e-3)
    assert common_bound(corner_loops(sampled(minimax_controller()))) > common_bound(loops)
