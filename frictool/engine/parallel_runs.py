"""Many runs in parallel on all cores.

Runs share no data that they write, so that results do not depend on the number of threads.
"""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from frictool.control.compiled_program import CompiledProgram, copy_program, start_at
from frictool.engine.axis_motion import advance
from frictool.engine.closed_loop import measure
from frictool.engine.closed_loop import run as run_loop
from frictool.engine.status_codes import OK
from frictool.plant.axis import ENCODER_STEP
from frictool.runtime.kernels import parallel_kernel
from frictool.typing import Vector


@parallel_kernel
def replay_axes(
    axes: Vector,
    states: Vector,
    commands: Vector,
    period: float,
    positions: Vector,
    statuses: NDArray[np.int64],
) -> None:
    """Simulate many axes (m, a) with states (m, 7), in place, under commands (m, n).

    Each command is held for a `period` [s]. positions (m, n) [m | rad]: filled with the positions
    at the beginning of each period. statuses (m,): engine/status_codes.py; a run that fails stops
    there.
    """
    for i in prange(axes.shape[0]):
        for k in range(commands.shape[1]):
            positions[i, k] = states[i, 0]
            statuses[i] = advance(states[i], commands[i, k], axes[i], period)
            if statuses[i] != OK:
                break


@parallel_kernel
def closed_loops(
    axes: Vector,
    states: Vector,
    controller: CompiledProgram,
    references: Vector,
    period: float,
    delay_samples: int,
    records: Vector,
    statuses: NDArray[np.int64],
    load: Vector,
    conditions: Vector,
) -> None:
    """Simulate many closed loops, engine/closed_loop.py `run` for each row.

    axes (m, a), states (m, 7), references (m, n). Each loop has its own copy of the controller,
    started at rest at the measured position. All have the same load and the same conditions (n, 8)
    or (0, 8). Fills records (m, n, 7) and statuses (m,).
    """
    for i in prange(axes.shape[0]):
        copy = copy_program(controller)
        start_at(copy, measure(states[i, 0], axes[i, ENCODER_STEP]))
        statuses[i] = run_loop(
            axes[i],
            states[i],
            copy,
            references[i],
            period,
            delay_samples,
            records[i],
            load,
            conditions,
        )
