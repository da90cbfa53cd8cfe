"""configs/clutch/mechanism.yaml says what studies/clutch/mechanism_curves.py computes, and what the
thesis publishes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from frictool.documents.mechanism import Cam, Curve, FrictionOf, Hydraulic, Mechanism, Rack, Spring
from frictool.documents.registry import load
from studies.clutch.mechanism_curves import BRUSHES, RATIO, TRAVEL, curves, lines, rotor_torque

PATH = Path(__file__).parents[2] / "configs" / "clutch" / "mechanism.yaml"
THETA = np.linspace(0.0, TRAVEL, 1261)


def _at(curve: Curve, x: np.ndarray) -> np.ndarray:
    return PchipInterpolator(curve.position.values, curve.value.values)(
        np.clip(x, curve.position.values[0], curve.position.values[-1])
    )


@pytest.fixture(scope="module")
def mechanism() -> Mechanism:
    return load(PATH, Mechanism)


def forces(mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray, float]:
    """mu_c F_s1 and F_res [N] over THETA, and r/eta."""
    rack, hydraulics, cam, clutch = (
        mechanism.links[name] for name in ("rack", "hydraulics", "compensation", "clutch")
    )
    assert isinstance(rack, Rack)
    assert isinstance(hydraulics, Hydraulic)
    assert isinstance(cam, Cam)
    assert isinstance(clutch, Spring)
    assert clutch.force is not None
    x, areas = rack.radius.value * THETA, hydraulics.area_a.value / hydraulics.area_b.value
    pressing = _at(cam.force, x)
    residual = areas * _at(clutch.force, areas * x) - pressing * np.tan(_at(cam.angle, x))
    return cam.friction_coefficient * pressing, residual, rack.radius.value / rack.efficiency


def test_the_file_holds_the_curves_of_the_script() -> None:
    text = [line.strip() for line in PATH.read_text().splitlines()]
    for name in curves():
        wanted = [line.strip() for line in lines(name)]
        assert any(text[at : at + len(wanted)] == wanted for at in range(len(text))), name


def test_in_slip_the_rotor_feels_the_friction_that_was_identified(mechanism: Mechanism) -> None:
    friction, residual, to_rotor = forces(mechanism)
    for found, published in zip(
        (friction + residual, friction - residual), rotor_torque(THETA), strict=True
    ):
        assert (
            np.abs(BRUSHES + to_rotor * found - published).max() < 5e-4
        )  # N m, of 0.05 to 0.19: monotone cubics flatten the extrema


def test_at_rest_it_holds_what_was_identified_but_for_the_tenth_of_the_springs_residual(
    mechanism: Mechanism,
) -> None:
    friction, residual, to_rotor = forces(mechanism)
    for found, published in zip(
        (1.1 * friction + residual, 1.1 * friction - residual), rotor_torque(THETA), strict=True
    ):
        assert (
            np.abs(1.1 * BRUSHES + to_rotor * found - 1.1 * published).max()
            < 0.1 * to_rotor * np.abs(residual).max() + 5e-4
        )


def test_it_is_irreversible_over_the_whole_travel(mechanism: Mechanism) -> None:
    friction, residual, _ = forces(mechanism)
    assert np.all(np.abs(residual) < friction)  # (2.27), to either side


def test_sizes_are_those_of_the_text(mechanism: Mechanism) -> None:
    rack, brushes = mechanism.links["rack"], mechanism.links["brushes"]
    assert isinstance(rack, Rack)
    assert isinstance(brushes, FrictionOf)
    assert rack.backlash is not None
    assert rack.backlash.width.value == 3.0
    assert rack.backlash.width.value * rack.radius.value < 0.7e-3
    rotor, cart, slave = (mechanism.blocks[name] for name in ("rotor", "cart", "slave"))
    assert rotor.inertia is not None
    assert cart.mass is not None
    assert slave.mass is not None
    assert (
        RATIO**2 * (cart.mass.value + 0.36 * slave.mass.value) < 2e-3 * rotor.inertia.value
    )  # "negligible", 2.2.4
    assert brushes.parameters["coulomb"].value == BRUSHES
