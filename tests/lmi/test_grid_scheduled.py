"""Scheduled controllers of the gridded synthesis: the inequality with the motion, rebuilt from loop
and P, and a loop that really moves."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.linalg import block_diag, expm

from frictool.lmi.gridded_controllers import (
    _ScheduledPlant,
    certified_gamma,
    lyapunov,
    scheduled_controllers,
)
from frictool.lmi.gridded_synthesis import GriddedSolution, GridSchedule, minimise
from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.verify.hinf_norm import norm

SPEED = 5.0  # half-widths per s
WEIGHTS = PlantWeights(template(20.0, 0.5, 2 / 63), 0.1, 0.05, 0.02, FirstOrderWeight(0.01))
NO_COMMAND = PlantWeights(template(20.0, 0.5, 2 / 63), 0.1, 0.05)  # D12 = 0
BOTH = pytest.mark.parametrize("weights", [WEIGHTS, NO_COMMAND], ids=["full rank", "D12 = 0"])


def _plant(value: float, weights: PlantWeights) -> GeneralisedPlant:
    return generalised_plant(
        "position",
        AxisRates(1000.0 * (1.0 + 0.4 * value), 40.0 - 20.0 * value, 12000.0),
        0.003,
        weights,
    )


@cache
def _found(weights: PlantWeights) -> GriddedSolution:
    return minimise(
        lambda values: [_plant(values[0], weights)], GridSchedule((SPEED,), (0, 1), 3), 1.1
    )


@BOTH
def test_inequality_holds_with_the_motion_between_the_points(weights: PlantWeights) -> None:
    found = _found(weights)
    points = [(float(value),) for value in np.linspace(-0.95, 0.95, 9)]
    controllers = scheduled_controllers(
        found, points, [_plant(value, weights) for (value,) in points]
    )
    for (value,), k in zip(points, controllers, strict=True):
        states = block_diag(found.t, np.eye(k.order))
        loop = _plant(value, weights).closed(k).transformed(states)
        p = states.T @ lyapunov(found, (value,)) @ states
        np.testing.assert_allclose(p, p.T, atol=1e-7 * np.max(np.abs(p)))
        assert np.linalg.eigvalsh(0.5 * (p + p.T))[0] > 0.0
        slope = (
            states.T
            @ (lyapunov(found, (value + 0.01,)) - lyapunov(found, (value - 0.01,)))
            @ states
            / 0.02
        )
        worst, unit = (
            0.0,
            found.frame.scale,
        )  # time in the frame's unit, in which the terms are of one size
        for speed in (-SPEED, SPEED):
            decrease = -unit * (loop.a.T @ p + p @ loop.a + speed * slope)
            assert np.linalg.eigvalsh(0.5 * (decrease + decrease.T))[0] > 0.0
            cross = np.vstack([loop.b.T @ p, loop.c])
            rest = np.block(
                [
                    [np.zeros((loop.b.shape[1],) * 2), loop.d.T],
                    [loop.d, np.zeros((len(loop.c),) * 2)],
                ]
            )
            worst = max(
                worst,
                np.linalg.eigvalsh(rest + unit * cross @ np.linalg.solve(decrease, cross.T))[-1],
            )
        assert worst <= found.gamma * (1.0 + 1e-5)
        assert certified_gamma(found, (value,), _plant(value, weights), k) == pytest.approx(
            worst, rel=1e-4
        )


@BOTH
def test_of_a_plant_that_rests_it_keeps_the_norm(weights: PlantWeights) -> None:
    found, points = _found(weights), [(-1.0,), (0.1,), (1.0,)]
    for (value,), k in zip(
        points,
        scheduled_controllers(found, points, [_plant(v, weights) for (v,) in points]),
        strict=True,
    ):
        assert norm(_plant(value, weights).closed(k))[0] <= found.gamma * (1.0 + 1e-6)


def test_a_loop_that_moves_keeps_gamma_in_simulation() -> None:
    """Plant and controller sweep their interval up and down at the full speed; the inputs are
    noise."""
    found, step, count = _found(WEIGHTS), 2e-4, 4000
    swing = np.abs((SPEED * step * np.arange(count) + 1.0) % 4.0 - 2.0) - 1.0
    levels = np.round(swing * 50.0) / 50.0
    values = sorted(set(levels.tolist()))
    controllers = scheduled_controllers(
        found, [(value,) for value in values], [_plant(value, WEIGHTS) for value in values]
    )
    loops = {
        value: _plant(value, WEIGHTS).closed(k)
        for value, k in zip(values, controllers, strict=True)
    }
    random, seen, given = np.random.default_rng(1), 0.0, 0.0
    x, w = np.zeros(loops[values[0]].order), np.zeros(3)
    flows = {
        value: expm(np.block([[loop.a, loop.b], [np.zeros((3, loop.order + 3))]]) * step)[
            : loop.order
        ]
        for value, loop in loops.items()
    }
    for value in levels.tolist():
        w = 0.98 * w + random.normal(size=3)  # slow enough to reach the loop
        z = loops[value].c @ x + loops[value].d @ w
        seen, given = seen + float(z @ z), given + float(w @ w)
        x = flows[value] @ np.concatenate([x, w])
    assert 0.05 * given < seen <= found.gamma**2 * given


def test_a_sum_of_two_controllers_is_judged_by_its_own_loop() -> None:
    found = _found(WEIGHTS)
    low, high = scheduled_controllers(
        found, [(-1.0,), (1.0,)], [_plant(-1.0, WEIGHTS), _plant(1.0, WEIGHTS)]
    )
    plant = _plant(0.0, WEIGHTS)
    middle = Lti(*(0.5 * (getattr(low, part) + getattr(high, part)) for part in "abcd"), 0.0)
    assert norm(plant.closed(middle))[0] <= certified_gamma(found, (0.0,), plant, middle)
    unstable = Lti(low.a, low.b, -low.c, -low.d, 0.0)
    assert certified_gamma(found, (0.0,), plant, unstable) == np.inf


def test_what_is_not_covered_is_refused() -> None:
    both = minimise(
        lambda values: [_plant(values[0], WEIGHTS)], GridSchedule((SPEED,), (1, 1), 2), 1.1
    )
    with pytest.raises(ValueError, match="basis of degree 0"):
        scheduled_controllers(both, [(0.0,)], [_plant(0.0, WEIGHTS)])


def test_the_weight_is_the_largest_half_decade_for_which_both_inequalities_hold() -> None:
    """Without full ranks e > 0 keeps the controller finite; it is not made smaller than needed."""
    found, value = _found(NO_COMMAND), (0.1,)
    plant = _plant(*value, NO_COMMAND)
    cell = _ScheduledPlant(found, value, found.frame.plant(plant).transformed(found.t))
    largest = next(e for e in 10.0 ** (-0.5 * np.arange(21)) if cell.holds(float(e)))
    (k,) = scheduled_controllers(found, [value], [plant])
    wanted = found.frame.back(cell.controller(float(largest)), 0.0)
    for part in "abcd":
        np.testing.assert_allclose(getattr(k, part), getattr(wanted, part), rtol=1e-9, atol=1e-12)
