"""The gridded synthesis between its limits: the polytope's common X, Y at one end, an LTI problem
at the other."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from frictool.errors import NoSolutionError
from frictool.lmi import hinf_synthesis
from frictool.lmi.grid_inequalities import ParameterBasis, Values, _least
from frictool.lmi.gridded_synthesis import (
    GriddedSolution,
    GridSchedule,
    _GridSearch,
    minimise,
)
from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.linear_axis import AxisRates
from frictool.typing import Matrix
from frictool.verify.hinf_norm import norm

WEIGHTS = PlantWeights(template(20.0, 0.5, 2 / 63), 0.1, 0.05, 0.02, FirstOrderWeight(0.01))
RECENTRING = 1.05
DOMAINS = [(0.0, 0), (1e-3, 1)]
LONG_CONTINUOUS = [pytest.param(0.0, 0, marks=pytest.mark.accept), (1e-3, 1)]
LONG_DISCRETE = [(0.0, 0), pytest.param(1e-3, 1, marks=pytest.mark.accept)]


def _plant(values: Values, period: float = 0.0, delay: int = 0) -> GeneralisedPlant:
    """Affine in the first value, and in the second."""
    viscous, drive = values
    return generalised_plant(
        "position",
        AxisRates(1000.0 * (1.0 + 0.4 * drive), 40.0 * (1.0 + viscous), 12000.0),
        0.003,
        WEIGHTS,
        period,
        delay,
    )


def _solved(
    rates: tuple[float, ...], degrees: tuple[int, int], period: float = 0.0, delay: int = 0
) -> GriddedSolution:
    return minimise(
        lambda values: [_plant(values, period, delay)], GridSchedule(rates, degrees, 2), RECENTRING
    )


@pytest.mark.parametrize(("period", "delay"), LONG_DISCRETE)
def test_constant_matrices_are_those_of_the_polytope(period: float, delay: int) -> None:
    corners = [_plant(values, period, delay) for values in product((-1.0, 1.0), repeat=2)]
    common = hinf_synthesis.minimise(corners, RECENTRING).optimum
    assert _solved((0.0, 0.0), (0, 0), period, delay).optimum == pytest.approx(common, rel=2e-3)
    assert _solved((np.inf, np.inf), (1, 1), period, delay).optimum == pytest.approx(
        common, rel=2e-3
    )


@pytest.mark.parametrize(("period", "delay"), LONG_CONTINUOUS)
def test_more_freedom_never_costs_and_faster_motion_never_helps(period: float, delay: int) -> None:
    cases = (
        [(0.0, (1, 1)), (300.0, (0, 0))]
        if period
        else [(0.0, (2, 2)), (0.0, (1, 1)), (30.0, (1, 1)), (300.0, (0, 0))]
    )
    optima = []
    for rate, degrees in cases:
        schedule = GridSchedule((rate * (period or 1.0),), degrees, 2)
        optima.append(
            minimise(
                lambda values: [_plant((-0.5 * values[0], 0.5 * values[0]), period, delay)],
                schedule,
                RECENTRING,
            ).optimum
        )
    assert np.all(np.diff(optima) >= -2e-3 * optima[0])
    assert optima[0] < 0.99 * optima[-1]


def test_fast_motion_ends_at_the_polytope() -> None:
    assert _solved((1e5, 1e5), (1, 1)).optimum == pytest.approx(
        _solved((0.0, 0.0), (0, 0)).optimum, rel=5e-3
    )


@pytest.mark.parametrize(("period", "delay"), DOMAINS)
def test_one_point_is_an_lti_problem(period: float, delay: int) -> None:
    plant = _plant((0.3, -0.5), period, delay)
    alone = minimise(lambda values: [plant], GridSchedule(()), RECENTRING)
    assert alone.optimum == pytest.approx(
        hinf_synthesis.minimise([plant], RECENTRING).optimum, rel=2e-3
    )
    assert alone.checked == 1


@pytest.mark.parametrize(("period", "delay"), DOMAINS)
def test_frozen_controllers_keep_gamma_at_their_plants_between_the_points_too(
    period: float, delay: int
) -> None:
    found = minimise(
        lambda values: [_plant((0.2, 0.5 * values[0]), period, delay)],
        GridSchedule((1.0 * (period or 1.0),), points=2),
        RECENTRING,
    )
    for values in np.random.default_rng(1).uniform(-1.0, 1.0, size=(12, 1)):
        plant = _plant((0.2, 0.5 * values[0]), period, delay)
        assert norm(plant.closed(found.frozen(plant, values)))[0] <= found.gamma * (1.0 + 1e-6)


def test_points_between_the_first_grid_join_it_where_they_fail() -> None:
    """A loop that is only hard in the middle of the grid's interval: the ends alone know nothing of
    it."""

    def family(values: Values) -> list[GeneralisedPlant]:
        return [_plant((0.0, -0.9 * float(np.cos(0.5 * np.pi * values[0]))))]

    found = minimise(family, GridSchedule((0.0,), (0, 0), 2), RECENTRING)
    assert len(found.points) > 2
    assert (
        found.optimum
        > 1.05 * minimise(lambda values: [_plant((0.0, 0.0))], GridSchedule(()), RECENTRING).optimum
    )
    plant = family((0.05,))[0]
    assert norm(plant.closed(found.frozen(plant, (0.05,))))[0] <= found.gamma * (1.0 + 1e-6)


def test_basis_and_its_derivative() -> None:
    basis, values, motion, step = (
        ParameterBasis(2, (0, 2)),
        (0.3, 9.0, -0.7),
        (1.5, 4.0, -2.0),
        1e-6,
    )
    assert basis.terms == ((), (0,), (2,), (0, 0), (0, 2), (2, 2))
    np.testing.assert_allclose(basis.at(values), [1.0, 0.3, -0.7, 0.09, -0.21, 0.49])
    moved = (
        basis.at(np.add(values, step * np.array(motion)))
        - basis.at(np.subtract(values, step * np.array(motion)))
    ) / (2 * step)
    np.testing.assert_allclose(basis.along(values, motion), moved, rtol=1e-8, atol=1e-8)


def test_what_cannot_be_stabilised_ends_in_one_error() -> None:
    plant = _plant((0.0, 0.0))
    stuck = GeneralisedPlant(
        plant.a + 300.0 * np.eye(len(plant.a)),
        *(getattr(plant, n) for n in ("b1", "b2", "c1", "c2", "d11", "d12", "d21")),
        0.0,
    )
    unseen = GeneralisedPlant(
        stuck.a, stuck.b1, 0.0 * stuck.b2, stuck.c1, stuck.c2, stuck.d11, stuck.d12, stuck.d21, 0.0
    )
    with pytest.raises(NoSolutionError):
        minimise(lambda values: [unseen], GridSchedule((0.0,), (1, 1), 2), RECENTRING)


def test_a_search_that_never_holds_between_the_points_ends_after_twelve_refinements(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each refinement adds the points that fail; the grid of three points grows to fifteen."""
    grids = []

    def solved(self: _GridSearch) -> tuple[Matrix, Matrix, float]:
        grids.append(len(self.grid))
        return np.eye(1), np.eye(1), 1.0

    monkeypatch.setattr(_GridSearch, "solved", solved)
    monkeypatch.setattr(_GridSearch, "failing", lambda *_: [(0.3,)])
    schedule = GridSchedule((0.0,), (0, 0), 3)
    with pytest.raises(NoSolutionError, match="fail between its points after 12 refinements"):
        minimise(lambda values: [_plant((0.0, values[0]))], schedule, RECENTRING)
    assert grids == list(range(3, 15))


@pytest.mark.parametrize(
    ("values", "least"), [((1.0, 4.0), 0.25), ((-8.0, 2.0), -1.0), ((-1.0, 5.0), -0.2)]
)
@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_the_margin_of_an_inequality_has_no_unit(
    values: tuple[float, float], least: float, unit: float
) -> None:
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    assert _least(unit * turn @ np.diag(values) @ turn.T) == pytest.approx(least, rel=1e-12)
