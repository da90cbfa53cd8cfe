"""Self-locking links: which of several motions, or rest, is the limit of ever stiffer compliant
links, and what a jam stops."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.engine.mechanism.events import JAMS, SEPARATES
from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.status_codes import OK
from studies.rigs.mechanism_builder import Builder
from tests.support.mechanism_runs import instants, moved, ready
from tests.support.self_locking_mechanisms import compared

RATIO, EFFICIENCY, MOTOR, DRUM, WEIGHT = 0.02, 0.4, 1e-5, 5.0, 1.0
LOST = RATIO * (1.0 / EFFICIENCY - 1.0)
HELD = (
    RATIO * (1.0 / EFFICIENCY - 2.0) * WEIGHT
)  # N m at the motor, below which the weight starts to go down


def hoist() -> Builder:
    """A motor, and a drum that it lowers and that cannot drive it back."""
    b = Builder()
    b.block(MOTOR, 10.0)
    b.block(DRUM, 0.2)
    b.joint(0, 1, RATIO, drive_loss=LOST, back_loss=LOST)
    b.push(1, -WEIGHT)
    b.source(0)
    return b


def lowering(effort: float) -> float:
    """Acceleration of the motor while it drives the drum down: the link's force is negative."""
    return (effort - WEIGHT * RATIO / EFFICIENCY) / (MOTOR + RATIO**2 * DRUM / EFFICIENCY)


def test_a_hoist_that_holds_its_weight_is_let_down_by_the_motor() -> None:
    """From rest under its load the graph falls at first, and the motion that the motor drives is
    beyond."""
    result, _, _ = moved(hoist(), [[0.0], [-1.01 * HELD], [-0.05]], 0.1)
    assert np.all(result.positions[:, 1] == 0.0)
    expected = lowering(-1.01 * HELD) * 0.1
    assert result.speeds[0, 2] == pytest.approx(expected, rel=1e-9)
    assert result.speeds[0, 3] == pytest.approx(expected + lowering(-0.05) * 0.1, rel=1e-9)
    assert lowering(-0.05) == pytest.approx(-19.96, abs=0.005)


def test_a_loaded_hoist_stays_up_to_the_effort_that_its_friction_holds() -> None:
    result, _, _ = moved(
        hoist(),
        [[0.0], [-0.999 * HELD], [0.999 * RATIO / EFFICIENCY * WEIGHT], [-0.999 * HELD]],
        0.1,
    )
    assert np.all(result.positions == 0.0)


def test_a_run_begins_with_unloaded_links() -> None:
    """As a compliant link: before it has taken up the load the motor runs ahead of it, and nothing
    holds it then."""
    result, _, _ = moved(hoist(), [[-0.5 * HELD]], 0.1)
    assert result.speeds[0, 1] == pytest.approx(lowering(-0.5 * HELD) * 0.1, rel=1e-9)
    slow, _, _ = moved(
        hoist(), [[-0.9 * MOTOR * WEIGHT / (RATIO * DRUM)]], 0.1
    )  # less than the weight falls by itself
    assert np.all(slow.positions == 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_load_that_reverses_lets_the_motor_go(sign: float) -> None:
    """The force passes 0, where nothing holds the motor: it moves as in a run that begins
    unloaded. An equal effort leaves it at rest while the load stays on its side."""
    b = Builder()
    b.block(MOTOR, 10.0)
    b.block(DRUM, 0.2)
    b.joint(0, 1, RATIO, drive_loss=LOST, back_loss=LOST)
    b.source(0)
    b.source(1)
    effort = 0.5 * HELD
    held = [[0.0, sign * WEIGHT], [sign * effort, sign * WEIGHT]]
    result, _, _ = moved(b, [*held, [-sign * effort, -sign * WEIGHT]], 0.1)
    assert np.all(result.positions[:, :3] == 0.0)
    assert result.speeds[0, 3] == pytest.approx(sign * lowering(-effort) * 0.1, rel=1e-9)


def test_an_unloaded_link_is_driven() -> None:
    """Without any load the driven side of the graph is the one that the motor moves to."""
    b = Builder()
    b.block(MOTOR, 10.0)
    b.block(DRUM, 0.2)
    b.joint(0, 1, RATIO, drive_loss=LOST, back_loss=LOST)
    b.source(0)
    for effort in (0.01, -0.01):
        result, _, _ = moved(b, [[effort]], 0.1)
        assert result.speeds[0, 1] == pytest.approx(
            0.1 * effort / (MOTOR + RATIO**2 * DRUM / EFFICIENCY), rel=1e-9
        )


def test_a_jam_stops_what_presses_and_not_what_is_pushed_ahead() -> None:
    """A motor pushes another through a flank; that one lowers the drum, which pushes a cart through
    a flank. Braked, the worm wedges."""
    b = Builder()
    for inertia, scale in ((MOTOR, 10.0), (MOTOR, 10.0), (DRUM, 0.2), (1.0, 0.2)):
        b.block(inertia, scale)
    b.joint(0, 1, 1.0, gap=1e-3)
    b.joint(1, 2, RATIO, drive_loss=LOST, back_loss=LOST)
    b.joint(2, 3, 1.0, gap=1e-3)
    b.source(0)
    b.source(1)
    machine, state = ready(b, [0.0, 1e-3, 1e-3 * RATIO, 1e-3 * RATIO + 1e-3])
    start = run(machine, state, [[-0.05, 0.0]], 0.1)
    assert start.status == OK
    before = start.speeds[:, -1]
    assert np.all(before < 0.0)
    assert before[3] == before[2]
    braked = run(machine, state, [[0.0, 0.05]] * 5, 0.01)
    assert braked.status == OK
    assert instants(braked, JAMS, 0).size == 1
    assert instants(braked, SEPARATES, 2).size == 1
    np.testing.assert_allclose(braked.speeds[3, 1:], before[3], rtol=1e-12)
    upwards = 0.05 / (2.0 * MOTOR + RATIO**2 * DRUM / EFFICIENCY)  # from a standstill
    np.testing.assert_allclose(
        braked.speeds[1, 1:], upwards * (braked.times[1:] - braked.times[0]), rtol=1e-9
    )


def test_rigid_self_locking_links_are_the_limit_of_stiff_ones() -> None:
    """Drawn mechanisms from rest through four commands; the rigid one moves as compliant ones do,
    where their damping does not matter."""
    found = [compared(seed) for seed in range(20)]
    assert sum(one.moves and one.has_limit for one in found) >= 4
    assert all(one.agrees for one in found if one.has_limit)
