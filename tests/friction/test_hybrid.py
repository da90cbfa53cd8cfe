"""Hybrid versions A, B, C: modes, forces and switches as printed; dissipation; no drift;
presliding."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.friction.hybrid_b import presliding_damping, presliding_stiffness
from frictool.friction.hybrid_kernels import SLIPPING, STUCK, is_captured
from frictool.friction.law import HybridKernels
from frictool.friction.law_registry import LAWS
from frictool.friction.reversal_memory import COUNT
from studies.rigs.table_3_1 import STRIBECK, TABLE_3_1, packed
from tests.support.law_drivers import EFFORT, MODE, POSITION, VELOCITY, hybrid_run, pointers
from tests.support.plain_laws import stribeck_curve

VERSIONS = ["hybrid_a", "hybrid_b", "hybrid_c"]
PRESLIDING = ["hybrid_b", "hybrid_c"]
EFFORTS = st.floats(-3, 3)
SPEEDS = st.floats(-3e-4, 3e-4)
SIGMA, F_C, F_S, Z_MAX = 1e-4, 1.0, 1.5, 1e-5


def kernels(name: str) -> HybridKernels:
    found = LAWS[name].kernels
    assert isinstance(found, HybridKernels)
    return found


def run(
    name: str, efforts: np.ndarray, step: float, stiffness: float = 0.0, **changes: float
) -> np.ndarray:
    return hybrid_run(
        *pointers(kernels(name)),
        efforts,
        stiffness,
        step,
        packed(LAWS[name], TABLE_3_1[name] | changes),
    )


@pytest.mark.parametrize("name", VERSIONS)
@given(
    v=SPEEDS,
    u=EFFORTS,
    share=st.floats(-1.2, 1.2),
    stuck=st.booleans(),
    clock=st.sampled_from([0.0, 2e-3]),
)
def test_switches_as_printed(
    name: str, v: float, u: float, share: float, stuck: bool, clock: float
) -> None:
    changes = {"hold_time": 1e-3} if name == "hybrid_a" else {}
    p = packed(LAWS[name], TABLE_3_1[name] | changes)
    z = kernels(name).reset(p)
    z[0] = clock if name == "hybrid_a" else share * Z_MAX
    after = kernels(name).mode_after(STUCK if stuck else SLIPPING, v, u, z, p)
    if not stuck:
        captured = (u < F_C and 0 < v < SIGMA) or (u > -F_C and -SIGMA < v < 0)
        assert after == (STUCK if captured else SLIPPING)
    elif name == "hybrid_a":
        free = abs(u) > F_S and (np.sign(u) == np.sign(v) or clock >= 1e-3)
        assert after == (SLIPPING if free else STUCK)
    else:
        broken = (z[0] >= Z_MAX and u > F_S and v >= 0) or (z[0] <= -Z_MAX and u < -F_S and v <= 0)
        assert after == (SLIPPING if broken else STUCK)


@pytest.mark.parametrize("name", VERSIONS)
@given(v=SPEEDS, u=EFFORTS, share=st.floats(-1.2, 1.2), stuck=st.booleans())
def test_no_instant_asks_for_two_switches(
    name: str, v: float, u: float, share: float, stuck: bool
) -> None:
    """3.5: C_{0->1} and C_{1->0} are never both true, so that the mode after a switch stays."""
    p = packed(LAWS[name], TABLE_3_1[name] | ({"hold_time": 1e-3} if name == "hybrid_a" else {}))
    law, mode = kernels(name), STUCK if stuck else SLIPPING
    z = law.reset(p)
    z[0] = 0.0 if name == "hybrid_a" else share * Z_MAX
    after = law.mode_after(mode, v, u, z, p)
    if after != mode:
        law.enter(after, v, u, z, p)
        assert law.mode_after(after, v, u, z, p) == after


@pytest.mark.parametrize("name", VERSIONS)
@given(v=st.floats(-0.5, 0.5), u=EFFORTS)
def test_slip_is_stribeck_under_newton(name: str, v: float, u: float) -> None:
    p = packed(LAWS[name], TABLE_3_1[name] | {"inertia": 2.0})
    z = kernels(name).reset(p)
    direction = np.sign(v) if v else math.copysign(1.0, u)
    expected = direction * stribeck_curve(v, STRIBECK) + 0.4 * v
    assert kernels(name).force(SLIPPING, v, u, z, p) == pytest.approx(expected, rel=1e-12)
    assert kernels(name).acceleration(SLIPPING, v, u, z, p) == pytest.approx(
        (u - expected) / 2.0, rel=1e-9, abs=1e-12
    )


@given(v=SPEEDS, u=EFFORTS, share=st.floats(-1.5, 1.5))
def test_stuck_forces(v: float, u: float, share: float) -> None:
    a, b, c = (packed(LAWS[name]) for name in VERSIONS)
    assert kernels("hybrid_a").force(STUCK, v, u, np.zeros(1), a) == u
    assert kernels("hybrid_a").acceleration(STUCK, v, u, np.zeros(1), a) == -1e3 * v
    spring = 1.5e5 * share * Z_MAX + 2 * math.sqrt(1.5e5) * v
    assert kernels("hybrid_b").force(STUCK, v, u, np.array([share * Z_MAX]), b) == pytest.approx(
        spring, rel=1e-12, abs=1e-12
    )
    z = kernels("hybrid_c").reset(c)
    z[0] = share * Z_MAX
    left = 1 - min(abs(round(share * 10)) / 10, 1)
    z[0] = round(share * 10) / 10 * Z_MAX
    virgin = F_S * np.sign(z[0]) * (1 - left * left)
    assert kernels("hybrid_c").force(STUCK, v, u, z, c) == pytest.approx(
        virgin + 2 * math.sqrt(1.5e5) * v, rel=1e-9, abs=1e-12
    )
    assert kernels("hybrid_c").acceleration(STUCK, v, u, z, c) == pytest.approx(
        u - virgin - 2 * math.sqrt(1.5e5) * v, rel=1e-9, abs=1e-9
    )


def test_stiffness_and_damping_are_those_of_table_3_1() -> None:
    p = packed(LAWS["hybrid_b"])
    assert presliding_stiffness(p) == pytest.approx(1.5e5, rel=1e-12)
    assert presliding_damping(p) == pytest.approx(2 * math.sqrt(1.5e5), rel=1e-12)


@given(
    v=st.floats(-0.5, 0.5),
    u=EFFORTS,
    stuck=st.booleans(),
    viscous=st.floats(0, 2),
    mass=st.floats(0.1, 10),
)
def test_version_a_dissipates_at_every_state(
    v: float, u: float, stuck: bool, viscous: float, mass: float
) -> None:
    """(3.42), (3.44), (3.45): V' <= (u - F_sec) v with V = m v^2/2."""
    p = packed(LAWS["hybrid_a"], TABLE_3_1["hybrid_a"] | {"viscous": viscous, "inertia": mass})
    mode, z = STUCK if stuck else SLIPPING, np.zeros(1)
    dry = kernels("hybrid_a").force(mode, v, u, z, p) - (0.0 if stuck else viscous * v)
    stored = mass * v * kernels("hybrid_a").acceleration(mode, v, u, z, p)
    supplied = (u - dry) * v
    assert stored <= supplied + 1e-12 * (1.0 + abs(stored) + abs(supplied))


