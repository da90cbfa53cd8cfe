"""Many runs at once: each as it is alone, whatever the number of threads."""

from __future__ import annotations

from collections.abc import Iterator

import numba
import numpy as np
import pytest
from numba import prange
from numpy.typing import NDArray

from frictool.engine.axis_motion import advance
from frictool.engine.body import BREAKS_AWAY, at_rest
from frictool.engine.dormand_prince import Force
from frictool.engine.drive import spring
from frictool.engine.law_simulation import body_of
from frictool.engine.parallel_runs import replay_axes
from frictool.engine.status_codes import OK
from frictool.engine.stick_slip import run as run_body
from frictool.engine.stick_slip_run import simulate
from frictool.friction.kernel_signatures import SLIP_FORCE
from frictool.friction.law_registry import LAWS
from frictool.plant.axis import AxisParameters, rest
from frictool.runtime.kernels import function_pointer, parallel_kernel
from frictool.typing import Vector

PLANTS, PERIOD = 40, 1e-3


@parallel_kernel
def breakaway_times(
    force: Force,
    laws: Vector,
    bodies: Vector,
    states: Vector,
    ends: Vector,
    drives: Vector,
    room: int,
    times: Vector,
    counts: NDArray[np.int64],
    statuses: NDArray[np.int64],
) -> None:
    """Simulate many bodies of one law from t = 0 and fill their breakaway times [s].

    laws (m, p), bodies (m, 16), states (m, 5) in place, drives (m, s, 10) up to ends (s,). times
    (m, b): the first b breakaway times, of which counts (m,) are valid. room: largest number of
    events of each run. statuses (m,): engine/status_codes.py.
    """
    for i in prange(bodies.shape[0]):
        events = np.empty((room, 4))
        none, nothing = np.empty(0), np.empty((0, 5))
        status, _, happened = run_body(
            force, laws[i], bodies[i], states[i], 0.0, ends, drives[i], none, nothing, events
        )
        counts[i] = 0
        for k in range(happened):
            if events[k, 1] == BREAKS_AWAY and counts[i] < times.shape[1]:
                times[i, counts[i]] = events[k, 0]
                counts[i] += 1
        statuses[i] = status


@pytest.fixture(params=[1, 2])
def threads(request: pytest.FixtureRequest) -> Iterator[int]:
    before = numba.get_num_threads()
    if request.param > before:
        pytest.skip(f"numba has {before} thread here")
    numba.set_num_threads(request.param)
    yield request.param
    numba.set_num_threads(before)


def clutches(seed: int = 4) -> list[AxisParameters]:
    rng = np.random.default_rng(seed)
    return [
        AxisParameters(
            inertia=1.32e-5, viscous=3.8e-4, coulomb=0.099 * scale, breakaway=0.109 * scale,
            constant=0.0134, lag=3e-3, drive_limit=50.0,
            backlash=3.0, backlash_coulomb=0.05 * scale, backlash_breakaway=0.055 * scale,
            encoder_step=0.112,
        )
        for scale in rng.uniform(0.7, 1.3, PLANTS)
    ]  # fmt: skip


@pytest.mark.accept  # compiles a kernel of its own for 9 s
def test_replayed_axes(threads: int) -> None:
    axes = clutches()
    commands = np.random.default_rng(5).uniform(-30.0, 30.0, (PLANTS, 100))
    states, positions, statuses = (
        np.stack([rest()] * PLANTS),
        np.empty(commands.shape),
        np.zeros(PLANTS, dtype=np.int64),
    )
    replay_axes(
        np.stack([axis.as_array() for axis in axes]), states, commands, PERIOD, positions, statuses
    )
    assert np.all(statuses == OK)
    for i, axis in enumerate(axes):
        state = rest()
        for k in range(commands.shape[1]):
            assert positions[i, k] == state[0]
            advance(state, commands[i, k], axis.as_array(), PERIOD)
        assert np.array_equal(states[i], state)


@pytest.mark.accept  # compiles a kernel of its own for 4 s
def test_bodies_on_a_spring(threads: int) -> None:
    law, drive = LAWS["stribeck"], spring(2.0, 0.1)
    values = {"coulomb": 1.0, "stribeck_velocity": 1e-3, "viscous": 0.4}
    packed = [law.pack({**values, "breakaway": level}) for level in np.linspace(1.4, 1.8, PLANTS)]
    bodies = [body_of(law, p, 1.0) for p in packed]
    found, counts, statuses = (
        np.full((PLANTS, 12), np.nan),
        np.zeros(PLANTS, dtype=np.int64),
        np.zeros(PLANTS, dtype=np.int64),
    )
    arrays = np.stack([body.as_array() for body in bodies])
    states, drives = np.stack([at_rest()] * PLANTS), np.stack([drive.as_array()[None]] * PLANTS)
    force = function_pointer(law.kernels.slip_force, SLIP_FORCE)
    breakaway_times(
        force,
        np.stack(packed),
        arrays,
        states,
        np.array([30.0]),
        drives,
        200,
        found,
        counts,
        statuses,
    )
    assert np.all(statuses == OK)
    for i, body in enumerate(bodies):
        alone = simulate(body, [(30.0, drive)], [])
        assert np.array_equal(found[i, : counts[i]], alone.times_of())
        assert np.array_equal(states[i], alone.state)
    assert counts.min() >= 3
