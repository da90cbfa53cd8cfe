"""The linearised mechanism against closed forms: gear (2.4)-(2.5), belt (2.6)-(2.9), lumped
inertias, modes of chains."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.plant.mechanism.linearisation import linearise
from tests.support.belt_reference import belt
from tests.support.mechanism_documents import TRAIN, assembled

GEAR = """\
format: mechanism/1
name: gear
blocks: {{a: {{inertia: {{value: 0.02, unit: kg m^2}}}}, b: {{inertia: {{value: 0.3,
  unit: kg m^2}}}}}}
links:
  pair: {{kind: gear, between: [a, b], ratio: 0.4, efficiency: 0.8{compliance}}}
sources: {{motor: {{on: a, drive: effort}}}}
sensors: {{wheel: {{on: b, measures: velocity}}}}
"""
SOFT = (
    ", compliance: {stiffness: {value: 50, unit: N m/rad}, damping: {value: 0.7, unit: N m s/rad}}"
)
POSITIVE = st.floats(0.05, 20.0)


@given(*(POSITIVE,) * 6)
def test_the_belts_transfer_is_that_of_its_free_bodies(
    ja: float, jb: float, ra: float, rb: float, kr: float, kv: float
) -> None:
    """(2.7) with K_r + K_v s along the belt, from J_A s^2 a = u + r_A f, J_B s^2 b = -r_B f, f =
    (K_r + K_v s)(r_B b - r_A a)."""
    found = linearise(belt(ja, jb, kr, kv, ra, rb)).transfer("torque", "out")
    frequency = np.geomspace(1e-2, 1e3, 12)
    s = 1j * frequency
    link = kr + kv * s
    by_hand = ra * rb * link / (s**2 * (ja * jb * s**2 + (ja * rb**2 + jb * ra**2) * link))
    assert np.allclose(found.response(frequency)[:, 0, 0], by_hand, rtol=1e-9, atol=0.0)


def test_the_belts_mode_and_its_rigid_limit() -> None:
    """(2.8), K_v -> 0: poles at 0, 0 and +-j sqrt(K_r (J_A + J_B)/(J_A J_B)); (2.9), no compliance:
    the inertia J_A + J_B."""
    ja, jb = 2e-3, 5e-3
    free = linearise(belt(ja, jb, 40.0, 0.0))
    (mode,) = free.modes()
    assert mode.frequency == pytest.approx(np.sqrt(40.0 * (ja + jb) / (ja * jb)), rel=1e-12)
    assert mode.damping == pytest.approx(0.0, abs=1e-12)
    assert mode.blocks["a"] == pytest.approx(
        jb / (ja + jb), rel=1e-9
    )  # equal momenta: energies as 1/J
    w = np.array([3.0, 30.0, 900.0])
    by_hand = 1.0 / (ja * jb / 40.0 * w**4 - (ja + jb) * w**2)
    assert np.allclose(free.transfer("torque", "out").response(w)[:, 0, 0], by_hand, rtol=1e-11)
    lumped = linearise(belt(ja, jb))
    assert lumped.mass == pytest.approx(np.array([[ja + jb]]))
    assert lumped.modes() == ()


def test_the_gear_with_efficiency(tmp_path: Path) -> None:
    """(2.5) with r/eta: the eigenvalues of its matrix; (2.3): J_A + r^2 J_B/eta where power flows
    from a to b."""
    r, eta, ja, jb, k, ki = 0.4, 0.8, 0.02, 0.3, 0.7, 50.0
    soft = linearise(
        assembled(GEAR.format(compliance=SOFT), tmp_path), efficiency="driving"
    ).state_space()
    by_hand = np.array(
        [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-r * r / eta * ki / ja, -r / eta * ki / ja, -r * r / eta * k / ja, -r / eta * k / ja],
            [-r * ki / jb, -ki / jb, -r * k / jb, -k / jb],
        ]
    )
    assert np.allclose(soft.a, by_hand, rtol=1e-12)
    rigid = assembled(GEAR.format(compliance=""), tmp_path)
    assert linearise(rigid, efficiency="driving").mass == pytest.approx(
        np.array([[ja + r * r * jb / eta]])
    )
    assert linearise(rigid).mass == pytest.approx(np.array([[ja + r * r * jb]]))
    s = 1e-3j  # slow: the compliant gear moves as the rigid one
    slow = (
        linearise(assembled(GEAR.format(compliance=SOFT), tmp_path), efficiency="driving")
        .transfer("motor", "wheel")
        .response(1e-3)
    )
    assert slow[0, 0, 0] == pytest.approx(-r / ((ja + r * r * jb / eta) * s), rel=1e-6)


def test_play_is_closed_or_open(tmp_path: Path) -> None:
    train = assembled(TRAIN, tmp_path)
    whole = linearise(train)
    assert whole.mass == pytest.approx(
        np.array([[2e-5 + 0.25**2 * 3e-4 + (0.25 * 0.01) ** 2 * 0.5]])
    )
    assert whole.stiffness == pytest.approx(np.array([[2000.0 * (0.25 * 0.01) ** 2]]))
    apart = linearise(train, closed=())
    assert apart.roots == (0, 2)
    assert apart.mass == pytest.approx(np.diag([2e-5 + 0.25**2 * 3e-4, 0.5]))
    assert apart.modes()[0].frequency == pytest.approx(np.sqrt(2000.0 / 0.5))
    with pytest.raises(ValueError, match="reducer, no link with backlash; allowed: rack"):
        linearise(train, closed=("reducer",))


def test_a_cams_slope_acts_as_a_negative_stiffness(tmp_path: Path) -> None:
    """force tan(angle): its derivative is what the product rule gives, from the points' own
    cubics."""
    text = """\
