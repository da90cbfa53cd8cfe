"""The rebuilt loop against a simulation of it, sample by sample, and against a hand-scanned Nyquist curve."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.documents.controller import StateSpace
from frictool.plant.polytope import PlantPoint
from frictool.plant.sampled import sampled_axis
from frictool.verify.speed_loop import check_loop, matrices

CLUTCH = PlantPoint("clutch", 1.32e-5, 3.81e-4, 0.099, 0.0134)
PERIOD, LAG = 1e-3, 0.003
# a proportional controller with a lead, and one that is far too strong
GENTLE = StateSpace(((0.5,),), ((1.0,),), ((-12.0,),), ((30.0,),))
VIOLENT = StateSpace(((0.5,),), ((1.0,),), ((-1200.0,),), ((3000.0,),))


def _simulated_growth(system: StateSpace, delay: int, samples: int = 4000) -> float:
    """Ratio of the late to the early size of the loop's response to an initial position error."""
    a, b, c, d = matrices(system)
    axis = sampled_axis(CLUTCH, LAG, PERIOD)
    x, xk, line, sizes = np.array([0.0, 0.0, 1.0]), np.zeros(len(a)), [0.0] * delay, []
    for _ in range(samples):
        eta = float((axis.c_eta @ x)[0])
        line.append(float((c @ xk + d[0] * eta)[0]))
        xk = a @ xk + b[:, 0] * eta
        x = axis.a @ x + axis.b_drive[:, 0] * line.pop(0)
        sizes.append(abs(eta))
    return max(sizes[-200:]) / max(sizes[:200])


@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize(("system", "stable"), [(GENTLE, True), (VIOLENT, False)])
def test_stability_is_what_the_simulated_loop_does(system: StateSpace, stable: bool, delay: int) -> None:
    check = check_loop(system, CLUTCH, LAG, PERIOD, delay)
    assert check.stable is stable
    with np.errstate(over="ignore", invalid="ignore"):
        growth = _simulated_growth(system, delay, 4000 if stable else 300)
    assert (growth < 0.5) is stable


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_modulus_margin_is_the_distance_of_the_nyquist_curve(delay: int) -> None:
    a, b, c, d = matrices(GENTLE)
    axis = sampled_axis(CLUTCH, LAG, PERIOD)
    nearest = np.inf
    for angle in np.geomspace(1e-4, np.pi, 20_000):
        z = np.exp(1j * angle)
        plant = -(axis.c_eta @ np.linalg.solve(z * np.eye(3) - axis.a, axis.b_drive))[0, 0]
        control = (c @ np.linalg.solve(z * np.eye(1) - a, b) + d)[0, 0]
        nearest = min(nearest, abs(1.0 + plant * control * z**-delay))
    assert check_loop(GENTLE, CLUTCH, LAG, PERIOD, delay).modulus_margin == pytest.approx(nearest, rel=1e-4)


def test_delay_costs_margin() -> None:
    margins = [check_loop(GENTLE, CLUTCH, LAG, PERIOD, delay).modulus_margin for delay in (0, 1, 2)]
    assert margins == sorted(margins, reverse=True)
