"""Dynamic laws: equal to the printed equations, dissipative, steady slip on the static curve,
presliding as claimed."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.friction.law import DynamicKernels, Law
from frictool.friction.law_registry import LAWS
from frictool.friction.status_codes import NOT_FINITE, OK
from studies.rigs.table_3_1 import STIFF, STRIBECK, TABLE_3_1, packed
from tests.support.law_drivers import FORCE, STATE, dynamic_run, pointers
from tests.support.law_values import values
from tests.support.plain_laws import presliding_force, presliding_rate, stribeck_curve

DYNAMIC = sorted(name for name, law in LAWS.items() if law.kind == "dynamic")
SCALAR = ["dahl", "lugre", "elasto_plastic"]
RATIOS = st.floats(-1.0, 1.0)
SPEEDS = st.builds(lambda e, s: s * 10.0**e, st.floats(-6, 1), st.sampled_from([1.0, -1.0]))


def kernels(name: str) -> DynamicKernels:
    found = LAWS[name].kernels
    assert isinstance(found, DynamicKernels)
    return found


def run(
    name: str, velocities: np.ndarray, step: float, q: dict[str, float] | None = None
) -> np.ndarray:
    return dynamic_run(
        *pointers(kernels(name)), velocities, step, packed(LAWS[name], q or TABLE_3_1[name])
    )


def largest(law: Law, q: dict[str, float]) -> float:
    """The presliding at which the spring bears the breakaway."""
    return q.get("breakaway", q["coulomb"]) / q["stiffness"]


@pytest.mark.parametrize("name", SCALAR)
@given(data=st.data(), ratio=RATIOS, v=SPEEDS)
def test_rate_and_force_follow_the_equations(
    name: str, data: st.DataObject, ratio: float, v: float
) -> None:
    q = data.draw(values(LAWS[name]))
    z, out, p = np.array([1.2 * ratio * largest(LAWS[name], q)]), np.zeros(1), packed(LAWS[name], q)
    assert kernels(name).rate(z, v, p, out) == OK
    assert out[0] == pytest.approx(presliding_rate(name, z[0], v, q), rel=1e-9, abs=1e-12 * abs(v))
    assert kernels(name).force(z, out, v, p) == pytest.approx(
        presliding_force(name, z[0], out[0], v, q), rel=1e-12, abs=1e-300
    )


@pytest.mark.parametrize("name", SCALAR)
@given(data=st.data(), ratio=RATIOS, v=SPEEDS, share=st.floats(0.0, 0.99))
def test_storage_inequality(
    name: str, data: st.DataObject, ratio: float, v: float, share: float
) -> None:
    """(3.42) with V = stiffness z^2/2 and the supply F v, for sigma_1 |v| <= 4 g(v) (2.4.3.3)."""
    q = data.draw(values(LAWS[name]))
    if "damping" in q:
        q["damping"] = share * 4.0 * stribeck_curve(v, q) / abs(v)
    z, out, p = np.array([ratio * largest(LAWS[name], q)]), np.zeros(1), packed(LAWS[name], q)
    kernels(name).rate(z, v, p, out)
    supply, stored = kernels(name).force(z, out, v, p) * v, q["stiffness"] * z[0] * out[0]
    assert stored <= supply + 1e-12 * (abs(supply) + abs(stored))


@pytest.mark.parametrize("name", DYNAMIC)
@settings(derandomize=True, deadline=None, max_examples=10)
@given(ratio=st.floats(0.0, 0.4), v=SPEEDS)
def test_laws_are_odd(name: str, ratio: float, v: float) -> None:
    there = np.concatenate([np.full(20, v), np.full(20, -ratio * v)])
    step = 1e-7 / abs(v)
    forward, backward = run(name, there, step), run(name, -there, step)
    assert np.all(np.isfinite(forward))
    np.testing.assert_allclose(forward, -backward, rtol=1e-12, atol=1e-15)


def steady(name: str, v: float, q: dict[str, float], travel: float = 40.0) -> float:
    """Force after slipping `travel` times the presliding limit at v."""
    limit = (
        q.get("presliding_limit")
        or q["breakaway" if "breakaway" in q else "coulomb"] / q["stiffness"]
    )
    return float(run(name, np.full(8000, v), travel * limit / abs(v) / 8000, q)[-1, FORCE])


@pytest.mark.parametrize("name", ["lugre", "leuven", "leuven_masing"])
@pytest.mark.parametrize("v", [1e-4, 1e-3, -3e-3, 0.1])
def test_steady_slip_lies_on_the_curve_of_stribeck(name: str, v: float) -> None:
    """Leuven's presliding has hardly any slope left near the breakaway: it takes long to settle at
    1e-4 m/s."""
    expected = math.copysign(stribeck_curve(v, STRIBECK), v) + 0.4 * v
    assert steady(name, v, TABLE_3_1[name], travel=2000.0) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("share", [0.3, 0.9])
@pytest.mark.parametrize("v", [1e-4, -0.1])
def test_steady_slip_of_elasto_plastic_is_where_its_spring_slips(share: float, v: float) -> None:
    """alpha(z) sigma_0 z = g(v): above Stribeck's curve, because (2.46) takes z_max from F_s and
    not from g(v)."""
    q = {**TABLE_3_1["elasto_plastic"], "elastic_limit": share * 1e-5}
    low, high = share * 1e-5, 1e-5
    for _ in range(80):
        z = 0.5 * (low + high)
        alpha = 0.5 * (
            math.sin(math.pi * (z - 0.5 * (1e-5 + share * 1e-5)) / (1e-5 - share * 1e-5)) + 1
        )
        low, high = (z, high) if alpha * 1.5e5 * z < stribeck_curve(v, q) else (low, z)
    force = steady("elasto_plastic", v, q)
    assert force == pytest.approx(math.copysign(1.5e5 * high, v) + 0.4 * v, rel=1e-6)
    assert abs(force) > stribeck_curve(v, q) + 0.4 * abs(v)


@pytest.mark.parametrize("v", [1e-4, -1e-3, 0.1])
def test_steady_slip_of_maxwell_slip_lies_on_the_curve_of_stribeck(v: float) -> None:
    attraction = 20.0 * abs(v) / 1e-5
    expected = math.copysign(stribeck_curve(v, STRIBECK), v) + 0.4 * v
    assert steady(
        "maxwell_slip", v, {**TABLE_3_1["maxwell_slip"], "attraction": attraction}
    ) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("exponent", "travel"), [(0.5, 40.0), (1.0, 40.0), (1.5, 400.0)])
@pytest.mark.parametrize("v", [1e-3, -0.2])
def test_steady_slip_of_dahl_is_coulomb(exponent: float, travel: float, v: float) -> None:
    q = {**TABLE_3_1["dahl"], "exponent": exponent}
    assert steady("dahl", v, q, travel) == pytest.approx(math.copysign(1.0, v), rel=1e-4)


def test_dahl_of_first_order_is_an_exponential_in_position() -> None:
    """(2.38): F = F_c (1 - exp(-sigma x/F_c))."""
    x = np.linspace(0.0, 5e-5, 2001)
    force = run("dahl", np.full(2001, 1e-3), x[1] / 1e-3)[:, FORCE]
    np.testing.assert_allclose(force, 1.0 - np.exp(-1.5e5 * x), rtol=1e-9, atol=1e-12)


@given(shares=st.lists(st.floats(-0.99, 0.99), min_size=1, max_size=8), v=st.floats(1e-6, 1e-2))
def test_elasto_plastic_is_elastic_below_its_limit(shares: list[float], v: float) -> None:
    """z follows x exactly, and comes back, wherever |z| < z_ba: no drift."""
    z, rate, p, out = (
        np.zeros(1),
        kernels("elasto_plastic").rate,
        packed(LAWS["elasto_plastic"]),
        np.zeros(1),
    )
    for share in shares:
        z[0] = share * 9e-6
        for velocity in (v, -v):
            assert rate(z, velocity, p, out) == OK
            assert out[0] == velocity


@pytest.mark.parametrize("name", DYNAMIC)
@settings(derandomize=True, deadline=None, max_examples=15)
@given(
    cycles=st.integers(1, 4),
    amplitude=st.floats(0.2, 30.0),
    shape=st.floats(-0.8, 0.8),
    speed=st.floats(-5.0, -2.5),
)
def test_friction_takes_energy_on_every_path_from_rest(
    name: str, cycles: int, amplitude: float, shape: float, speed: float
) -> None:
    """int F v dt >= 0 up to any time from a contact that never moved: nothing was stored in it."""
    q = dict(TABLE_3_1[name])
    if "damping" in q:
        q["damping"] = 100.0  # sigma_1 |v| < 4 g(v)
    if "attraction" in q:
        q["attraction"] = 20.0 * 10.0**speed / 1e-5  # slow beside the step
    t = np.linspace(0.0, 2 * math.pi * cycles, 4000)
    shapes = np.sin(t) + shape * np.sin(2.7 * t)
    v = 10.0**speed * shapes
    step = amplitude * 1e-5 / 10.0**speed * t[1]
    force = run(name, v, step, q)[:, FORCE]
    power = force * v
    work = np.concatenate([[0.0], np.cumsum(0.5 * step * (power[1:] + power[:-1]))])
    assert np.all(np.isfinite(work))
    assert work.min() >= -2e-3 * np.abs(power).max() * step * 10
    assert work[-1] > 0.0


@pytest.mark.parametrize("name", DYNAMIC)
def test_a_state_that_is_not_finite_is_reported(name: str) -> None:
    p = packed(LAWS[name])
    z = kernels(name).reset(p)
    assert kernels(name).rate(z, math.nan, p, np.zeros_like(z)) == NOT_FINITE


def loop(name: str, q: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Positions and forces of 0, 0.7, -0.2, 0.4, -0.2, 0.7, 0.8 z_max, slowly: an inner loop that
    closes."""
    corners = np.array([0.0, 0.7, -0.2, 0.4, -0.2, 0.7, 0.8]) * 1e-5
    x = np.concatenate(
        [np.linspace(a, b, 2000, endpoint=False) for a, b in itertools.pairwise(corners)]
    )
    step = 1e-3
    v = np.gradient(x, step)
    return x, run(name, v, step, q)[:, FORCE]


