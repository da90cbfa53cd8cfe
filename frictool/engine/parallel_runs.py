"""Many open-loop runs of axes in parallel on all cores.

The results do not depend on the number of threads.
"""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import OK
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

    Each command acts for one `period` [s]. Fills positions (m, n) [m | rad] with the positions at
    the beginning of each period, and statuses (m,) with codes of engine/status_codes.py. A run ends
    when the simulation fails.
    """
    for i in prange(axes.shape[0]):
        for k in range(commands.shape[1]):
            positions[i, k] = states[i, 0]
            statuses[i] = advance(states[i], commands[i, k], axes[i], period)
            if statuses[i] != OK:
                break
