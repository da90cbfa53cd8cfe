"""Sensor position under test commands, simulated with a mechanism or its one-inertia model."""

from __future__ import annotations

import numpy as np

from frictool.adapters.axis_model import axis_of, load_of
from frictool.documents.model import Model
from frictool.engine.axis_motion import advance as advance_axis
from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import rest
from frictool.engine.status_codes import MESSAGES, OK
from frictool.errors import NoSolutionError
from frictool.plant.axis import POSITION, RESISTANCE
from frictool.plant.axis import rest as axis_rest
from frictool.plant.position_load import with_load
from frictool.reduce.coordinate_change import MechanismView
from frictool.typing import Vector

# steps per period; the current limit of a winding is constant in a step (engine/closed_loop.py)
PARTS = 4


def mechanism_positions(
    here: MechanismView, source: str, sensor: str, position: float, command: Vector
) -> Vector:
    """Return the positions (n,) [rad | m] of the sensor's block, simulated under `command` (n,).

    All blocks start at rest, each backlash in its middle. The root block of the mechanism
    `here` starts at `position`. Raises NoSolutionError if the simulation fails.
    """
    assembled = here.assembled
    names = here.assembled.blocks
    start = np.array([frame.ratio * position + frame.offset for frame in map(here.frame, names)])
    machine = prepare(assembled.packed)
    state = rest(assembled.packed, machine, start)
    driven = assembled.sources.index(source)
    seen = assembled.sensor_blocks[assembled.sensors.index(sensor)]
    commands = np.zeros((command.shape[0], len(assembled.sources)))
    commands[:, driven] = command
    output = run(machine, state, commands, here.document.sample_period_s, most_events=0)
    if output.status != OK:
        raise NoSolutionError(
            f"{here.document.name}: not simulated: {MESSAGES[output.status]} "
            f"(after {output.reached:.6g} s)"
        )
    return np.ascontiguousarray(output.positions[seen, :-1])


def model_positions(model: Model, start: float, command: Vector) -> Vector:
    """Return the positions (n,) [rad | m] of the model's axis, simulated from rest at `start`.

    The axis starts in the middle of the backlash. Raises NoSolutionError if the simulation fails.
    """
    p = with_load(axis_of(model).as_array(), load_of(model).as_array())
    state = axis_rest(start)
    period = model.bench.sample_period_s
    parts = PARTS if p[RESISTANCE] > 0.0 else 1
    positions = np.empty(command.shape[0])
    for k, value in enumerate(command):
        positions[k] = state[POSITION]
        for _ in range(parts):
            status = advance_axis(state, value, p, period / parts)
            if status != OK:
                raise NoSolutionError(
                    f"{model.name}: not simulated: {MESSAGES[status]} (sample {k})"
                )
    return positions
