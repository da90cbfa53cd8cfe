"""Links above LARGEST_RATE, which are damped critically and integrated by implicit steps: against
closed forms, scipy's Radau, explicit steps of the same equations, and rigid links."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.open_loop_run import MechanismRun, run
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import SWINGS, MechanismState, rest
from frictool.plant.mechanism.fastest_link import LARGEST_RATE
from frictool.typing import Vector
from studies.rigs.mechanism_builder import Builder
from tests.support.energy_balance import balance_error

INERTIA, RATIO = 1e-3, 0.5  # kg m2
PERIOD, SAMPLES = 1e-3, 60
SWING = 120.0 * INERTIA * np.sin(2.0 * np.pi * 25.0 * PERIOD * np.arange(SAMPLES))[:, None]
TIGHT = 1e-11
MOBILITY = (1.0 + RATIO**2) / INERTIA  # reciprocal of the reduced mass, 1/(kg m2)


def pair(stiffness: float, damping: float = 0.0, **more: float) -> Builder:
    """Two inertias, a drive on the first, and a link between them."""
    b = Builder()
    b.block(INERTIA, 10.0)
    b.block(INERTIA, 10.0)
    b.coupling(0, 1, stiffness, damping, RATIO, **more)
    b.source(0)
    return b


def rubbing(b: Builder) -> Builder:
    """The same with dry friction at both ends, with breakaway above Coulomb friction."""
    for block, size in ((0, 20.0 * INERTIA), (1, 10.0 * INERTIA)):
        b.friction(block, "svc", coulomb=size, breakaway=1.5 * size, viscous=INERTIA)
    return b


def rigid(b: Builder) -> Builder:
    """The same with rigid links."""
    for c in b.couplings:
        b.joint(c["a"], c["b"], c["ratio"], drive_loss=c["drive_loss"], back_loss=c["back_loss"])
    b.couplings.clear()
    return b


def moved(
    b: Builder, commands: Vector = SWING, *, explicit: bool = False, undamped: bool = False,
    **more: Any,
) -> tuple[MechanismRun, MechanismState, Any]:  # fmt: skip
    """A run from rest; explicit: by explicit steps; undamped: with the damping of the file."""
    packed = b.packed()
    machine = prepare(packed)
    if explicit:
        machine.whole[ly.STIFF] = 0
    if undamped:
        machine.numbers[machine.whole[ly.COUPLING] + ly.DAMPING] = 0.0
    state = rest(packed, machine, np.zeros(len(b.inertia)))
    found = run(machine, state, commands, PERIOD, **more)
    assert found.status == 0, f"status {found.status} at {found.reached} s"
    return found, state, machine


def stretch(found: MechanismRun) -> Vector:
    """Stretch of the link at the samples [rad]."""
    return np.asarray(found.positions[1] - RATIO * found.positions[0])


@pytest.mark.parametrize("stiffness", [1e8, 1e10])
def test_a_step_deflects_the_link_as_a_critically_damped_oscillator(stiffness: float) -> None:
    """e'' + 2 w e' + w^2 e = -r u/J_a; the drive is so large that the deflection is above the
    tolerance."""
    w, torque = math.sqrt(stiffness * MOBILITY), 1e-6 * stiffness
    packed = pair(stiffness).packed()
    machine = prepare(packed)
    assert machine.whole[ly.STIFF] == 1
    found = run(machine, rest(packed, machine, np.zeros(2)), torque * np.ones((30, 1)), 0.4 / w)
    still, x = -RATIO * torque / INERTIA / w**2, w * found.times
    expected = still * (1.0 - np.exp(-x) * (1.0 + x))
    np.testing.assert_allclose(stretch(found), expected, atol=1e-5 * abs(still))


@pytest.mark.parametrize("stiffness", [1e8, pytest.param(1e10, marks=pytest.mark.accept), 1e12])
def test_a_smooth_motion_is_that_of_radau(stiffness: float) -> None:
    """A drive with a lag, and viscous friction; Radau integrates the stretch, without rounding."""
    lag, viscous = 2e-3, 0.3
    b = pair(stiffness)
    b.sources.clear()
    b.source(0, 1.0, 10.0, lag)
    b.friction(1, "svc", coulomb=0.0, breakaway=0.0, viscous=viscous)
    found, _, _ = moved(b, tolerance=1e-10)
    damping = 2.0 * math.sqrt(stiffness / MOBILITY)
    state, speeds = np.zeros(4), [(0.0, 0.0)]
    for command in SWING[:, 0]:

        def rates(_: float, y: Vector, command: float = command) -> Vector:
            v, e, rate, drive = y
            force = -(stiffness * e + damping * rate)
            first = (drive - RATIO * force) / INERTIA
            second = (force - viscous * (rate + RATIO * v)) / INERTIA
            return np.array([first, rate, second - RATIO * first, (command - drive) / lag])

        state = solve_ivp(
            rates, (0.0, PERIOD), state, "Radau", rtol=1e-10, atol=[1e-10, 1e-18, 1e-10, 1e-13]
        ).y[:, -1]
        speeds.append((state[0], state[2] + RATIO * state[0]))
    expected = np.array(speeds).T
    np.testing.assert_allclose(found.speeds, expected, atol=2e-8 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("coulomb", "loss", "power"), [(0.0, 0.0, 1.0), (0.02, 0.0, 1.0), (0.02, 0.1, 0.5)]
)
def test_the_difference_to_a_rigid_link_falls_with_the_stiffness(
    coulomb: float, loss: float, power: float
) -> None:
    """Friction at one end: the difference of the load's position is proportional to 1/k; with a
    loss, which turns with the effort, it is proportional to the settling time of the link."""
    apart = []
    for stiffness in (1e8, 1e9, 1e10):
        b = pair(stiffness, drive_loss=loss, back_loss=loss)
        b.friction(0, "svc", coulomb=coulomb, breakaway=1.5 * coulomb, viscous=1e-3)
        soft = moved(b, tolerance=TIGHT)[0].positions[1]
        hard = moved(rigid(b), tolerance=TIGHT)[0].positions[1]
        apart.append(np.abs(soft - hard).max())
    np.testing.assert_allclose(np.diff(np.log10(apart)), -power, atol=0.05)


@pytest.mark.parametrize("kind", ["friction", "losses", "backlash"])
def test_events_and_motion_are_those_of_explicit_steps(kind: str) -> None:
    """The same equations by the explicit method of order 8 at a small tolerance."""
    loss = 0.1 if kind == "losses" else 0.0
    b = rubbing(pair(1e8, drive_loss=loss, back_loss=loss))
    if kind == "backlash":
        b.block(0.5 * INERTIA, 10.0)
        b.friction(2, "coulomb", coulomb=2.0 * INERTIA)
        b.joint(1, 2, 1.0, gap=0.002, restitution=0.3)
    found, _, _ = moved(b)
    exact, _, _ = moved(b, explicit=True, tolerance=TIGHT)
    assert len(exact.events) >= 6
    ours, theirs = (rows[np.lexsort(rows[:, :3].T)] for rows in (found.events, exact.events))
    np.testing.assert_array_equal(ours[:, 1:3], theirs[:, 1:3])
    np.testing.assert_allclose(ours[:, 0], theirs[:, 0], atol=1e-7)
    size = np.abs(exact.speeds).max()
    np.testing.assert_allclose(found.speeds, exact.speeds, atol=1e-7 * size)


def test_the_breakaway_of_two_rubbing_ends_is_not_that_of_a_rigid_link() -> None:
    """One end breaks away by some nanoradians first; the other then has to overcome its own
    breakaway and the Coulomb friction of the first only, whatever the stiffness."""
    first, second = 0.02, 0.01  # Coulomb friction, N m; breakaway: 1.5 times
    together = 1.5 * first + 1.5 * second
    ramp = np.linspace(0.0, together, 301)[1:, None]
    for stiffness in (1e9, 1e12):
        b = pair(stiffness)
        b.couplings[0]["ratio"] = 1.0
        soft = moved(rubbing(b), ramp)[0]
        free = ramp[np.flatnonzero(np.abs(soft.speeds[1]) > 1e-3)[0] - 1, 0]
        assert first + 1.5 * second <= free < together
    assert np.all(moved(rigid(rubbing(b)), ramp[:-1])[0].speeds == 0.0)


def test_the_oscillation_left_out_is_within_its_bound() -> None:
    """Without damping the link oscillates about the damped solution, by at most V/k."""
    rng = np.random.default_rng(1)
    b, commands = pair(1e8), rng.uniform(-0.1, 0.1, (20, 1))
    found, state, _ = moved(b, commands, tolerance=TIGHT)
    ringing, _, _ = moved(b, commands, explicit=True, undamped=True, tolerance=TIGHT)
    most = state.pace[SWINGS] / 1e8
    apart = np.abs(stretch(ringing) - stretch(found)).max()
    assert 0.1 * most < apart <= most
    speed = most * math.sqrt(1e8 * MOBILITY)
    rates = [run.speeds[1] - RATIO * run.speeds[0] for run in (ringing, found)]
    assert 0.1 * speed < np.abs(rates[0] - rates[1]).max() <= speed


def test_rounding_of_large_positions_does_not_shorten_the_steps() -> None:
    """At 1000 rad, the rounding of positions changes the effort of 1e12 N m/rad by 0.1 N m."""
    speeds, paces = [], []
    for b in (pair(1e12), rigid(pair(1e12))):
        packed = b.packed()
        machine = prepare(packed)
        state = rest(packed, machine, np.array([1e3, 1e3 * RATIO]))
        state.y[2:4] = 1e3, 1e3 * RATIO
        found = run(machine, state, SWING, PERIOD)
        assert found.status == 0
        speeds.append(found.speeds)
        paces.append(state.pace[0])
    np.testing.assert_allclose(speeds[0], speeds[1], rtol=1e-8)
    assert min(paces) > 0.1 * PERIOD


@pytest.mark.parametrize(
    "seed",
    [
        *(2, 3, 8, 20, 40),
        *(pytest.param(seed, marks=pytest.mark.accept) for seed in (4, 17, 22, 24, 29, 54)),
    ],
)
def test_energy_of_random_mechanisms_with_stiff_links_is_conserved(seed: int) -> None:
    """Losses, contacts, end stops and friction of all kinds beside links of 1e10 N/m to 1e12 N/m;
    the tolerance of speeds is relative to 0.1 m/s, that of energy therefore to 1e-3 J."""
    assert balance_error(seed, stiffer=1e8, samples=40, least=1e-3) < 1e-5


@pytest.mark.parametrize(
    ("stiffness", "damping", "gap"), [(1e5, 0.0, 0.0), (1e5, 0.3, 0.0), (1e8, 0.0, 1e-3)]
)
def test_slower_links_and_flanks_keep_their_damping(
    stiffness: float, damping: float, gap: float
) -> None:
    """The rebound of a flank depends on its damping."""
    b = pair(stiffness, damping, gap=gap)
    machine = prepare(b.packed())
    assert (math.sqrt(stiffness * MOBILITY) > LARGEST_RATE) == (gap > 0.0)
    assert machine.whole[ly.STIFF] == 0
    assert machine.numbers[machine.whole[ly.COUPLING] + ly.DAMPING] == damping
