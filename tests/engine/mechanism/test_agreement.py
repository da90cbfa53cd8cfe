"""The engine of mechanisms against the engines of one axis, against scipy on smooth chains, and
against hand-made limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from frictool.engine.axis_motion import advance as advance_axis
from frictool.engine.mechanism.energy import balance
from frictool.engine.mechanism.events import JAMS, LEAVES_STOP, STRIKES, TOUCHES
from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.mechanism.state import work_by_element
from frictool.plant.axis import LOAD_POSITION, POSITION, AxisParameters, rest
from studies.rigs.mechanism_builder import Builder
from tests.support.mechanism_runs import instants, moved, ready


def test_a_motor_with_play_and_a_light_load_is_the_axis() -> None:
    p = AxisParameters(
        inertia=1.3e-5, viscous=0.0, coulomb=0.12, breakaway=0.13, offset=0.0, constant=0.0134,
        lag=1e-3, drive_limit=25.0, backlash=3.0,
        backlash_coulomb=0.05, backlash_breakaway=0.055, encoder_step=0.0, resistance=0.0,
        supply=12.0,
    )  # fmt: skip
    t = 1e-3 * np.arange(600)
    commands = 14.0 * np.sin(2.0 * np.pi * 3.0 * t)
    state, expected = rest(), np.zeros((2, t.size + 1))
    for k, command in enumerate(commands):
        assert advance_axis(state, float(command), p.as_array(), 1e-3) == 0
        expected[:, k + 1] = state[POSITION], state[LOAD_POSITION]
    b = Builder()
    b.block(p.inertia, 100.0)
    b.block(p.inertia * 1e-7, 100.0)
    b.joint(0, 1, gap=0.5 * p.backlash)
    b.friction(0, "svc", coulomb=0.05, breakaway=0.055, viscous=0.0)
    b.friction(1, "svc", coulomb=0.07, breakaway=0.075, viscous=0.0)
    b.source(0, p.constant, p.drive_limit, p.lag)
    result, _, _ = moved(b, commands[:, None])
    assert instants(result, TOUCHES, 0).size >= 3
    assert np.max(np.abs(result.positions - expected)) < 1e-5 * np.ptp(expected)


def test_a_smooth_chain_is_that_of_scipy() -> None:
    b, n = Builder(), 5
    for i in range(n):
        b.block(0.5 + 0.1 * i)
        b.friction(i, "coulomb_tanh", coulomb=0.3, smoothing_velocity=0.2)
        if i > 0:
            b.coupling(i - 1, i, 400.0 * i, 0.5, ratio=1.2)
    b.push(2, -0.4)
    b.source(0)
    mass = np.array(b.inertia)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        q, v = y[:n], y[n:]
        force = -0.3 * np.tanh(v / 0.2)
        force[0] += 3.0
        force[2] -= 0.4
        for i in range(1, n):
            pull = -(400.0 * i * (q[i] - 1.2 * q[i - 1]) + 0.5 * (v[i] - 1.2 * v[i - 1]))
            force[i] += pull
            force[i - 1] -= 1.2 * pull
        return np.concatenate([v, force / mass])

    expected = solve_ivp(
        rates, (0.0, 1.0), np.zeros(2 * n), method="DOP853", rtol=1e-12, atol=1e-13
    ).y[:n, -1]
    result, _, _ = moved(b, [[3.0]] * 4, 0.25)
    assert result.positions[:, -1] == pytest.approx(expected, rel=1e-7)


def test_a_rigid_gear_is_the_limit_of_stiff_ones() -> None:
    # (2.3) against (2.4)-(2.5): the error of a compliance falls as 1/K
    def play(stiffness: float | None) -> float:
        b = Builder()
        b.block(1.0)
        b.block(2.0)
        if stiffness is None:
            b.joint(0, 1, -0.5)
        else:
            b.coupling(0, 1, stiffness, 2.0 * math.sqrt(stiffness), -0.5)
        b.coupling(-1, 1, 30.0, 1.0)
        b.source(0)
        return float(moved(b, [[1.0]] * 10, 0.05)[0].positions[0, -1])

    rigid = play(None)
    errors = [abs(play(10.0**e) - rigid) for e in (4, 5, 6)]
    assert errors[0] < 2e-4
    assert errors[1] < 0.2 * errors[0]
    assert errors[2] < 0.2 * errors[1]


def test_a_ball_bounces_as_by_hand_and_comes_to_rest() -> None:
    b = Builder()
    b.block(1.0)
    b.push(0, -9.81)
    b.stop(0, low=0.0, restitution=0.5)
    result, machine, state = moved(b, np.zeros((30, 0)), 0.1, start=[1.0])
    first = math.sqrt(2.0 / 9.81)
    expected = first * (
        1.0 + 2.0 * (0.5 + 0.25 + 0.125) * np.array([0.0, 4.0 / 7.0, 6.0 / 7.0, 1.0])
    )
    assert instants(result, STRIKES, 0)[:4] == pytest.approx(expected, rel=1e-9)
    assert result.speeds[0, -1] == 0.0
    assert work_by_element(machine, state).stops[0] == pytest.approx(9.81, rel=1e-9)


def test_two_blocks_leave_their_end_stops_when_their_sources_pull() -> None:
    """A pull of 3 N against a weight of 1 N lifts the first block at 0.5 s, the second at 1 s."""
    b = Builder()
    for i in range(2):
        b.block(1.0)
        b.push(i, -1.0)
        b.stop(i, low=0.0)
        b.source(i)
    pulls = [[0.0, 0.0]] * 5 + [[3.0, 0.0]] * 5 + [[3.0, 3.0]] * 5
    result, _, _ = moved(b, pulls, 0.1, start=[0.01, 0.02])
    for stop, (leaves, height) in enumerate(((0.5, 0.01), (1.0, 0.02))):
        assert instants(result, STRIKES, stop)[0] == pytest.approx(math.sqrt(2.0 * height))
        assert instants(result, LEAVES_STOP, stop) == pytest.approx([leaves], rel=1e-9)
        assert result.positions[stop, -1] == pytest.approx((1.5 - leaves) ** 2, rel=1e-9)


def test_an_impact_goes_through_a_row_of_balls() -> None:
    b = Builder()
    for i in range(4):
        b.block(1.0)
        if i > 0:
            b.joint(i - 1, i, gap=0.01, restitution=0.95)
    result, _, _ = moved(
        b, np.zeros((1, 0)), 0.01, start=[0.0, -0.01, -0.02, -0.03], speeds=[1.0, 0.0, 0.0, 0.0]
    )
    assert result.speeds[:, -1].sum() == pytest.approx(1.0, rel=1e-12)
    assert result.speeds[3, -1] == pytest.approx(((1.0 + 0.95) / 2.0) ** 3, rel=1e-9)


def test_a_self_locking_screw_stands_under_any_load_and_is_let_down_by_the_motor() -> None:
    radius, lead, phi = 5e-3, 0.1, math.atan(0.15)
    b = Builder()
    b.block(1e-3, 10.0)
    b.block(5.0, 0.01)
    ratio = radius * math.tan(lead)
    b.joint(
        0,
        1,
        ratio,
        drive_loss=radius * math.tan(lead + phi) - ratio,
        back_loss=ratio - radius * math.tan(lead - phi),
    )
    b.push(1, 1e4)  # N: pulls the nut forward
    b.source(0)
    result, _, _ = moved(b, [[0.0]] * 5, 0.1)
    assert np.all(result.positions == 0.0)
    needed = (
        -radius * math.tan(lead - phi) * 1e4
    )  # N m: forwards, against what is left of the friction
    assert moved(b, [[0.999999 * needed]], 0.1)[0].positions[0, -1] == 0.0
    machine, state = ready(b)
    lowering = run(machine, state, [[1.5 * needed]], 0.1)
    turning = 1e-3 - ratio * radius * math.tan(phi - lead) * 5.0
    assert lowering.speeds[0, -1] == pytest.approx(0.1 * 0.5 * needed / turning, rel=1e-6)
    assert balance(machine, state).total == pytest.approx(
        0.0, abs=1e-9 * balance(machine, state).lost
    )


@pytest.mark.parametrize("pressings", [0, 2])
def test_a_screw_whose_load_is_too_heavy_to_be_braked_jams(pressings: int) -> None:
    # effective inertia J - (back_loss - ratio) ratio m < 0 while the load runs ahead: the thread
    # wedges, and the motion stops dead
    b = Builder()
    b.block(1e-3)
    b.block(50.0)
    b.joint(0, 1, 0.1, drive_loss=0.1, back_loss=0.15)
    b.friction(0, "coulomb", coulomb=0.2)
    if pressings:
        b.curves.append((np.array([-1.0, 1.0]), np.array([1.0, 1.0])))
    for _ in range(pressings):
        b.pressing(0, 0, 0.01)
    machine, state = ready(b, [0.0, 0.0], [10.0, 1.0])
    result = run(machine, state, np.zeros((2, 0)), 0.01)
    assert result.status == 0
    assert instants(result, JAMS, 0).size == 1
    assert np.all(result.speeds[:, -1] == 0.0)
    # the motion stops at its start, and all its energy is the jam's
    assert work_by_element(machine, state).impacts[0] == pytest.approx(
        0.5 * 1e-3 * 10.0**2 + 0.5 * 50.0 * 1.0**2, rel=1e-9
    )