@pytest.mark.parametrize(
    ("name", "closes"),
    [("leuven", True), ("leuven_masing", True), ("maxwell_slip", True), ("lugre", False)],
)
def test_inner_loops_close_where_the_memory_is_non_local(name: str, closes: bool) -> None:
    """After the inner loop -0.2, 0.4, -0.2 the force is that before it; LuGre's is not (3.7.4)."""
    q = dict(TABLE_3_1[name])
    if name.startswith("leuven"):
        q |= {"exponent": 30.0}  # z follows x closely below the breakaway
    _, force = loop(name, q)
    before, after = force[4000], force[8000]
    assert (abs(after - before) < 0.01) == closes


def test_lugre_and_elasto_plastic_agree_in_slow_steady_slip_only() -> None:
    """Slowly both slip at the breakaway. Fast the elasto-plastic spring is longer than g(v) asks
    for; before slip LuGre's lags behind x."""
    both = {
        "lugre": {**STRIBECK, **STIFF},
        "elasto_plastic": {**STRIBECK, **STIFF, "elastic_limit": 9e-6},
    }
    for v in (1e-6, -1e-6):
        slow = [steady(name, v, q) for name, q in both.items()]
        assert slow == pytest.approx([math.copysign(STRIBECK["breakaway"], v)] * 2, rel=1e-4)
    fast = [steady(name, 0.1, q) - STRIBECK["viscous"] * 0.1 for name, q in both.items()]
    assert fast[0] == pytest.approx(STRIBECK["coulomb"], rel=1e-6)
    assert 0.9 * STRIBECK["breakaway"] < fast[1] < STRIBECK["breakaway"]
    below = 0.8e-5  # below the elastic limit, where the elasto-plastic spring is as long as the way
    early = [
        float(run(name, np.full(1001, 1e-4), below / 1e-4 / 1000, q)[-1, STATE])
        for name, q in both.items()
    ]
    assert early[0] < 0.8 * early[1]
    assert early[1] == pytest.approx(below, rel=2e-3)
