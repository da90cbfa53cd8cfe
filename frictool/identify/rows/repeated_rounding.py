"""Error of the inertia due to the encoder's rounding, from rounding the smoothed motion again.

The largest possible error (`quantisation_limit`) has the worst sign at every sample. If the motion
passes many counts, the signs alternate, and the error is much smaller. It is computed in three
steps:

1. The smoothed position is rounded by encoders whose counts begin at PHASES different positions.
2. The fitted inertia and viscous friction give an effort along the smoothed motion.
3. This effort is fitted again, with acceleration and velocity from each rounded position. The
   largest change of the inertia is the error.

A controller may also respond to the rounding. The error leaves out this response; `attenuation` of
the fit (the relative decrease of the inertia by noise) allows for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from frictool.identify.fit_result import SlidingFit
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.regression_samples import RegressionSamples
from frictool.identify.rows.smoothing import smoothed, smoothing_kernel
from frictool.typing import Matrix, Vector

PHASES = 8  # encoders, whose counts begin at equal distances within a count


@dataclass(frozen=True)
class UsedRows:
    """Rows of one record in a fit.

    - record: record of a measured position
    - window: smoothing window, samples
    - mask: True at the samples that are rows, (n,)
    """

    record: MotionRecord
    window: int
    mask: NDArray[np.bool_]

    def smooth_position(self) -> Vector:
        """Return the smoothed position (n,) [rad | m]; near the ends, the measured position."""
        position = self.record.position
        kernel = smoothing_kernel(self.window, self.record.period)
        out = position.copy()
        if position.size >= kernel.size:
            ends = kernel.size // 2
            moved = np.convolve(position - position[0], kernel, mode="valid")
            out[ends : position.size - ends] = position[0] + moved
        return out

    def signals(self, position: Vector) -> Matrix:
        """Return acceleration and velocity (2, m) of another position (n,) at the rows."""
        acceleration, velocity, _ = smoothed(replace(self.record, position=position), self.window)
        return np.array([acceleration[self.mask], velocity[self.mask]])


def inertia_change(fit: SlidingFit, samples: RegressionSamples, parts: Sequence[UsedRows]) -> float:
    """Return the largest change of the fitted inertia by repeated rounding [kg m^2 | kg].

    `samples` are the rows (m,) of the fit, from all `parts` in their order.
    """
    known = {name: one.value for name, one in fit.parameters.items()}
    motion = [(part, part.smooth_position()) for part in parts]
    acceleration, velocity = np.hstack([part.signals(x) for part, x in motion])
    inertia = known["inertia"]
    effort = inertia * acceleration + known.get("viscous", 0.0) * velocity
    others = np.array([*samples.columns[2:], *samples.loads.values()])
    largest = 0.0
    for k in range(PHASES):
        rounded = np.hstack(
            [part.signals(_rounded(x, part.record.resolution, k / PHASES)) for part, x in motion]
        )
        columns = np.vstack([rounded, others])
        scale = np.linalg.norm(columns, axis=1)
        scale[scale == 0.0] = 1.0
        columns /= scale[:, None]
        found = np.linalg.lstsq(columns @ columns.T, columns @ effort, rcond=None)[0]
        largest = max(largest, abs(found[0] / scale[0] - inertia))
    return largest


def _rounded(position: Vector, count: float, phase: float) -> Vector:
    return count * np.floor(position / count + phase)
