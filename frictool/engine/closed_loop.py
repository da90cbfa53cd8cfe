"""The sampled controller around the axis: what the target sees and does at every sample, and the axis in between.

    sample k:  position --[encoder: floor(x/step) step]--> y[k] --[controller]--> u[k] --[delay_samples]--> held until k+1

The counter of an incremental encoder changes at its edges: it reports the edge below, hence floor. The command of sample k acts
from sample k + delay_samples on; before the first one arrives the command is zero. Both controller and axis limit the drive.
A drive without lag jumps at the sample: the record holds the value that it has until the next one.

A load that depends on position (plant/load.py) is held over a part of a period at its value half a part ahead, as in engine/replay.py: an
error of second order in the part. At rest the position does not change, nor does the load: what rests stays where it is, exactly.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.control.cascade import control_step
from frictool.engine.axis import advance
from frictool.engine.status import OK
from frictool.kernels import kernel
from frictool.plant.axis import DRIVE, DRIVE_LIMIT, ENCODER_STEP, LAG, LOAD_POSITION, MODE, OFFSET, POSITION, VELOCITY
from frictool.plant.load import load_effort

Vector = NDArray[np.float64]

# columns of the record, one row a sample, as things are at that sample
MEASURED, TRUE_POSITION, TRUE_VELOCITY, LOAD, COMMAND, TRUE_DRIVE, TRUE_MODE = 0, 1, 2, 3, 4, 5, 6
RECORD_SIZE = 7

LOAD_PARTS = 4  # of a period, where there is a load


@kernel
def measure(position: float, step: float) -> float:
    """What an encoder of this step reports [rad | m]; the position itself where the step is 0."""
    return math.floor(position / step) * step if step > 0.0 else position


@kernel
def run(
    axis: Vector,
    state: Vector,
    controller: Vector,
    controller_state: Vector,
    reference: Vector,
    period: float,
    delay_samples: int,
    record: Vector,
    load: Vector,
) -> int:
    """Runs the loop over `reference` (n,), one value a `period` [s]; fills `record` (n, 7). Returns engine/status.py.

    axis (a,) and state (7,): plant/axis.py, the state in place; controller and controller_state: control/cascade.py, the state in
    place. load: plant/load.py. Where the status is not OK the record is filled up to the failing sample.
    """
    p, parts = axis.copy(), LOAD_PARTS if load.shape[0] > 0 else 1
    part = period / parts
    waiting = np.zeros(delay_samples + 1)
    for k in range(reference.shape[0]):
        measured = measure(state[POSITION], axis[ENCODER_STEP])
        command = control_step(controller, controller_state, reference[k], measured)
        waiting[k % (delay_samples + 1)] = command
        acting = waiting[(k + 1) % (delay_samples + 1)]
        record[k, MEASURED] = measured
        record[k, TRUE_POSITION] = state[POSITION]
        record[k, TRUE_VELOCITY] = state[VELOCITY]
        record[k, LOAD] = state[LOAD_POSITION]
        record[k, COMMAND] = command
        record[k, TRUE_DRIVE] = state[DRIVE] if axis[LAG] > 0.0 else min(max(acting, -axis[DRIVE_LIMIT]), axis[DRIVE_LIMIT])
        record[k, TRUE_MODE] = state[MODE]
        for _ in range(parts):
            if load.shape[0] > 0:
                p[OFFSET] = axis[OFFSET] + load_effort(load, state[POSITION] + 0.5 * part * state[VELOCITY])
            status = advance(state, acting, p, part)
            if status != OK:
                return status
    return OK