@settings(derandomize=True, deadline=None, max_examples=8)
@given(seed=st.integers(0, 1000), size=st.floats(1.8, 4.0))
def test_version_a_dissipates_along_random_efforts_and_through_switches(
    seed: int, size: float
) -> None:
    """V(t_j) - V(t_i) <= int s dt (3.61): exact for the implicit midpoint rule, whose step changes
    V by h f(v_mid) v_mid."""
    law, p = (
        kernels("hybrid_a"),
        packed(
            LAWS["hybrid_a"],
            TABLE_3_1["hybrid_a"] | {"stribeck_velocity": 0.05, "capture_velocity": 0.2},
        ),
    )
    draw = np.random.default_rng(seed)
    efforts = size * np.interp(
        np.arange(1200),
        np.arange(0, 1300, 100),
        [*draw.uniform(-1, 1, 6), 1.0, *draw.uniform(-1, 1, 6)],
    )
    mode, v, z, step, switches, stored, supplied = STUCK, 0.0, np.zeros(1), 1e-3, 0, 0.0, 0.0
    for u in efforts:
        after = law.mode_after(mode, v, u, z, p)
        switches += after != mode
        mode, middle = after, v
        for _ in range(12):
            middle = v + 0.5 * step * law.acceleration(mode, middle, u, z, p)
        dry = law.force(mode, middle, u, z, p) - (0.0 if mode == STUCK else 0.4 * middle)
        supplied += step * (u - dry) * middle
        v = 2 * middle - v
        stored = 0.5 * v * v
        assert (
            stored <= supplied + 2e-4
        )  # the fixed point does not settle in the step that crosses v = 0
    assert switches > 0


@pytest.mark.parametrize("name", VERSIONS)
@settings(derandomize=True, deadline=None, max_examples=10)
@given(seed=st.integers(0, 1000))
def test_no_drift_below_the_breakaway(name: str, seed: int) -> None:
    """3.7.5: random efforts up to 0.98 F_s, half a second of them: the body stays within z_max and
    stuck."""
    corners = np.random.default_rng(seed).uniform(-0.98, 0.98, 51) * F_S
    corners[0] = 0.0
    efforts = np.interp(np.linspace(0, 50, 50_001), np.arange(51), corners)
    rows = run(name, efforts, 1e-5)
    assert np.all(rows[:, MODE] == STUCK)
    assert np.abs(rows[:, POSITION]).max() <= (0.0 if name == "hybrid_a" else Z_MAX)


