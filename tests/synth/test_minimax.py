"""The minimax controller: what it claims is the true worst norm, nothing near it is better, and
what was asked of it holds."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.linear_axis import AxisRates
from frictool.synth.minimax import search
from frictool.synth.minimax_descent import DescentPoint, MinimaxDescent
from frictool.synth.structured_controller import StructuredController
from frictool.verify.hinf_norm import gains, norm
from frictool.verify.speed_loop import check_loop

PERIOD, LAG = 1e-3, 3e-3
EXTREMES = (
    AxisRates(836.0, 0.0, 1176.0),
    AxisRates(1261.0, 68.0, 16216.0),
)  # of the clutch's polytope
POSITION = PlantWeights(template(20.0, 0.5, 2.0 / 63.0), 0.1, 0.05)
SPEED = PlantWeights(template(40.0, 0.5, 2.0 / 63.0), 0.03, 0.5, 0.5, FirstOrderWeight(0.01))


def _plants(period: float, delay: int, speed: bool = False) -> list[GeneralisedPlant]:
    controlled, weights = ("speed", SPEED) if speed else ("position", POSITION)
    return [generalised_plant(controlled, rates, LAG, weights, period, delay) for rates in EXTREMES]


def _structure(order: int, period: float, speed: bool = False) -> StructuredController:
    return StructuredController(
        order, not speed, not speed, 2000.0, 80.0 if speed else 40.0, 2.0, period
    )


@cache
def _found(
    order: int, period: float = PERIOD, margin: float = 0.0, speed: bool = False
) -> DescentPoint:
    plants = _plants(period, 1 if period else 0, speed)
    return search(_structure(order, period, speed), plants[-1:] if speed else plants, margin)


@pytest.mark.parametrize("period", [pytest.param(0.0, marks=pytest.mark.accept), PERIOD])
def test_the_norm_is_true_and_nothing_near_is_better(period: float) -> None:
    """Against a slow scan of the closed loops, and against perturbed parameters, small and not so
    small."""
    structure, plants, found = (
        _structure(3, period),
        _plants(period, 1 if period else 0),
        _found(3, period),
    )
    k = structure.system(found.parameters)
    w = np.geomspace(1e-3, 0.9999 * np.pi / PERIOD, 20_000)
    scanned = max(float(np.max(gains(plant.closed(k), w))) for plant in plants)
    assert all(plant.closed(k).stable for plant in plants)
    assert found.worst == pytest.approx(scanned, rel=1e-5)
    random, (low, high) = np.random.default_rng(3), structure.limits()
    for size in np.repeat([1e-3, 1e-2, 1e-1], 15):
        near = np.clip(
            found.parameters * (1.0 + size * random.normal(size=structure.size)), low, high
        )
        k = structure.system(near)
        assert max(norm(plant.closed(k))[0] for plant in plants) > found.worst * (1.0 - 1e-4)


@pytest.mark.accept
def test_more_order_is_never_worse_and_both_vertices_are_level() -> None:
    assert _found(4).worst <= _found(3).worst * (1.0 + 1e-6)
    k = _structure(4, PERIOD).system(_found(4).parameters)
    first, second = (norm(plant.closed(k))[0] for plant in _plants(PERIOD, 1))
    assert first == pytest.approx(second, rel=1e-2)


def test_integrator_and_bound_are_in_the_result() -> None:
    k = _structure(3, PERIOD).system(_found(3).parameters)
    assert k.a[0, 0] == 1.0
    poles = np.linalg.eigvals(k.a[1:, 1:])
    assert np.all(np.abs(2.0 / PERIOD * (poles - 1.0) / (poles + 1.0)) <= 2000.0 * (1.0 + 1e-6))


def test_a_modulus_margin_is_kept_at_a_price() -> None:
    """Without it the margin is smaller, with it the norm is larger; the margin is the sampled
    loop's own, found by another route."""
    structure = _structure(1, PERIOD, speed=True)

    def margin(point: DescentPoint) -> float:
        return check_loop(structure.system(point.parameters), EXTREMES[-1], LAG, 1).modulus_margin

    free = _found(1, speed=True)
    asked = margin(free) + 0.02
    kept = _found(1, margin=asked, speed=True)
    assert margin(kept) >= asked * (1.0 - 2e-4)
    assert kept.worst > free.worst


def test_a_margin_out_of_reach_is_refused() -> None:
    """|S| is 1 at infinity, so that no loop keeps more than 1."""
    with pytest.raises(NoSolutionError, match=r"has a modulus margin of 0\.\d+ < 1\.2"):
        _found(1, margin=1.2, speed=True)


def test_no_start_that_stabilises_is_refused() -> None:
    """Without a lead in it, no integrator stabilises a double integrator."""
    plants = [generalised_plant("position", AxisRates(1000.0, 0.0, 1e3), LAG, POSITION, PERIOD, 1)]
    with pytest.raises(NoSolutionError, match="order 1"):
        search(_structure(1, PERIOD), plants, 0.0)


def test_the_same_seed_gives_the_same_controller_and_progress_is_told() -> None:
    told: list[str] = []
    plants = _plants(PERIOD, 1, speed=True)[-1:]
    again = search(_structure(1, PERIOD, speed=True), plants, 0.0, progress=told.append)
    assert np.array_equal(again.parameters, _found(1, speed=True).parameters)
    assert any("order 1, worst norm" in line for line in told)


def test_a_descent_never_ends_above_its_start() -> None:
    plants = _plants(PERIOD, 1)
    structure = _structure(3, PERIOD)
    descent = MinimaxDescent(structure, plants, 0.05)
    start = _found(3).parameters * np.array([1.2, 0.9, 1.3, 0.7, 1.0])[: structure.size]
    start = np.clip(start, *structure.limits())
    before = descent.point(start)
    after = descent.run(start, 3)
    assert np.isfinite(before.worst)
    assert after.worst <= before.worst


def test_unstable_starts_stay_where_they_are() -> None:
    descent = MinimaxDescent(_structure(3, PERIOD), _plants(PERIOD, 1), 0.05)
    wild = _found(3).parameters.copy()
    wild[2:] *= 1e3
    assert np.isinf(descent.coarse(wild))
    assert np.isinf(descent.run(wild, 3).worst)
