"""Gear, rack, hydraulic link, cam and backlash against equations written by hand for each (thesis
2.1.4, 2.2.3)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.mechanism_motion import play

INERTIA = st.floats(1e-5, 1e-2)
RATIO = st.floats(0.02, 20.0)
EFFICIENCY = st.floats(0.55, 0.99)
ANGLE = st.just(0.0) | st.floats(1e-3, 0.8) | st.floats(-0.8, -1e-3)
EXAMPLES = settings(max_examples=25)

GEAR = """
blocks:
  a: {{inertia: {{value: {a!r}, unit: kg m^2}}}}
  b: {{inertia: {{value: {b!r}, unit: kg m^2}}}}
links:
  gear: {{kind: gear, between: [a, b], ratio: {ratio!r}, efficiency: {efficiency!r}{more}}}
sources:
  torque: {{on: a, drive: effort}}
"""


@given(INERTIA, INERTIA, RATIO, EFFICIENCY)
@EXAMPLES
def test_a_gear_drives_and_is_driven(a: float, b: float, ratio: float, efficiency: float) -> None:
    """(2.3): J_A w_A' = u - (r/eta) u_B, J_B w_B' = u_B while A drives; r eta_back in its place
    while A is driven by B."""
    back = 2.0 - 1.0 / efficiency  # what the same friction leaves the other way
    rate = math.sqrt(a + ratio**2 * b)
    found = play(
        GEAR.format(a=a, b=b, ratio=ratio, efficiency=efficiency, more=""),
        [[rate]] * 10 + [[-rate]] * 5,
    )
    up, down = rate / (a + ratio**2 * b / efficiency), -rate / (a + ratio**2 * b * back)
    speed = [up * 1e-3 * k for k in range(11)]
    speed += [speed[-1] + down * 1e-3 * k for k in range(1, 6)]
    still = next(
        (k for k, one in enumerate(speed) if one < 0.0), len(speed)
    )  # there A drives again
    np.testing.assert_allclose(
        found.speed("a")[:still], speed[:still], rtol=1e-9, atol=1e-12 * rate
    )
    np.testing.assert_allclose(found.speed("b"), -ratio * found.speed("a"), rtol=1e-9)
    np.testing.assert_allclose(found.position("b"), -ratio * found.position("a"), rtol=1e-9)


@given(INERTIA, INERTIA, RATIO, st.floats(0.05, 0.9), st.floats(100.0, 1e4))
@EXAMPLES
def test_a_gear_that_yields_is_off_by_what_its_stiffness_lets_it(
    a: float, b: float, ratio: float, damping: float, fast: float
) -> None:
    """(2.5): e = r theta_A + theta_B obeys e'' + 2 d w e' + w^2 e = r u/J_A; it ends at J_B
    w_B'/K_i, the error of the regularisation."""
    effective = 1.0 / (1.0 / b + ratio**2 / a)
    stiffness, viscous = effective * fast**2, 2.0 * damping * fast * effective
    compliant = (
        f", compliance: {{stiffness: {{value: {stiffness!r}, unit: N m/rad}}, damping: "
        f"{{value: {viscous!r}, unit: N m s/rad}}}}"
    )
    found = play(
        GEAR.format(a=a, b=b, ratio=ratio, efficiency=1.0, more=compliant),
        [[1.0]] * 40,
        period=1.0 / fast,
    )
    rest, t = ratio / a / fast**2, found.time
    ringing = fast * math.sqrt(1.0 - damping**2)
    fade = np.exp(-damping * fast * t) * (
        np.cos(ringing * t) + damping * fast / ringing * np.sin(ringing * t)
    )
    error = ratio * found.position("a") + found.position("b")
    np.testing.assert_allclose(error, rest * (1.0 - fade), atol=1e-6 * rest)
    together = ratio / (a + ratio**2 * b)
    assert rest == pytest.approx(b * together / stiffness, rel=1e-12)


RACK = """
blocks:
  pinion: {{inertia: {{value: {inertia!r}, unit: kg m^2}}}}
  load: {{mass: {{value: {mass!r}, unit: kg}}}}
links:
  rack: {{kind: rack, between: [pinion, load], radius: {{value: {radius!r}, unit: m}},
    efficiency: {efficiency!r}}}
sources:
  torque: {{on: pinion, drive: effort}}
  weight: {{on: load, drive: effort, effort: {{value: {weight!r}, unit: N}}}}
"""


@given(INERTIA, st.floats(0.1, 50.0), st.floats(1e-3, 0.1), EFFICIENCY, st.floats(-1.0, 2.0))
@EXAMPLES
def test_a_rack_lifts_holds_and_lowers_a_weight(
    inertia: float, mass: float, radius: float, efficiency: float, share: float
) -> None:
    """Up against r m g/eta, down with r m g eta_back, and between the two the friction of the teeth
    holds the weight."""
    back, force = 2.0 - 1.0 / efficiency, 9.81 * mass
    up, down = radius * force / efficiency, radius * force * back
    torque = down + share * (up - down)
    text = RACK.format(
        inertia=inertia, mass=mass, radius=radius, efficiency=efficiency, weight=-force
    )
    found = play(text, [[torque, 0.0]] * 20)
    if 0.0 < share < 1.0:
        rate = 0.0
    elif share >= 1.0:
        rate = (torque - up) / (inertia + radius**2 * mass / efficiency)
    else:
        rate = (torque - down) / (inertia + radius**2 * mass * back)
        if radius * rate < -9.81:  # pushed down faster than it falls: the pinion drives again
            rate = (torque - up) / (inertia + radius**2 * mass / efficiency)
    np.testing.assert_allclose(
        found.speed("pinion"), rate * found.time, rtol=1e-8, atol=1e-9 * up / inertia * 1e-3
    )
    np.testing.assert_allclose(
        found.position("load"), radius * found.position("pinion"), rtol=1e-9, atol=1e-18
    )


