"""Every law through its driver: the published figures of 3.7, plain references, and the literal
hybrid A against the exact engine."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from frictool.engine.body import BREAKS_AWAY, STOPS
from frictool.engine.drive import EffortFunction, effort, held, pid, ramped, reference, spring
from frictool.engine.law_simulation import LawRunSettings, body_of, run_law
from frictool.engine.status_codes import EVENTS_FULL, LAW_FAILED, OK
from frictool.engine.stick_slip_run import Trajectory, simulate
from frictool.friction.hybrid_kernels import STUCK
from frictool.friction.law import DynamicKernels, HybridKernels
from frictool.friction.law_registry import LAWS
from studies.rigs.table_3_1 import TABLE_3_1

MASS, SPEED = 1.0, 1e-3
SPRING = spring(stiffness=2.0, speed=0.1)
PID = pid(proportional=3.0, derivative=6.0, integral=4.0, target=1.0)
MILLISECONDS = np.linspace(0.0, 60.0, 60_001)


def run(
    name: str,
    segments: list[tuple[float, EffortFunction]],
    times: object,
    step: float | None = None,
    **changes: float,
) -> Trajectory:
    law = LAWS[name]
    p = law.pack({**TABLE_3_1[name], **changes})
    found = run_law(law, p, MASS, segments, times, LawRunSettings(step))
    assert found.status == OK
    return found


def departures(found: Trajectory, threshold: float = SPEED) -> np.ndarray:
    """Return the times when the speed leaves the band of `threshold`, after the transient of the
    first jump."""
    slow = np.abs(found.velocity) < threshold
    return found.time[np.flatnonzero(slow[:-1] & ~slow[1:])]


@pytest.mark.parametrize(
    ("name", "step", "end", "sticks", "period"),
    [
        ("stribeck", None, 60, 9, 6.5123),
        ("lugre", None, 60, 9, 6.395),
        ("karnopp", 1e-4, 60, 9, 6.455),
        pytest.param("hybrid_a", 1e-5, 60, 9, 6.5124, marks=pytest.mark.accept),
        ("hybrid_b", 4e-5, 30, 4, 6.5127),
        ("hybrid_c", 4e-5, 30, 4, 6.5119),
    ],
)
def test_stick_slip_figures(
    name: str, step: float | None, end: int, sticks: int, period: float
) -> None:
    times = MILLISECONDS[: 1000 * end + 1]
    starts = departures(run(name, [(float(end), SPRING)], times, step))
    assert starts.size == sticks
    assert np.diff(starts).mean() == pytest.approx(period, rel=2e-3)


def test_an_elasto_plastic_contact_sticks_once_if_it_yields_late_and_often_if_early() -> None:
    late = run("elasto_plastic", [(60.0, SPRING)], MILLISECONDS)
    assert departures(late).size == 1
    early = departures(run("elasto_plastic", [(60.0, SPRING)], MILLISECONDS, elastic_limit=3e-6))
    assert early.size == 11
    assert np.diff(early).mean() == pytest.approx(5.026, rel=0.01)


def test_a_stiffer_lugre_is_nearer_to_the_rigid_stick() -> None:
    stiff = {"stiffness": 1.5e6, "damping": 2.0 * math.sqrt(1.5e6)}
    assert np.diff(departures(run("lugre", [(20.0, SPRING)], MILLISECONDS[:20_001], **stiff)))[
        0
    ] == pytest.approx(6.492, rel=2e-3)


DRIFT = [
    (1.0, ramped(0.0, 1.6)),
    (1.05, ramped(1.6, -22.0, start=1.0)),
    (2.0, held(0.5)),
    (102.0, EffortFunction(offset=0.5, amplitude=0.4, frequency=4.0 * np.pi, phase=-8.0 * np.pi)),
]


@pytest.mark.parametrize(
    ("name", "step", "drift"),
    [
        ("lugre", None, 86.0),
        ("dahl", None, 221.0),
        ("elasto_plastic", None, 0.0),
        ("karnopp", 1e-4, 0.0),
    ],
)
def test_drift_figures(name: str, step: float | None, drift: float) -> None:
    """In z_max, from t = 5 s to 102 s: whole cycles of the wave."""
    found = run(name, DRIFT, [5.0, 102.0], step)
    assert (found.position[1] - found.position[0]) / 1e-5 == pytest.approx(
        drift, rel=0.01, abs=0.01
    )


def test_the_band_of_svc_drifts() -> None:
    found = run("svc_band", DRIFT, [5.0, 102.0], 1e-4)
    assert found.position[1] - found.position[0] == pytest.approx(0.097, rel=0.01)


def test_hybrid_a_converges_to_the_exact_engine() -> None:
    """As Sigma and the step shrink together, with a faster p0."""
    end = 18.0
    exact = simulate(
        body_of(LAWS["stribeck"], LAWS["stribeck"].pack(TABLE_3_1["stribeck"]), MASS),
        [(end, SPRING)],
        [end],
    )
    errors = []
    for share in (1.0, 0.25):
        found = run(
            "hybrid_a",
            [(end, SPRING)],
            [end],
            4e-5 * share,
            capture_velocity=1e-4 * share,
            convergence_rate=1e3 / share,
        )
        starts = found.times_of(BREAKS_AWAY)
        assert starts.size == exact.times_of(BREAKS_AWAY).size
        errors.append(np.max(np.abs(starts - exact.times_of(BREAKS_AWAY))))
    assert errors[0] < 5e-3
    assert errors[1] < 0.3 * errors[0]


def plain_hybrid(name: str, drive: EffortFunction, steps: int, h: float) -> tuple[float, float]:
    """The midpoint rule with the mode held, as a loop in Python."""
    law = LAWS[name]
    kernels, p, d = law.kernels, law.pack(TABLE_3_1[name]), drive.as_array()
    assert isinstance(kernels, HybridKernels)
    x, v, q, z, mode = 0.0, 0.0, 0.0, kernels.reset(p), STUCK
    slope = np.zeros_like(z)
    for k in range(steps):
        t = k * h
        u = effort(t, x, v, q, d)
        after = kernels.mode_after(mode, v, u, z, p)
        if after != mode:
            mode = after
            kernels.enter(mode, v, u, z, p)
        kernels.rate(mode, v, z, p, slope)
        half, zm = v + 0.5 * h * kernels.acceleration(mode, v, u, z, p), z + 0.5 * h * slope
        xm, qm = x + 0.5 * h * v, q + 0.5 * h * (x - reference(t, d))
        um = effort(t + 0.5 * h, xm, half, qm, d)
        kernels.rate(mode, half, zm, p, slope)
        x, v, q = (
            x + h * half,
            v + h * kernels.acceleration(mode, half, um, zm, p),
            q + h * (xm - reference(t + 0.5 * h, d)),
        )
        z = z + h * slope
        kernels.commit(mode, z, p)
    return x, v


@pytest.mark.parametrize("name", ["hybrid_a", "hybrid_b", "hybrid_c"])
def test_hybrid_driver_equals_a_loop_in_python(name: str) -> None:
    drive, h, steps = (
        EffortFunction(
            offset=1.4, amplitude=0.8, frequency=40.0, proportional=3.0, integral=2.0, target=0.01
        ),
        4e-5,
        5000,
    )
    found = run(name, [(steps * h, drive)], [steps * h], h)
    x, v = plain_hybrid(name, drive, steps, h)
    assert found.position[-1] == pytest.approx(x, rel=1e-9, abs=1e-15)
    assert found.velocity[-1] == pytest.approx(v, rel=1e-9, abs=1e-12)
    assert found.events.shape[0] > 0


@pytest.mark.parametrize("name", ["dahl", "lugre", "elasto_plastic"])
def test_dynamic_driver_agrees_with_a_stiff_integrator(name: str) -> None:
    law, drive, end = (
        LAWS[name],
        EffortFunction(offset=0.5, amplitude=1.5, frequency=9.0, proportional=2.0, derivative=0.3),
        0.6,
    )
    kernels, p, d = law.kernels, law.pack(TABLE_3_1[name]), drive.as_array()
    assert isinstance(kernels, DynamicKernels)
    zdot = np.zeros(1)

    def field(t: float, y: np.ndarray) -> list[float]:
        kernels.rate(y[2:], y[1], p, zdot)
        return [
            y[1],
            (effort(t, y[0], y[1], 0.0, d) - kernels.force(y[2:], zdot, y[1], p)) / MASS,
            zdot[0],
        ]

    exact = solve_ivp(
        field,
        (0.0, end),
        np.zeros(3),
        method="LSODA",
        rtol=1e-9,
        atol=[1e-12, 1e-10, 1e-13],
        max_step=1e-3,
    ).y[:, -1]
    found = run(name, [(end, drive)], np.linspace(0.0, end, 11))
    np.testing.assert_allclose([found.state[0], found.state[1]], exact[:2], rtol=2e-5, atol=1e-8)
    assert np.all(np.diff(found.position) != 0.0)


@pytest.mark.parametrize(
    "name", ["lugre", "elasto_plastic", "leuven", "leuven_masing", "maxwell_slip"]
)
def test_a_tighter_tolerance_changes_a_dynamic_law_by_less_than_the_tolerance_allows(
    name: str,
) -> None:
    """Through slip, reversals and stick: the memory of a hysteresis sees each reversal, whatever
    the step."""
    law, drive = (
        LAWS[name],
        EffortFunction(offset=0.3, amplitude=2.2, frequency=6.0, proportional=2.0, derivative=0.3),
    )
    p, times = law.pack(TABLE_3_1[name]), np.linspace(0.0, 4.0, 41)
    loose, tight = (
        run_law(law, p, MASS, [(4.0, drive)], times, LawRunSettings(tolerance=tolerance))
        for tolerance in (1e-7, 1e-10)
    )
    np.testing.assert_allclose(
        loose.position, tight.position, rtol=0.0, atol=5e-7 * np.max(np.abs(tight.position))
    )
    assert np.max(np.abs(np.diff(tight.position))) > 1e-3


def test_static_laws_have_an_exact_body_and_laws_with_a_band_do_not() -> None:
    for name in ("coulomb", "svc", "stribeck", "coulomb_tanh", "coulomb_atan"):
        body_of(LAWS[name], LAWS[name].pack(TABLE_3_1[name]), MASS).as_array()
    with pytest.raises(ValueError, match="found law karnopp; allowed: static laws that stick"):
        body_of(LAWS["karnopp"], LAWS["karnopp"].pack(TABLE_3_1["karnopp"]), MASS)


def test_a_smoothed_law_creeps_where_the_law_sticks() -> None:
    assert run("coulomb", [(10.0, held(0.9))], [10.0]).position[-1] == 0.0
    creep = run("coulomb_tanh", [(10.0, held(0.9))], [10.0])
    assert creep.velocity[-1] == pytest.approx(1e-3 * math.atanh(0.9), rel=1e-7)


def test_a_step_is_needed_and_events_need_room() -> None:
    law, p = LAWS["hybrid_a"], LAWS["hybrid_a"].pack(TABLE_3_1["hybrid_a"])
    with pytest.raises(ValueError, match="hybrid_a: step: found None; allowed: above 0 s"):
        run_law(law, p, MASS, [(1.0, SPRING)], [1.0])
    settings = LawRunSettings(step=1e-4, most_events=1)
    full = run_law(law, p, MASS, [(20.0, SPRING)], [0.0, 20.0], settings)
    assert (full.status, full.events.shape[0]) == (EVENTS_FULL, 1)
    assert np.isnan(full.position[1])
    assert full.times_of(STOPS).size == 0


def test_a_law_that_fails_ends_the_run() -> None:
    law = LAWS["lugre"]
    p = law.pack(TABLE_3_1["lugre"])
    p[0] = np.nan
    found = run_law(law, p, MASS, [(1.0, SPRING)], [1.0])
    assert found.status == LAW_FAILED
    assert np.isnan(found.position[0])
