"""Search by simulation for a limit cycle (thesis 5.2.1).

The search is used for controllers without a rest band: their drive is never switched off near the
target.
"""

from __future__ import annotations

import numpy as np

from frictool.adapters.axis_model import axis_of, load_of
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program, start_at
from frictool.documents.certificate import Cycle
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.engine.closed_loop import RECORD_SIZE, TRUE_POSITION, load_of_run, measure, run
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.status_codes import OK
from frictool.metrics.limit_cycle import limit_cycle
from frictool.plant.axis import rest

HELD = 300_000  # samples after the step: at 1 ms, eight periods of the slowest cycle (table 5.1)
STEP = 0.25  # length of the step, relative to the travel
ROTARY_STEP, LINEAR_STEP = 10.0, 0.1  # step [rad], [m] on a bench that states no travel


def find_cycle(model: Model, controller: Controller) -> Cycle | None:
    """Simulate a step of the nominal axis from rest; return the limit cycle that follows it.

    The result is None if the simulation shows no limit cycle. This does not prove that the axis
    has no limit cycle.
    """
    axis = axis_of(model).as_array()
    travel = model.bench.mechanics.travel
    if travel is None:
        start, length = 0.0, ROTARY_STEP if model.axis == "rotary" else LINEAR_STEP
    else:
        start, length = 0.5 * (travel.low + travel.high), STEP * (travel.high - travel.low)
    step = model.bench.encoder.resolution
    program = compile_program(controller_program(controller))
    start_at(program, measure(start, step))
    record = np.empty((HELD, RECORD_SIZE))
    period = controller.sample_period_s
    status = run(
        axis,
        rest(start),
        program,
        np.full(HELD, start + length),
        period,
        controller.delay_samples,
        record,
        load_of_run(axis, load_of(model).as_array()),
        NO_CONDITIONS,
    )
    if status != OK:
        return None
    time = period * np.arange(HELD, dtype=np.float64)
    found = limit_cycle(time, record[:, TRUE_POSITION], step)
    if not found.amplitude or found.period is None:
        return None
    return Cycle(start + length, found.amplitude, found.period)
