"""One block under every law of the table: the engine of mechanisms against the drivers of single
bodies."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.engine.drive import spring
from frictool.engine.law_simulation import LawRunSettings, run_law
from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import rest
from frictool.friction.law_registry import LAWS
from frictool.typing import Vector
from studies.rigs.mechanism_builder import Builder
from studies.rigs.table_3_1 import TABLE_3_1

SPEED, STIFFNESS, STEP, STRETCHED, END = 0.1, 2.0, 2e-5, 0.72, 0.6
# m; what two integrators of the same law differ by
# the memories of the last three move after each accepted step, of another length in each engine
CLOSE = {
    "leuven": 1e-5,
    "leuven_masing": 1e-5,
    "maxwell_slip": 1e-5,
    "hybrid_a": 2e-4,
    "hybrid_b": 2e-4,
    "hybrid_c": 2e-4,
    "karnopp": 1e-3,
    "svc_band": 1e-3,
}


@pytest.mark.parametrize("name", sorted(LAWS))
def test_a_pulled_block_moves_as_under_the_law_alone(name: str) -> None:
    """A spring of 2 N/m whose end runs at 0.1 m/s, shortly before breakaway and in slip (3.7.2)."""
    b = Builder()
    pulled = b.block(1.0, 0.1)
    _plays_as_alone(b, pulled, name)


@pytest.mark.parametrize("name", ["dahl", "hybrid_a", "hybrid_b", "hybrid_c", "karnopp"])
def test_a_geared_block_stops_as_one_with_the_reflected_inertia(name: str) -> None:
    """1.6 kg at half the speed of 0.6 kg reflects 0.4 kg to it."""
    single, geared = Builder(), Builder()
    pulled = single.block(1.0, 0.1)
    driver, driven = geared.block(1.6, 0.1), geared.block(0.6, 0.1)
    geared.joint(driver, driven, -2.0)  # the position of `driven` is -2 times that of `driver`
    expected = _stopping(single, pulled, [0.2], name)
    found = _stopping(geared, driven, [-0.1, 0.2], name)
    assert abs(expected[-1] - expected[-2]) < 1e-4  # it has stopped
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["dahl", "hybrid_a", "karnopp", "svc_band"])
def test_the_second_of_two_laws_has_its_own_values(name: str) -> None:
    """Two blocks without a connection: the second stops as it does alone."""
    single, two = Builder(), Builder()
    pulled = single.block(1.0, 0.1)
    first, second = two.block(2.0, 0.1), two.block(1.0, 0.1)
    two.friction(first, name, **TABLE_3_1[name])
    expected = _stopping(single, pulled, [0.2], name)
    stopped = _stopping(two, second, [0.1, 0.2], name)
    assert abs(expected[-1] - expected[-2]) < 1e-4  # it has stopped
    np.testing.assert_allclose(stopped, expected, rtol=0.0, atol=1e-6)


def _stopping(b: Builder, block: int, velocities: list[float], name: str) -> Vector:
    """Return the positions of `block` under friction alone, from these velocities."""
    b.friction(block, name, **TABLE_3_1[name])
    packed = b.packed()
    machine = prepare(packed)
    count = len(velocities)
    state = rest(packed, machine, [0.0] * count, STEP)
    state.y[count : 2 * count] = velocities
    result = run(machine, state, np.zeros((30, 0)), END / 30.0)
    assert result.status == 0
    return np.asarray(result.positions[block])


def _plays_as_alone(b: Builder, pulled: int, name: str) -> None:
    law, values = LAWS[name], {**TABLE_3_1[name]}
    if "band" in values:
        values["band"] = 1e-3
    alone = run_law(
        law,
        law.pack(values),
        1.0,
        [(END, spring(STIFFNESS, SPEED)._replace(target=STRETCHED))],
        np.linspace(0.0, END, 31),
        LawRunSettings(step=STEP, tolerance=1e-9),
    )
    end = b.block(1e9, 0.1)  # the spring's end
    b.coupling(end, pulled, STIFFNESS)
    b.friction(pulled, name, **values)
    packed = b.packed()
    machine = prepare(packed)
    start = [0.0] * (end + 1)
    start[end] = STRETCHED
    state = rest(packed, machine, start, STEP)
    state.y[2 * end + 1] = SPEED
    result = run(machine, state, np.zeros((30, 0)), END / 30.0)
    assert result.status == 0
    difference = np.abs(result.positions[pulled] - alone.samples[:, 0])
    assert difference.max() < CLOSE.get(name, 2e-6), f"{difference.max():.2e}"
    assert np.ptp(alone.samples[:, 0]) > 1e-3
