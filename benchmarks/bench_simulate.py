"""Closed loop of the clutch against `solve_ivp`: one step of 1.1 s.

The rows are one plant, one plant under a load, and 1000 random plants. The peer moves the plant
under the commands that the closed loop computed; the time of a controller is not included. Commands
are replayed, because the quantiser in a loop amplifies small differences. Errors are those of the
position at the samples, against DOP853 with a relative tolerance of 1e-12 and steps of at most
0.1 ms. Gravity makes the plant unstable. Under the load, each period is therefore simulated from
the closed loop's state at its beginning.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import pair
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import (
    CompiledProgram,
    compile_program,
    copy_program,
    start_at,
)
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.documents.scenario import Scenario, Step
from frictool.engine.closed_loop import (
    COMMAND,
    LOAD,
    RECORD_SIZE,
    TRUE_DRIVE,
    TRUE_POSITION,
    TRUE_VELOCITY,
    measure,
    run,
)
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from frictool.simulate.closed_loop import simulate_closed_loop
from studies.references.event_integration import TIGHT, UNLOADED, event_integration
from studies.rigs.clutch_model import clutch_model
from studies.rigs.example_controllers import clutch_controller

PERIOD, SAMPLES, TARGET, START = 1e-3, 1100, 55.0, 5.0
CLUTCH = AxisParameters(
    inertia=1.32e-5, viscous=3.8e-4, coulomb=0.099, breakaway=0.109, constant=0.0134, lag=3e-3,
    drive_limit=50.0,
    backlash=3.0, backlash_coulomb=0.05, backlash_breakaway=0.055, encoder_step=2 * math.pi / 56,
)  # fmt: skip
LOADED = PositionLoad(
    0.002, (LoadHarmonic(1.0, 0.03, -0.01), LoadHarmonic(7.0, 0.01, 0.0))
)  # N m/rad, N m: a spring, gravity and ripple
USUAL: dict[str, Any] = {"method": "RK45", "rtol": 1e-6, "max_step": np.inf}
ROUNDS, STEPS, LOADED_STEPS, PLANTS = 5, 200, 20, 1000


def closed_loop(controller: CompiledProgram, load: PositionLoad = UNLOADED) -> NDArray[np.float64]:
    """Return the record (n, 7) of one step under a controller."""
    record = np.zeros((SAMPLES, RECORD_SIZE))
    own = copy_program(controller)
    start_at(own, measure(START, CLUTCH.encoder_step))
    run(
        CLUTCH.as_array(),
        rest(START),
        own,
        np.full(SAMPLES, TARGET),
        PERIOD,
        1,
        record,
        load.as_array(),
        NO_CONDITIONS,
    )
    return record


def replay(commands: NDArray[np.float64], options: dict[str, Any]) -> NDArray[np.float64]:
    """Return the positions (n,) of the plant under the commands of the samples, by `solve_ivp`."""
    state, positions = rest(START), np.empty(commands.size)
    for k, command in enumerate(commands):
        positions[k] = state[0]
        state[:4] = event_integration(CLUTCH, state, float(command), PERIOD, options)
    return positions


def simulate_clutch_step() -> dict[str, Any]:
    """Return the row of the wall time of one step of 1.1 s."""
    controller = compile_program(controller_program(clutch_controller()))
    record = closed_loop(controller)
    acting = np.concatenate([[0.0], record[:-1, COMMAND]])  # one sample of delay
    many, theirs = pair(
        lambda: [closed_loop(controller) for _ in range(STEPS)],
        lambda: replay(acting, USUAL),
        ROUNDS,
    )
    ours, exact = many / STEPS, replay(acting, TIGHT)
    error = float(np.max(np.abs(record[:, TRUE_POSITION] - exact)))
    their_error = float(np.max(np.abs(replay(acting, USUAL) - exact)))
    return {
        "id": "simulate.clutch_step",
        "peer": "scipy solve_ivp",
        "ours": ours,
        "theirs": theirs,
        "unit": "s",
        "ratio": theirs / ours,
        "accuracy": f"position within {error:.1e} rad, peer {their_error:.1e} rad; "
        f"{SAMPLES * PERIOD / ours:.2g} times real time",
    }


def each_sample(
    record: NDArray[np.float64], commands: NDArray[np.float64], options: dict[str, Any]
) -> NDArray[np.float64]:
    """Return the positions (n - 1,) at the end of each period under LOADED, by `solve_ivp`.

    Each period begins with the state in `record`.
    """
    positions = np.empty(commands.size - 1)
    for k, command in enumerate(commands[:-1]):
        x, speed, drive, behind = record[k, [TRUE_POSITION, TRUE_VELOCITY, TRUE_DRIVE, LOAD]]
        state = np.array([x, speed, drive, x - behind])
        positions[k] = event_integration(CLUTCH, state, float(command), PERIOD, options, LOADED)[0]
    return positions


def simulate_loaded_step() -> dict[str, Any]:
    """Return the row of one step of 1.1 s under a spring, gravity and ripple.

    The load is integrated together with the motion.
    """
    controller = compile_program(controller_program(clutch_controller()))
    record = closed_loop(controller, LOADED)
    acting = np.concatenate([[0.0], record[:-1, COMMAND]])
    many, theirs = pair(
        lambda: [closed_loop(controller, LOADED) for _ in range(LOADED_STEPS)],
        lambda: each_sample(record, acting, USUAL),
        ROUNDS,
    )
    ours, exact = many / LOADED_STEPS, each_sample(record, acting, TIGHT)
    error = float(np.max(np.abs(record[1:, TRUE_POSITION] - exact)))
    their_error = float(np.max(np.abs(each_sample(record, acting, USUAL) - exact)))
    return {
        "id": "simulate.loaded_step",
        "peer": "scipy solve_ivp",
        "ours": ours,
        "theirs": theirs,
        "unit": "s",
        "ratio": theirs / ours,
        "accuracy": f"a sample within {error:.1e} rad, peer {their_error:.1e} rad; "
        f"{SAMPLES * PERIOD / ours:.2g} times real time",
    }


def simulate_random_plants() -> dict[str, Any]:
    """Return the row of the wall time per plant of a scenario with 1000 random plants.

    The time includes the log in memory. The peer simulates two plants.
    """
    controller, model = clutch_controller(), clutch_model()
    step = Step(Quantity(value=TARGET, unit="rad"), PERIOD * SAMPLES)
    start = Quantity(value=START, unit="rad")
    scenario = Scenario(
        "scenario/1", "step", "rotary", start=start, steps=(step,), variants="random", plants=PLANTS
    )
    acting = np.concatenate(
        [[0.0], closed_loop(compile_program(controller_program(controller)))[:-1, COMMAND]]
    )
    here, log = Provenance("a benchmark", "0"), None

    def ours() -> None:
        nonlocal log
        log = simulate_closed_loop(model, controller, scenario, here)

    all_of_them, two = pair(ours, lambda: [replay(acting, USUAL) for _ in range(2)], ROUNDS)
    seconds, theirs = all_of_them / PLANTS, two / 2
    assert log is not None
    assert len(log.streams) == 1 + PLANTS
    return {
        "id": "simulate.random_plants",
        "peer": "scipy solve_ivp, a plant of 2",
        "ours": seconds,
        "theirs": theirs,
        "unit": "s",
        "ratio": theirs / seconds,
        "accuracy": (
            f"{PLANTS} plants for {SAMPLES * PERIOD:g} s with their controllers, "
            f"{len(log.main.signals)} channels each, "
            f"in {all_of_them:.2g} s on {numba.get_num_threads()} threads"
        ),
    }


ROWS = [simulate_clutch_step, simulate_loaded_step, simulate_random_plants]
