"""The sampled axis against integration of its differential equation, and the generalised plant against its parts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from frictool.plant.generalised import SpeedWeights, speed_plant
from frictool.plant.polytope import PlantPoint
from frictool.plant.sampled import sampled_axis

CLUTCH = PlantPoint("clutch", 1.32e-5, 3.81e-4, 0.099, 0.0134)


@settings(max_examples=25, deadline=None)
@given(
    scale=st.tuples(*[st.floats(0.1, 10.0)] * 3),
    lag=st.sampled_from([0.0, 1e-3, 3e-3]),
    drive=st.floats(-5, 5),
    reference=st.floats(-100, 100),
    friction=st.floats(-0.2, 0.2),
)
def test_one_period_equals_the_integrated_equation(
    scale: tuple[float, float, float], lag: float, drive: float, reference: float, friction: float
) -> None:
    point = PlantPoint("p", CLUTCH.inertia * scale[0], CLUTCH.viscous * scale[1], 0.1, CLUTCH.constant * scale[2])
    axis, period = sampled_axis(point, lag, 1e-3), 1e-3
    n = axis.a.shape[0]
    start = np.array([0.3, 40.0, 0.2])[3 - n :]

    def slope(_: float, x: np.ndarray) -> list[float]:
        i = x[0] if lag else drive
        acceleration = (point.constant * i - point.viscous * x[n - 2] - friction) / point.inertia
        return ([(drive - x[0]) / lag] if lag else []) + [acceleration, reference - x[n - 2]]

    exact = solve_ivp(slope, (0.0, period), start, rtol=1e-11, atol=1e-12).y[:, -1]
    held = axis.a @ start + axis.b_drive[:, 0] * drive + axis.b_reference[:, 0] * reference + axis.b_friction[:, 0] * friction
    assert held == pytest.approx(exact, rel=1e-7, abs=1e-9)


def test_weight_w2_has_the_gains_the_specification_asks_for() -> None:
    weights = SpeedWeights.of(z2=40.0, modulus_margin=0.5, static_error=2 / 63, disturbance=1.0, drive=1.0, command=1.0, noise=1.0)
    plant = speed_plant(CLUTCH, 0.003, 1e-3, 1, weights)

    def gain(z: complex) -> float:  # from the speed reference to z1 with the drive at zero: W2 itself
        identity = np.eye(plant.a.shape[0])
        return float(abs((plant.c1 @ np.linalg.solve(z * identity - plant.a, plant.b1) + plant.d11)[0, 0]))

    low, high = np.exp(1j * 1e-7), -1.0 + 0.0j
    assert gain(low) == pytest.approx(63 / 2, rel=1e-3)  # 1/e_stat (5.57)
    assert gain(high) == pytest.approx(0.5, rel=1e-9)  # M_mod (5.57)


@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize("lag", [0.0, 0.003])
def test_delay_and_lag_only_change_the_number_of_states(delay: int, lag: float) -> None:
    weights = SpeedWeights.of(40.0, 0.5, 2 / 63, 0.03, 0.5, 0.5, 0.01)
    plant = speed_plant(CLUTCH, lag, 1e-3, delay, weights)
    size = delay + (3 if lag else 2) + 1
    assert plant.a.shape == (size, size)
    # an impulse on the drive reaches eta after delay + 1 samples, and not before
    x = plant.b2[:, 0].copy()
    for sample in range(delay + 2):
        seen = float((plant.c2 @ x)[0])
        assert (seen != 0.0) == (sample >= delay)
        x = plant.a @ x