@pytest.mark.parametrize("name", VERSIONS)
def test_breaks_away_at_the_breakaway_slips_and_is_captured(name: str) -> None:
    """A ramp to 2 N and back to 0, held: leaves at 1.5 N, comes to rest, and stays."""
    efforts = np.interp(np.linspace(0, 5, 500_001), [0, 2, 4, 5], [0, 2, 0, 0])
    rows = run(name, efforts, 1e-5)
    slipping = np.flatnonzero(rows[:, MODE] == SLIPPING)
    lag = {
        "hybrid_a": 0.0,
        "hybrid_b": 2 / math.sqrt(1.5e5),
    }  # k2/k1, by which z follows a ramp of 1 N/s
    if name == "hybrid_c":  # whose stiffness fades towards the breakaway
        assert F_S < efforts[slipping[0]] < F_S + 0.05
    else:
        assert efforts[slipping[0]] == pytest.approx(F_S + lag[name], abs=1e-4)
    assert rows[slipping[0] : slipping[-1], MODE].min() == SLIPPING
    assert np.all(rows[slipping[-1] + 1 :, MODE] == STUCK)
    assert abs(rows[-1, VELOCITY]) < 1e-9
    assert rows[-1, POSITION] > 0.1


@pytest.mark.parametrize("name", PRESLIDING)
def test_presliding_bears_the_breakaway_at_its_limit(name: str) -> None:
    """0.99 F_s, held: the spring at 0.99 z_max, the parabola 1 - (1 - z/z_max)^2 at 0.9 z_max."""
    rows = run(
        name, np.interp(np.linspace(0, 3, 300_001), [0, 1, 3], [0, 0.99 * F_S, 0.99 * F_S]), 1e-5
    )
    assert rows[-1, MODE] == STUCK
    assert rows[-1, POSITION] == pytest.approx(
        (0.99 if name == "hybrid_b" else 0.9) * Z_MAX, rel=1e-6
    )
    assert rows[-1, EFFORT] == pytest.approx(0.99 * F_S, rel=1e-6)


@pytest.mark.parametrize("name", PRESLIDING)
def test_slip_leaves_the_contact_at_its_limit(name: str) -> None:
    p = packed(LAWS[name])
    for direction in (1.0, -1.0):
        z = kernels(name).reset(p)
        kernels(name).enter(SLIPPING, 0.0, 2.0 * direction, z, p)
        assert z[0] == direction * Z_MAX
        kernels(name).enter(STUCK, -0.5e-4 * direction, 0.0, z, p)
        assert z[0] == -direction * Z_MAX
        assert kernels(name).force(STUCK, 0.0, 0.0, z, p) == pytest.approx(
            -direction * F_S, rel=1e-12
        )


def test_slip_wipes_the_memory_of_version_c() -> None:
    p = packed(LAWS["hybrid_c"])
    law, z = kernels("hybrid_c"), kernels("hybrid_c").reset(packed(LAWS["hybrid_c"]))
    for place in (0.8, -0.3, 0.2):
        z[0] = place * Z_MAX
        law.commit(STUCK, z, p)
    assert z[1 + COUNT] == 2
    law.enter(SLIPPING, 0.0, 2.0, z, p)
    assert z[1 + COUNT] == 0
    z[0] = 0.0
    assert law.force(STUCK, 0.0, 0.0, z, p) == pytest.approx(
        F_S * (1 - 2 * 0.75), rel=1e-12
    )  # F_s - 2 f(z_max/2)


def test_hold_time_counts_in_the_stuck_mode_only() -> None:
    p, out = packed(LAWS["hybrid_a"], TABLE_3_1["hybrid_a"] | {"hold_time": 1e-3}), np.zeros(1)
    for mode, clock, expected in ((STUCK, 0.0, 1.0), (STUCK, 1e-3, 0.0), (SLIPPING, 0.0, 0.0)):
        kernels("hybrid_a").rate(mode, 0.0, np.array([clock]), p, out)
        assert out[0] == expected
    z = np.array([5.0])
    kernels("hybrid_a").enter(SLIPPING, 0.0, 2.0, z, p)
    assert z[0] == 0.0


def test_an_effort_of_exactly_coulomb_friction_keeps_the_slip() -> None:
    """The capture (3.2) needs an effort below Coulomb friction: at equality nothing brakes."""
    p = packed(LAWS["hybrid_a"])
    for way in (1.0, -1.0):
        assert not is_captured(way * 0.5 * SIGMA, way * F_C, p)
        assert is_captured(way * 0.5 * SIGMA, way * 0.999 * F_C, p)
