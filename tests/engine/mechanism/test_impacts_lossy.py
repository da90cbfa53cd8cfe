"""Impulses through links with loss: they lose as efforts do, a link that its load cannot drive
locks in a shock too."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.engine.mechanism.energy import balance
from frictool.engine.mechanism.open_loop_run import run
from frictool.typing import Vector
from studies.rigs.mechanism_builder import Builder
from tests.support.mechanism_runs import ready

GAP = 0.01
LOSS = {"drive_loss": 0.3, "back_loss": 0.25}


def after_shock(
    b: Builder, speeds: list[float], start: list[float] | None = None, duration: float = 2e-6
) -> Vector:
    """Speeds after `duration`, whose balance of energy closes and whose kinetic energy has not
    grown."""
    machine, state = ready(b, start, speeds)
    before = balance(machine, state)
    result = run(machine, state, np.zeros((1, len(b.sources))), duration)
    assert result.status == 0
    after = balance(machine, state)
    assert after.kinetic <= before.kinetic * (1.0 + 1e-12)
    assert after.total == pytest.approx(before.total, rel=1e-6)
    return np.array(state.y[len(b.inertia) : 2 * len(b.inertia)])


def touching(
    masses: list[float],
    side: float = -1.0,
    ratio: float = 1.0,
    restitution: float = 0.0,
    **loss: float,
) -> tuple[Builder, list[float]]:
    """Two blocks whose flanks of one side just touch, and their positions."""
    b = Builder()
    for mass in masses:
        b.block(mass)
    b.joint(0, 1, ratio, gap=GAP, restitution=restitution, **loss)
    return b, [0.0, side * GAP]


def test_a_driving_hit_loses_what_the_gear_loses() -> None:
    """m_a (v - v') = (1 + c) I, m_b v' = I."""
    b, start = touching([2.0, 3.0], **LOSS)
    np.testing.assert_allclose(
        after_shock(b, [1.0, 0.0], start), 2.0 / (2.0 + 1.3 * 3.0), rtol=1e-9
    )


def test_a_load_that_drives_hands_on_less() -> None:
    """m_b (v - v') = I, m_a v' = (1 - c) I."""
    b, start = touching([2.0, 3.0], side=1, **LOSS)
    np.testing.assert_allclose(
        after_shock(b, [0.0, 1.0], start), 0.75 * 3.0 / (2.0 + 0.75 * 3.0), rtol=1e-9
    )


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_link_that_its_load_cannot_drive_locks_in_a_shock(restitution: float) -> None:
    b, start = touching([1.0, 3.0], side=1, restitution=restitution, drive_loss=1.2, back_loss=1.2)
    found = after_shock(b, [0.0, 1.0], start)
    assert found[0] == 0.0
    assert found[1] == pytest.approx(-restitution, abs=1e-12)


def test_a_worm_inside_what_is_struck_locks() -> None:
    """A ball hits the load of a rigid worm."""
    b, start = touching([1.0, 2.0], restitution=0.5)
    b.block(0.1)
    b.joint(2, 1, 1.0, drive_loss=1.2, back_loss=1.2)
    np.testing.assert_allclose(
        after_shock(b, [1.0, 0.0, 0.0], [*start, start[1]]), [-0.5, 0.0, 0.0], atol=1e-12
    )


def test_a_gear_inside_what_is_struck_loses() -> None:
    """A ball hits the driving end of a rigid gear: 2 (1 - v') = (1 + 1.3 * 3) v'."""
    b, start = touching([2.0, 1.0])
    b.block(3.0)
    b.joint(1, 2, 1.0, **LOSS)
    np.testing.assert_allclose(
        after_shock(b, [1.0, 0.0, 0.0], [*start, start[1]]),
        2.0 / (2.0 + 1.0 + 1.3 * 3.0),
        rtol=1e-9,
    )


def test_a_moving_worm_that_is_struck_from_its_load_is_braked() -> None:
    """Load 2 m/s pushes the worm's flank that goes 1 m/s: the worm loses (1.2 - 1) I, the load I;
    it ends at 1 - 0.2 * 0.25 / 0.3."""
    b, start = touching([1.0, 0.3], side=1, drive_loss=1.2, back_loss=1.2)
    found = after_shock(b, [1.0, 2.0], start)
    # 1 - 0.2 I = 2 - I / 0.3
    impulse = 1.0 / (1.0 / 0.3 - 0.2)
    np.testing.assert_allclose(found, 1.0 - 0.2 * impulse, rtol=1e-9)


def test_an_end_stop_takes_a_gear_and_gives_back_no_more_than_it_took() -> None:
    """Stopping, the driver pushes on, mass 2 + 3 at the stop; leaving, the load drives it, 2 / (1 -
    0.9) + 3."""
    b = Builder()
    b.block(2.0)
    b.block(3.0)
    b.joint(0, 1, 1.0, drive_loss=0.0, back_loss=0.9)
    b.stop(1, high=0.0, restitution=1.0)
    found = after_shock(b, [1.0, 1.0])
    np.testing.assert_allclose(found, -np.sqrt(5.0 / 23.0), rtol=1e-9)


def stiff_speeds(
    stiffness: float, speeds: list[float], loss: dict[str, float], inner: bool
) -> Vector:
    """After elastic flanks of a stiffness have let go."""
    b, start = Builder(), [0.0, -GAP if speeds[0] > 0.0 else GAP]
    for mass in (2.0, 3.0):
        b.block(mass)
    b.coupling(0, 1, stiffness, 0.0, gap=GAP, **loss)
    if inner:
        b.block(1.5)
        b.joint(1, 2, 0.5, **LOSS)
        start.append(0.5 * start[1])
        speeds = [*speeds, 0.5 * speeds[1]]
    return after_shock(b, speeds, start, duration=20.0 / np.sqrt(stiffness))


@pytest.mark.parametrize("inner", [False, True])
@pytest.mark.parametrize("loss", [LOSS, {"drive_loss": 1.2, "back_loss": 1.2}])
@pytest.mark.parametrize("speeds", [[1.0, 0.0], [1.0, -0.4], [0.0, 1.0], [-0.3, 0.8], [0.3, 0.0]])
def test_rigid_flanks_are_the_limit_of_stiff_ones(
    speeds: list[float], loss: dict[str, float], inner: bool
) -> None:
    """Elastic flanks against restitution 1."""
    side = -1 if speeds[0] > 0.0 else 1
    b, start = touching([2.0, 3.0], side, 1.0, 1.0, **loss)
    if inner:
        b.block(1.5)
        b.joint(1, 2, 0.5, **LOSS)
        start = [*start, 0.5 * start[1]]
    rigid = after_shock(b, [*speeds, 0.5 * speeds[1]] if inner else speeds, start)
    away = [
        float(np.abs(stiff_speeds(stiffness, list(speeds), loss, inner) - rigid).max())
        for stiffness in (1e4, 1e10)
    ]
    assert away[1] <= max(1e-5, 1e-2 * away[0])


SPEED = st.integers(-3000, 3000).map(lambda v: v / 1000.0)


@given(
    drivers=st.tuples(st.floats(0.05, 20.0), st.floats(0.05, 20.0)),
    loads=st.tuples(st.floats(0.01, 0.3), st.floats(0.01, 0.3)),
    losses=st.lists(st.tuples(st.floats(0.0, 3.0), st.floats(0.0, 3.0)), min_size=3, max_size=3),
    ratio=st.floats(0.02, 5.0),
    sign=st.sampled_from([-1.0, 1.0]),
    speeds=st.tuples(SPEED, SPEED),
    restitution=st.floats(0.0, 1.0),
    side=st.sampled_from([-1, 1]),
)
def test_no_shock_makes_energy(
    drivers: tuple[float, float],
    loads: tuple[float, float],
    losses: list[tuple[float, float]],
    ratio: float,
    sign: float,
    speeds: tuple[float, float],
    restitution: float,
    side: int,
) -> None:
    """Gear, flanks with loss, gear, loads too light to wedge: kinetic energy falls, flanks do not
    approach, the balance closes."""
    b = Builder()
    for driver, load in zip(drivers, loads, strict=True):
        b.block(driver)
        b.block(driver * load)
    sizes = (1.0, ratio, 1.0)
    one, flank, other = (
        {"drive_loss": ahead * size, "back_loss": back * size}
        for (ahead, back), size in zip(losses, sizes, strict=True)
    )
    b.joint(0, 1, 1.0, **one)
    b.joint(1, 2, sign * ratio, gap=GAP, restitution=restitution, **flank)
    b.joint(2, 3, 1.0, **other)
    found = after_shock(
        b, [speeds[0], speeds[0], speeds[1], speeds[1]], [0.0, 0.0, side * GAP, side * GAP], 1e-9
    )
    assert side * (found[2] - sign * ratio * found[1]) <= 1e-9
    np.testing.assert_allclose([found[0], found[3]], [found[1], found[2]], atol=1e-12)
