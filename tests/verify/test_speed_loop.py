"""The rebuilt loop against a simulation of it, sample by sample, and against a hand-scanned Nyquist
curve."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.plant.linear_axis import linear_axis
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.verify.speed_loop import check_loop
from tests.verify.gentle_loop import GENTLE, LAG, PERIOD

CLUTCH = PlantPoint("clutch", 1.32e-5, 3.81e-4, 0.099, 0.0134)
VIOLENT = Lti(GENTLE.a, GENTLE.b, 100.0 * GENTLE.c, 100.0 * GENTLE.d, PERIOD)


def _simulated_growth(system: Lti, delay: int, samples: int = 4000) -> float:
    """Ratio of the late to the early size of the loop's response to an initial position error."""
    axis = linear_axis(CLUTCH.rates, LAG, PERIOD).system
    x, xk, line, sizes = np.array([0.0, 0.0, 1.0]), np.zeros(system.order), [0.0] * delay, []
    for _ in range(samples):
        eta = float(x[2])
        line.append(float((system.c @ xk + system.d[0] * eta)[0]))
        xk = system.a @ xk + system.b[:, 0] * eta
        x = axis.a @ x + axis.b[:, 0] * line.pop(0)
        sizes.append(abs(eta))
    return max(sizes[-200:]) / max(sizes[:200])


@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize(("system", "stable"), [(GENTLE, True), (VIOLENT, False)])
def test_stability_is_what_the_simulated_loop_does(system: Lti, stable: bool, delay: int) -> None:
    check = check_loop(system, CLUTCH.rates, LAG, delay)
    assert check.stable is stable
    with np.errstate(over="ignore", invalid="ignore"):
        growth = _simulated_growth(system, delay, 4000 if stable else 300)
    assert (growth < 0.5) is stable


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_modulus_margin_is_the_distance_of_the_nyquist_curve(delay: int) -> None:
    axis = linear_axis(CLUTCH.rates, LAG, PERIOD).system
    z = np.exp(1j * np.geomspace(1e-4, np.pi, 20_000))
    plant = -np.linalg.solve(z[:, None, None] * np.eye(3) - axis.a, axis.b[:, :1])[:, 2, 0]
    control = (GENTLE.c @ GENTLE.b)[0, 0] / (z - GENTLE.a[0, 0]) + GENTLE.d[0, 0]
    nearest = np.min(np.abs(1.0 + plant * control * z**-delay))
    assert check_loop(GENTLE, CLUTCH.rates, LAG, delay).modulus_margin == pytest.approx(
        nearest, rel=1e-4
    )


def test_delay_costs_margin() -> None:
    margins = [check_loop(GENTLE, CLUTCH.rates, LAG, delay).modulus_margin for delay in (0, 1, 2)]
    assert margins == sorted(margins, reverse=True)
