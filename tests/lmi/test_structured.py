"""D-G bounds against loops whose worst case is known, against searches, and on the clutch."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.lmi.structured_singular_value import singular_value, worst_gain
from frictool.plant.lti import Lti, tustin
from frictool.plant.uncertain_axis import FullBlock, RealBlock, uncertain_plant
from frictool.verify.hinf_norm import norm
from frictool.verify.interior_search import searched, worst_norm
from tests.support.position_loop import BOX, CLUTCH, LAG, WEIGHTS, minimax_controller, plant


def _second_order(stiffness: float, damping: float) -> Lti:
    """x'' + (2 + damping d2) x' + (3 + stiffness d1) x = 0; stable where both are positive."""
    a = np.array([[0.0, 1.0], [-3.0, -2.0]])
    b = np.array([[0.0, 0.0, 0.0], [-1.0, -1.0, 1.0]])
    c = np.array([[stiffness, 0.0], [0.0, damping], [1.0, 0.0]])
    return Lti(a, b, c, np.zeros((3, 3)), 0.0)


TWO = (RealBlock("stiffness", 1), RealBlock("damping", 1))


@pytest.mark.parametrize(("stiffness", "damping"), [(1.5, 1.9), (2.9, 0.5), (2.0, 1.0), (0.3, 0.1)])
def test_singular_value_of_a_polynomial_with_real_coefficients(
    stiffness: float, damping: float
) -> None:
    exact = max(stiffness / 3.0, damping / 2.0)
    assert exact <= singular_value(_second_order(stiffness, damping), TWO).value <= 1.01 * exact


def test_phase_of_real_parameters_counts() -> None:
    """With complex blocks in place of the real ones the same loop has a far larger singular
    value."""
    complex_blocks = (FullBlock("stiffness", 1, 1), FullBlock("damping", 1, 1))
    loop = _second_order(2.0, 0.1)
    assert singular_value(loop, complex_blocks).value > 1.1 * singular_value(loop, TWO).value


def test_worst_gain_of_a_first_order_lag() -> None:
    loop = Lti(
        np.array([[-1.0]]), np.array([[-1.0, 1.0]]), np.array([[0.5], [1.0]]), np.zeros((2, 2)), 0.0
    )
    assert 2.0 <= worst_gain(loop, (RealBlock("pole", 1),)).value <= 2.01  # 1/(1 + 0.5 d) at d = -1


def test_without_uncertainty_it_is_the_norm() -> None:
    loop = Lti(np.array([[0.5, 0.2], [0.0, 0.9]]), np.eye(2), np.eye(2), np.zeros((2, 2)), 1e-3)
    true = norm(loop)[0]
    assert true <= worst_gain(loop, ()).value <= 1.003 * true


def test_an_unstable_plant_in_the_box_has_no_bound() -> None:
    assert worst_gain(_second_order(3.2, 0.1), TWO).value == np.inf
    unstable = Lti(np.array([[1.0]]), np.ones((1, 2)), np.ones((2, 1)), np.zeros((2, 2)), 0.0)
    assert worst_gain(unstable, (RealBlock("pole", 1),)).value == np.inf


@pytest.mark.parametrize("seed", range(6))
def test_bound_is_above_every_plant_and_near_the_worst(seed: int) -> None:
    """Two real parameters, one of them repeated, in a random stable loop of order 4."""
    random = np.random.default_rng(seed)
    a = random.normal(size=(4, 4))
    a -= (np.max(np.linalg.eigvals(a).real) + 0.5) * np.eye(4)
    loop = Lti(a, random.normal(size=(4, 5)), random.normal(size=(5, 4)), np.zeros((5, 5)), 0.0)
    loop.c[:3] *= 0.05
    blocks = (RealBlock("first", 2), RealBlock("second", 1))
    bound, found = worst_gain(loop, blocks).value, 0.0
    for first in np.linspace(-1.0, 1.0, 9):
        for second in np.linspace(-1.0, 1.0, 9):
            moved = loop.a + loop.b[:, :3] @ np.diag([first, first, second]) @ loop.c[:3]
            found = max(found, norm(Lti(moved, loop.b[:, 3:], loop.c[3:], loop.d[3:, 3:], 0.0))[0])
    assert found <= bound <= 1.02 * found


def test_the_bound_is_the_same_in_both_domains() -> None:
    loop = _second_order(1.0, 1.0)
    assert worst_gain(tustin(loop, 0.1), TWO).value == pytest.approx(
        worst_gain(loop, TWO).value, rel=3e-3
    )


def test_clutch_is_bounded_by_its_worst_vertex() -> None:
    """Every constant plant of table 5.2, between the vertices too: 0.8872."""
    uncertain, blocks = uncertain_plant("position", BOX, LAG, WEIGHTS)
    worst = searched(
        minimax_controller(),
        plant(),
        BOX,
        worst_norm(minimax_controller(), plant(), CLUTCH.vertices),
    )
    level = worst_gain(uncertain.closed(minimax_controller()), blocks, worst.norm)
    assert worst.norm <= level.value <= 1.003 * worst.norm
    assert level.value == pytest.approx(0.8872, rel=5e-3)
    assert level.arcs > 10
