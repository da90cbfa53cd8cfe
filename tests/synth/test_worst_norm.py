"""Gains and slopes of the worst norm against the closed loop itself and against differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.synth.structured_controller import StructuredController
from frictool.synth.worst_norm import OpenLoopResponses, all_stable, sensitivity_plant, true_norms
from frictool.verify.hinf_norm import gains, norm
from frictool.verify.speed_loop import closed_loop

WEIGHTS = PlantWeights(template(40.0, 0.5, 2.0 / 63.0), 0.03, 0.5, 0.5, FirstOrderWeight(0.01))
FREQUENCIES = np.geomspace(1.0, 3000.0, 25)


def _plant(seed: int, period: float) -> GeneralisedPlant:
    random = np.random.default_rng(seed)
    rates = AxisRates(random.uniform(800, 1200), random.uniform(0, 60), random.uniform(1e3, 1e4))
    return generalised_plant(
        "speed" if seed % 2 else "position", rates, 3e-3, WEIGHTS, period, seed % 3 if period else 0
    )


def _structure(seed: int, period: float) -> tuple[StructuredController, np.ndarray]:
    random = np.random.default_rng(seed + 1)
    structure = StructuredController(3, bool(seed % 2), True, 2000.0, 60.0, 1.0, period)
    parameters = random.normal(size=structure.size)
    parameters[: structure.free] = random.uniform(
        [-2.0, 0.1][: structure.free] if structure.free == 2 else [-2.0, -2.0, 0.1], -0.1 + 0.6
    )
    return structure, np.minimum(parameters, structure.limits()[1])


@given(seed=st.integers(0, 10_000), period=st.sampled_from([0.0, 1e-3]))
def test_gains_are_those_of_the_closed_loop(seed: int, period: float) -> None:
    plant, (structure, parameters) = _plant(seed, period), _structure(seed, period)
    k = structure.system(parameters)
    open_loop = OpenLoopResponses.of(plant, FREQUENCIES)
    response, _ = structure.response(parameters, structure.points(FREQUENCIES))
    expected = gains(plant.closed(k), FREQUENCIES)
    assert open_loop.gains(response) == pytest.approx(expected, rel=1e-6)
    assert np.all(open_loop.bounds(response) >= expected * (1.0 - 1e-6))
    sensitivity = 1.0 / np.abs(1.0 - open_loop.p22 * response)
    assert open_loop.sensitivity().gains(response) == pytest.approx(sensitivity, rel=1e-12)


@given(seed=st.integers(0, 10_000), period=st.sampled_from([0.0, 1e-3]), steep=st.booleans())
def test_slopes_are_differences(seed: int, period: float, steep: bool) -> None:
    plant, (structure, parameters) = _plant(seed, period), _structure(seed, period)
    open_loop = OpenLoopResponses.of(plant, FREQUENCIES)
    open_loop = open_loop.sensitivity() if steep else open_loop
    s = structure.points(FREQUENCIES)
    response, by = structure.response(parameters, s)
    slopes = open_loop.slopes(response, by)
    here = open_loop.gains(response)
    for j in range(structure.size):
        step = 1e-5 * np.eye(structure.size)[j]
        up, down = (
            open_loop.gains(structure.response(parameters + side * step, s)[0])
            for side in (1.0, -1.0)
        )
        # a second singular value that is as large bends the gain: only smooth places are compared
        smooth = np.abs(up + down - 2.0 * here) < 1e-7 * here
        scale = np.abs(slopes[:, j])
        assert np.all(
            np.abs((up - down) / 2e-5 - slopes[:, j])[smooth] < (1e-3 * scale + 1e-6 * here)[smooth]
        )
        assert np.sum(smooth) > 10


def test_the_sensitivity_plant_closes_to_the_sensitivity() -> None:
    rates = AxisRates(1015.0, 29.0, 7500.0)
    k = Lti(np.array([[0.3]]), np.array([[1.0]]), np.array([[-3.0]]), np.array([[6.0]]), 1e-3)
    plant = generalised_plant("speed", rates, 3e-3, WEIGHTS, 1e-3, 1)
    loop = closed_loop(k, rates, 3e-3, 1)
    assert norm(sensitivity_plant(plant).closed(k))[0] == pytest.approx(norm(loop)[0], rel=1e-6)
    assert all_stable(k, [plant]) == loop.stable


def test_hints_change_the_time_only() -> None:
    plants = [_plant(seed, 1e-3) for seed in range(6)]
    k = Lti(np.array([[0.3]]), np.array([[1.0]]), np.array([[-3.0]]), np.array([[6.0]]), 1e-3)
    free = true_norms(k, plants)
    for hints in (
        [[] for _ in plants],
        [[3.0, 700.0] for _ in plants],
        [[at] if np.isfinite(at) else [] for _, at in free],
    ):
        for (value, _), (hinted, _) in zip(free, true_norms(k, plants, hints), strict=True):
            assert hinted == value or hinted == pytest.approx(value, rel=3e-6)
