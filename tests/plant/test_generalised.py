"""The sampled axis against integration of its differential equation, and the generalised plant
against its parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    UncertaintyChannel,
    generalised_plant,
    template,
)
from frictool.plant.linear_axis import linear_axis
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint

CLUTCH = PlantPoint("clutch", 1.32e-5, 3.81e-4, 0.099, 0.0134)


@settings(max_examples=25, deadline=None)
@given(
    scale=st.tuples(*[st.floats(0.1, 10.0)] * 3),
    lag=st.sampled_from([0.0, 1e-3, 3e-3]),
    drive=st.floats(-5, 5),
    reference=st.floats(-100, 100),
    friction=st.floats(-1.0, 1.0),
)
def test_one_period_equals_the_integrated_equation(
    scale: tuple[float, float, float], lag: float, drive: float, reference: float, friction: float
) -> None:
    point = PlantPoint(
        "p", CLUTCH.inertia * scale[0], CLUTCH.viscous * scale[1], 0.1, CLUTCH.constant * scale[2]
    )
    period = 1e-3
    axis = linear_axis(point.rates, lag, period).system
    n = axis.order
    start = np.array([0.3, 40.0, 0.2])[3 - n :]

    def slope(_: float, x: np.ndarray) -> list[float]:
        i = x[0] if lag else drive
        acceleration = (
            point.constant * i - point.viscous * x[n - 2] - point.coulomb * friction
        ) / point.inertia
        return ([(drive - x[0]) / lag] if lag else []) + [acceleration, reference - x[n - 2]]

    exact = solve_ivp(slope, (0.0, period), start, rtol=1e-11, atol=1e-12).y[:, -1]
    held = axis.a @ start + axis.b @ [drive, reference, friction, 0.0]
    assert held == pytest.approx(exact, rel=1e-7, abs=1e-9)


def test_weight_w2_has_the_gains_the_specification_asks_for() -> None:
    weights = PlantWeights(template(40.0, 0.5, 2 / 63), 1.0, 1.0, 1.0, FirstOrderWeight(1.0))
    plant = generalised_plant("speed", CLUTCH.rates, 0.003, weights, 1e-3, 1)

    def gain(
        z: complex,
    ) -> float:  # from the speed reference to z1 with the drive at zero: W2 itself
        identity = np.eye(plant.a.shape[0])
        return float(
            abs((plant.c1 @ np.linalg.solve(z * identity - plant.a, plant.b1) + plant.d11)[0, 0])
        )

    low, high = np.exp(1j * 1e-7), -1.0 + 0.0j
    assert gain(low) == pytest.approx(63 / 2, rel=1e-3)  # 1/e_stat (5.57)
    assert gain(high) == pytest.approx(0.5, rel=1e-9)  # M_mod (5.57)


@pytest.mark.parametrize("delay", [0, 1, 2])
@pytest.mark.parametrize("lag", [0.0, 0.003])
def test_delay_and_lag_only_change_the_number_of_states(delay: int, lag: float) -> None:
    weights = PlantWeights(template(40.0, 0.5, 2 / 63), 0.03, 0.5, 0.5, FirstOrderWeight(0.01))
    plant = generalised_plant("speed", CLUTCH.rates, lag, weights, 1e-3, delay)
    size = delay + (3 if lag else 2) + 1
    assert plant.a.shape == (size, size)
    # an impulse on the drive reaches eta after delay + 1 samples, and not before
    x = plant.b2[:, 0].copy()
    for sample in range(delay + 2):
        seen = float((plant.c2 @ x)[0])
        assert (seen != 0.0) == (sample >= delay)
        x = plant.a @ x


W = PlantWeights(
    template(20.0, 0.5, 2 / 63),
    0.1,
    0.05,
    0.3,
    FirstOrderWeight(0.01, 5000.0, 500.0),
    eta=2.0,
    uncertainty=FirstOrderWeight(1.0, 1e3, 10.0),
)
DELTA = UncertaintyChannel(drive=0.3, viscous=0.02, friction=-0.4)


@pytest.mark.parametrize("controlled", ["position", "speed"])
def test_every_transfer_is_the_one_drawn_in_the_figure(controlled: str) -> None:
    """Each w -> z, w -> y, u -> z and u -> y against transfer functions written out by hand."""
    rates = replace(CLUTCH.rates, push=700.0)
    plant = generalised_plant(controlled, rates, 0.003, W, uncertainty=DELTA)
    for s in 1j * np.geomspace(0.1, 5e3, 15):
        w2 = W.error.gain * (s / 20.0 + 1) / (s / W.error.pole + 1)
        w4, w5 = 0.01 * (s / 5000 + 1) / (s / 500 + 1), (s / 1e3 + 1) / (s / 10 + 1)
        lag, v = 1.0 / (0.003 * s + 1), 1.0 / (s + rates.viscous)
        drive = {"reference": 0.0, "friction": 0.0, "noise": 0.0, "delta": 0.0, "u": lag}
        speed = {
            "reference": 0.0,
            "friction": -0.1 * rates.friction * v,
            "noise": 0.0,
            "delta": rates.push * v,
            "u": rates.drive * lag * v,
        }
        eta = {
            name: -value / s + (1.0 / s if name == "reference" and controlled == "speed" else 0.0)
            for name, value in speed.items()
        }
        is_reference = {name: float(name == "reference") for name in speed}
        expected = []
        for name in speed:
            error = (
                is_reference[name] - speed[name]
                if controlled == "speed"
                else is_reference[name] + eta[name]
            )
            measured = (
                eta[name]
                + (is_reference[name] if controlled == "position" else 0.0)
                + (w4 if name == "noise" else 0.0)
            )
            delta = uncertain(drive[name], speed[name], 0.1 * float(name == "friction"))
            expected.append(
                [
                    w2 * error,
                    0.05 * drive[name],
                    0.3 * float(name == "u"),
                    2.0 * eta[name],
                    w5 * delta,
                    measured,
                ]
            )
        whole_b, whole_c = np.hstack([plant.b1, plant.b2]), np.vstack([plant.c1, plant.c2])
        whole_d = np.block([[plant.d11, plant.d12], [plant.d21, np.zeros((1, 1))]])
        found = whole_c @ np.linalg.solve(s * np.eye(len(plant.a)) - plant.a, whole_b) + whole_d
        assert found == pytest.approx(np.array(expected).T, rel=1e-9, abs=1e-12)


def uncertain(drive: complex, speed: complex, friction: complex) -> complex:
    return DELTA.drive * drive + DELTA.viscous * speed + DELTA.friction * friction


def test_a_sampled_plant_tends_to_the_continuous_one() -> None:
    slow = generalised_plant("speed", CLUTCH.rates, 0.003, W)
    fast = generalised_plant("speed", CLUTCH.rates, 0.003, W, period=1e-6)
    for w in (3.0, 30.0, 300.0):
        continuous = (
            slow.c1 @ np.linalg.solve(1j * w * np.eye(len(slow.a)) - slow.a, slow.b2) + slow.d12
        )
        sampled = (
            fast.c1 @ np.linalg.solve(np.exp(1j * w * 1e-6) * np.eye(len(fast.a)) - fast.a, fast.b2)
            + fast.d12
        )
        assert sampled == pytest.approx(continuous, rel=1e-3)


def test_a_delay_without_samples_and_a_control_seen_at_once_are_refused() -> None:
    with pytest.raises(ValueError, match="needs a sampled plant"):
        generalised_plant("speed", CLUTCH.rates, 0.003, W, 0.0, 1)
    with pytest.raises(ValueError, match="D22"):
        GeneralisedPlant.of(
            Lti(np.zeros((1, 1)), np.ones((1, 2)), np.ones((2, 1)), np.ones((2, 2)), 0.0)
        )
