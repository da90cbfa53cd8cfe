"""The axis with its parameters pulled out is the axis, at every value of the parameters; the
enclosure holds what it leaves out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag

from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.linear_axis import INPUTS, OUTPUTS, AxisRates, linear_axis
from frictool.plant.lti import Lti
from frictool.plant.parameter_box import DYNAMIC
from frictool.plant.uncertain_axis import FullBlock, UncertainAxis, uncertain_axis, uncertain_plant

BOX = {
    "inertia": (1.11e-5, 1.53e-5),
    "constant": (12.8e-3, 14e-3),
    "viscous": (0.0, 7.62e-4),
    "coulomb": (0.018, 0.18),
}
M, P = len(INPUTS), len(OUTPUTS)


def _drawn(random: np.random.Generator) -> tuple[dict[str, float], AxisRates]:
    """Normalised values of the parameters, and the rates of that axis."""
    delta = {name: float(random.uniform(-1.0, 1.0)) for name in DYNAMIC}
    j, k, s = (
        0.5 * (BOX[n][0] + BOX[n][1]) + delta[n] * 0.5 * (BOX[n][1] - BOX[n][0]) for n in DYNAMIC
    )
    return delta, AxisRates(k / j, s / j, BOX["coulomb"][1] / j, 1.0 / j)


def _closed(axis: UncertainAxis, delta: dict[str, float]) -> np.ndarray:
    """[A B; C D] with every real block closed, the full one left open: its ports are the last."""
    system = axis.block.system
    whole = np.block([[system.a, system.b], [system.c, system.d]])
    n, blocks = system.order, [b for b in axis.blocks if not isinstance(b, FullBlock)]
    d = block_diag(*(delta[b.name] * np.eye(b.size) for b in blocks))
    rows, columns = slice(n + P, n + P + len(d)), slice(n + M, n + M + len(d))
    closed = (
        whole
        + whole[:, columns]
        @ np.linalg.solve(np.eye(len(d)) - d @ whole[rows, columns], d)
        @ whole[rows]
    )
    return np.delete(np.delete(closed, np.r_[rows], 0), np.r_[columns], 1)


def _exact(rates: AxisRates, lag: float, period: float) -> np.ndarray:
    system = linear_axis(rates, lag, period).system
    return np.block([[system.a, system.b], [system.c, system.d]])


@pytest.mark.parametrize("lag", [0.003, 0.0])
def test_continuous_form_is_exact(lag: float) -> None:
    random, axis = np.random.default_rng(1), uncertain_axis(BOX, lag)
    for _ in range(20):
        delta, rates = _drawn(random)
        np.testing.assert_allclose(
            _closed(axis, delta), _exact(rates, lag, 0.0), rtol=1e-12, atol=1e-12
        )


@pytest.mark.parametrize("lag", [0.003, 0.0])
@pytest.mark.parametrize("levels", [1, 2, 3])
@pytest.mark.parametrize("period", [1e-3, 1e-2])
def test_the_rest_of_a_sampled_axis_is_inside_its_block(
    lag: float, levels: int, period: float
) -> None:
    random, axis = np.random.default_rng(2), uncertain_axis(BOX, lag, period, levels)
    rest = axis.blocks[-1]
    assert isinstance(rest, FullBlock)
    n = axis.block.system.order
    for _ in range(20):
        delta, rates = _drawn(random)
        whole, exact = _closed(axis, delta), _exact(rates, lag, period)
        known, entering, leaving = (
            whole[: -rest.entering, :-1],
            whole[: -rest.entering, -1:],
            whole[-rest.entering :, :-1],
        )
        # exact = known + entering Delta leaving, for one Delta of norm at most 1
        row = np.linalg.lstsq(entering, exact - known, rcond=None)[0]
        block = np.linalg.lstsq(leaving.T, row.T, rcond=None)[0].T
        np.testing.assert_allclose(
            known + entering @ block @ leaving,
            exact,
            rtol=1e-9,
            atol=1e-9 * np.max(np.abs(exact[:n])),
        )
        assert np.linalg.norm(block, 2) <= 1.0 + 1e-9


def test_enough_levels_are_exact_without_the_rest() -> None:
    random, axis = np.random.default_rng(3), uncertain_axis(BOX, 0.003, 1e-3, 8)
    delta, rates = _drawn(random)
    whole = _closed(axis, delta)
    np.testing.assert_allclose(
        whole[: -axis.blocks[-1].entering, :-1], _exact(rates, 0.003, 1e-3), rtol=1e-12, atol=1e-13
    )


def test_a_parameter_without_width_is_not_pulled_out() -> None:
    axis = uncertain_axis({**BOX, "constant": (13e-3, 13e-3)}, 0.003)
    assert [block.name for block in axis.blocks] == ["inertia", "viscous"]


def test_a_box_of_one_plant_is_that_plant() -> None:
    """The rest of a sampled axis would be a channel of zero width, in which no scaling is the right
    one."""
    one = {name: (high, high) for name, (_, high) in BOX.items()}
    axis = uncertain_axis(one, 0.003, 1e-3)
    j = one["inertia"][1]
    rates = AxisRates(one["constant"][1] / j, one["viscous"][1] / j, one["coulomb"][1] / j, 1.0 / j)
    assert axis.blocks == ()
    system = axis.block.system
    whole = np.block([[system.a, system.b], [system.c, system.d]])
    np.testing.assert_allclose(whole, _exact(rates, 0.003, 1e-3), rtol=1e-12, atol=1e-13)


def test_uncertain_plant_has_the_uncertainty_first_and_is_the_plant_at_the_middle() -> None:
    weights = PlantWeights(template(40.0, 0.5, 2 / 63), 0.03, 0.5, 0.5, FirstOrderWeight(0.01))
    plant, blocks = uncertain_plant("speed", BOX, 0.003, weights)
    count = len(blocks)
    j, k, s = (0.5 * sum(BOX[name]) for name in DYNAMIC)
    known = generalised_plant("speed", AxisRates(k / j, s / j, 0.18 / j), 0.003, weights)
    np.testing.assert_allclose(plant.a, known.a, rtol=1e-12)
    np.testing.assert_allclose(plant.b1[:, count:], known.b1, rtol=1e-12)
    np.testing.assert_allclose(plant.c1[count:], known.c1, rtol=1e-12)


@pytest.mark.parametrize("wrong", [{"inertia": (0.0, 1e-5)}, {"viscous": (-1e-4, 1e-4)}])
def test_a_box_that_is_no_axis_is_refused(wrong: dict[str, tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="positive inertia"):
        uncertain_axis({**BOX, **wrong}, 0.003)


def test_friction_of_a_tangent_counts_by_its_magnitude() -> None:
    system = uncertain_axis({**BOX, "coulomb": (-0.15, 0.018)}, 0.003).block.system
    assert system.b[1, INPUTS.index("friction")] == pytest.approx(
        -0.15 / (0.5 * sum(BOX["inertia"]))
    )
    assert isinstance(system, Lti)