format: mechanism/1
name: cam
blocks: {cart: {mass: {value: 2, unit: kg}}}
links:
  roller:
    kind: cam
    on: cart
    force: {position: {values: [0, 10], unit: mm}, value: {values: [300, 100], unit: N}}
    angle: {position: {values: [0, 10], unit: mm}, value: {values: [0, 30], unit: deg}}
    friction_coefficient: 0.1
sources: {push: {on: cart, drive: effort}}
sensors: {scale: {on: cart}}
"""
    cart = linearise(assembled(text, tmp_path), position=np.array([0.004]))
    force, angle, slopes = 220.0, np.radians(12.0), (-2e4, np.radians(3e3))
    steep = slopes[0] * np.tan(angle) + force / np.cos(angle) ** 2 * slopes[1]
    assert cart.stiffness[0, 0] == pytest.approx(-steep, rel=1e-4)
    assert linearise(assembled(text, tmp_path), position=np.array([0.02])).stiffness[0, 0] == 0.0


def test_the_modes_of_a_long_chain(tmp_path: Path) -> None:
    """n equal masses in a row, free ends: 2 sqrt(k/m) sin(pi i/2n), i = 1 .. n - 1; the motion of
    the whole is no mode."""
    n, mass, stiffness = 20, 0.3, 4e4
    blocks = "\n".join(f"  m{i}: {{mass: {{value: {mass}, unit: kg}}}}" for i in range(n))
    soft = "{{stiffness: {{value: 4e4, unit: N/m}}, damping: {{value: 8, unit: N s/m}}}}"
    link = f"{{{{kind: coupling, between: [m{{0}}, m{{1}}], compliance: {soft}}}}}"
    links = "\n".join(f"  c{i}: " + link.format(i, i + 1) for i in range(n - 1))
    text = (
        f"format: mechanism/1\nname: chain\nblocks:\n{blocks}\nlinks:\n{links}\nsources: "
        f"{{push: {{on: m0, drive: effort}}}}\n"
    )
    modes = linearise(assembled(text, tmp_path)).modes()
    w = 2.0 * np.sqrt(stiffness / mass) * np.sin(np.pi * np.arange(1, n) / (2 * n))
    assert [mode.frequency for mode in modes] == pytest.approx(w, rel=1e-9)
    assert [mode.damping for mode in modes] == pytest.approx(
        0.5 * w * 8.0 / stiffness, rel=1e-8
    )  # of Rayleigh damping
    assert all(
        sum(mode.blocks.values()) == pytest.approx(1.0)
        and sum(mode.links.values()) == pytest.approx(1.0)
        for mode in modes
    )