def test_a_piston_moves_the_other_by_the_ratio_of_their_areas() -> None:
    """(2.16): x_B = S_A/S_B x_A, F_A = S_A/S_B F_B."""
    found = play(
        """
blocks:
  master: {mass: {value: 0.3, unit: kg}}
  slave: {mass: {value: 2, unit: kg}}
links:
  pipe: {kind: hydraulic, between: [master, slave], area_a: {value: 3, unit: cm^2},
    area_b: {value: 5, unit: cm^2}}
sources:
  push: {on: master, drive: effort}
""",
        [[7.0]] * 30,
    )
    np.testing.assert_allclose(
        found.speed("master"), 7.0 / (0.3 + 0.36 * 2.0) * found.time, rtol=1e-10
    )
    np.testing.assert_allclose(found.position("slave"), 0.6 * found.position("master"), rtol=1e-12)


CAM = """
blocks:
  cart: {{mass: {{value: {mass!r}, unit: kg}}}}
links:
  cam:
    kind: cam
    on: cart
    force: {{position: {{unit: m, values: [-10, 10]}}, value: {{unit: N, values: [{force!r},
      {force!r}]}}}}
    angle: {{position: {{unit: m, values: [-10, 10]}}, value: {{unit: rad, values: [{angle!r},
      {angle!r}]}}}}
    friction_coefficient: {friction!r}
    breakaway_ratio: {ratio!r}
sources:
  push: {{on: cart, drive: effort}}
"""


@given(st.floats(0.05, 5.0), st.floats(1.0, 1e3), ANGLE, st.floats(0.01, 0.9), st.floats(1.0, 1.5))
@EXAMPLES
def test_a_cam_pushes_and_presses(
    mass: float, force: float, angle: float, friction: float, ratio: float
) -> None:
    """(2.23) with the sign of (2.28): it starts where tan(alpha) is beyond the breakaway, with F_s1
    (tan(alpha) - mu_c)."""
    found = play(
        CAM.format(mass=mass, force=force, angle=angle, friction=friction, ratio=ratio),
        [[0.0]] * 20,
    )
    steep = math.tan(angle)
    starts = abs(steep) > ratio * friction
    rate = math.copysign(abs(steep) - friction, steep) * force / mass if starts else 0.0
    np.testing.assert_allclose(found.speed("cart"), rate * found.time, rtol=1e-9, atol=1e-12)


PLAY = """
blocks:
  a: {{inertia: {{value: {a!r}, unit: kg m^2}}}}
  b: {{inertia: {{value: {b!r}, unit: kg m^2}}}}
links:
  shaft: {{kind: coupling, between: [a, b], backlash: {{width: {{value: 0.2, unit: rad}},
    {flank}}}}}
sources:
  torque: {{on: a, drive: effort}}
"""


@given(INERTIA, INERTIA, st.just(0.0) | st.floats(1e-3, 0.95))
@EXAMPLES
def test_flanks_that_meet_keep_the_momentum_and_throw_back(
    a: float, b: float, restitution: float
) -> None:
    """A is driven through half the play, 0.1 rad, in 20 ms; Newton's law of impact there."""
    torque = 2.0 * 0.1 * a / 0.02**2
    found = play(PLAY.format(a=a, b=b, flank=f"restitution: {restitution!r}"), [[torque]] * 21)
    meets = 2.0 * 0.1 / 0.02
    after = meets * np.array([a - restitution * b, a * (1.0 + restitution)]) / (a + b)
    assert found.speed("b")[19] == 0.0
    gained = found.speed("b")[20:22] * b + found.speed("a")[20:22] * a
    np.testing.assert_allclose(gained, torque * found.time[20:22], rtol=1e-9)
    # a millisecond later: each as the impact left it, A driven on, or both together where they stay
    # in touch
    if restitution > 0.1:
        np.testing.assert_allclose(found.speed("b")[21], after[1], atol=1e-9 * meets)
        np.testing.assert_allclose(
            found.speed("a")[21], after[0] + torque / a * 1e-3, atol=1e-9 * meets
        )


@given(st.floats(0.02, 0.6), st.floats(200.0, 5000.0))
@EXAMPLES
def test_a_flank_that_yields_rebounds_by_its_damping_and_does_not_pull(
    damping: float, fast: float
) -> None:
    """A meets a heavy B at w: it leaves when the flank's force is back to 0, not when its stretch
    is; 4.4.4's rebound."""
    inertia, heavy = 1e-4, 1e2
    reduced = inertia * heavy / (inertia + heavy)
    stiffness, viscous = reduced * fast**2, 2.0 * damping * fast * reduced
    flank = (
        f"compliance: {{stiffness: {{value: {stiffness!r}, unit: N m/rad}}, damping: "
        f"{{value: {viscous!r}, unit: N m s/rad}}}}"
    )
    # reached in the first millisecond; at the flank after 10.5, gone from it after 27 at most, at
    # the other after 30
    speed = 10.0
    found = play(
        PLAY.format(a=inertia, b=heavy, flank=flank), [[speed * inertia / 1e-3]] + [[0.0]] * 28
    )
    ringing = math.sqrt(1.0 - damping**2)
    leaves = math.atan2(
        2.0 * damping * ringing, 2.0 * damping**2 - 1.0
    )  # w_d t at which e'' = 0, in (0, pi)
    thrown = math.exp(-damping / ringing * leaves) * (
        math.cos(leaves) - damping / ringing * math.sin(leaves)
    )
    left = speed * (inertia + thrown * heavy) / (inertia + heavy)
    assert found.speed("a")[-1] == pytest.approx(left, rel=1e-7)
