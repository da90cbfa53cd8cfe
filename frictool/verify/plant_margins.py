"""Fast modulus margins of a controller's sampled loops, for the thousands of plants of a campaign.

The margin is 1/max |1/(1 + L)|; verify/feedback_loops.py defines the loop gain L, which includes
the computational delay. Compiled kernels assemble the matrices of the closed loop. The
eigenvectors of the closed loop give the gain at many frequencies in one call; the kernels then
refine the peak.
"""

from __future__ import annotations

import numpy as np

from frictool.adapters.state_space import read_state_space
from frictool.documents.controller import Controller
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.verify.feedback_loops import (
    DIFFERENCE,
    ETA,
    SPEED,
    FeedbackLoop,
    feedbacks_of,
)
from frictool.verify.hinf_norm import norm
from frictool.verify.logged_plant import LoggedPlant
from frictool.verify.margin_kernels import (
    SEES_DIFFERENCE,
    SEES_ETA,
    SEES_SPEED,
    UNKNOWN,
    peak,
    sampled_axis,
    sensitivity,
)
from frictool.verify.scheduled_loop import interpolate_controller, weights

# number of frequencies of the search in addition to the modes' frequencies, over six decades below
# half the sampling frequency
POINTS = 120
SIGNALS = {ETA: SEES_ETA, DIFFERENCE: SEES_DIFFERENCE, SPEED: SEES_SPEED}


class PlantMargins:
    """Function that maps a plant to the smallest modulus margin of one controller's loops.

    The matrices of a scheduled controller are interpolated for the parameters of the plant.
    """

    def __init__(self, controller: Controller) -> None:
        self._lag = controller.bench.actuator.loop_time_constant_s
        self._delay = controller.delay_samples
        self._period, self._schedule = controller.sample_period_s, controller.schedule
        self._loops = feedbacks_of(controller)
        self._grid = np.append(0.0, np.geomspace(1e-6 * np.pi, np.pi, POINTS))

    def __call__(self, plant: LoggedPlant) -> float:
        """Return the smallest modulus margin over all viscous frictions and drive constants.

        The result is 0 if a loop is unstable.
        """
        loops = self._scheduled(plant.point) if self._schedule is not None else self._loops
        return min(self.of(loop, point.rates) for loop in loops for point in plant.points())

    def at(self, point: PlantPoint) -> float:
        """Return the smallest modulus margin of the loops with a constant plant; 0 if unstable."""
        slopes, constants = (point.viscous,), (point.constant,)
        return self(
            LoggedPlant(
                point.inertia, point.viscous, point.coulomb, point.constant, slopes, constants
            )
        )

    def of(self, loop: FeedbackLoop, rates: AxisRates) -> float:
        """Return the modulus margin of one loop with one plant; 0 if the loop is unstable."""
        c = loop.system
        sees = np.array([SIGNALS[name] for name in loop.sees])
        axis = sampled_axis(rates.drive, rates.viscous, self._lag, self._period, sees)
        closed = sensitivity((c.a, c.b, c.c, c.d), self._delay, axis)
        poles, vectors = np.linalg.eig(closed[0])
        if poles.size and np.max(np.abs(poles)) >= 1.0:
            return 0.0
        largest = peak(closed, poles.astype(complex), vectors.astype(complex), self._grid)
        if largest == UNKNOWN:
            a, b, rows = closed
            largest, _ = norm(Lti(a, b[:, None], rows[None, :], np.eye(1), self._period))
        return 1.0 / largest

    def _scheduled(self, point: PlantPoint) -> tuple[FeedbackLoop, ...]:
        assert self._schedule is not None
        corners = [
            read_state_space(corner.discrete, self._period) for corner in self._schedule.corners
        ]
        running = interpolate_controller(
            corners, weights(self._schedule.corners, self._schedule.parameters, point)
        )
        return tuple(FeedbackLoop(loop.name, running, loop.sees) for loop in self._loops)
