"""Modulus margins of a controller's sampled loops with any plant, fast enough for campaigns.

The loop is that of verify/feedback_loops.py at the bench's delay; its margin is 1/max |1/(1 + L)|.
A campaign computes it for thousands of plants. Therefore the matrices are assembled here directly,
and the peak is searched with the eigenvectors of the closed loop, which give the gain at many
frequencies at once.
"""

from __future__ import annotations

import numpy as np

from frictool.adapters.state_space import read_state_space
from frictool.documents.controller import Controller
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti, delay
from frictool.plant.polytope import PlantPoint
from frictool.typing import ComplexVector, Vector
from frictool.verify.feedback_loops import FeedbackLoop, feedbacks_of, measured_axis
from frictool.verify.hinf_norm import gains, norm
from frictool.verify.logged_plant import LoggedPlant
from frictool.verify.scheduled_loop import interpolate_controller, weights

# frequencies of the search besides those of the modes, over six decades below half the sampling
# frequency
POINTS = 120
NEAR = 0.9  # share of the largest gain above which a maximum is refined
ZOOMS, ZOOMED = 4, 11  # rounds of refinement, and frequencies in each
# relative difference between the gain by the modes and by the matrices, above which the norm is
# computed without the modes
AGREEMENT = 1e-7


class PlantMargins:
    """Modulus margins of one controller's loops; call it with a plant.

    A scheduled controller runs with the matrices interpolated for the plant's parameters, any other
    controller with its stored matrices.
    """

    def __init__(self, controller: Controller) -> None:
        self._lag = controller.bench.actuator.loop_time_constant_s
        self._delay = controller.delay_samples
        self._period, self._schedule = controller.sample_period_s, controller.schedule
        self._loops = feedbacks_of(controller)
        angles = np.append(0.0, np.geomspace(1e-6 * np.pi, np.pi, POINTS))
        self._angles = angles
        self._circle = np.exp(1j * angles)

    def __call__(self, plant: LoggedPlant) -> float:
        """Return the smallest margin over the plant's slopes and constants; 0 if unstable."""
        loops = self._scheduled(plant.point) if self._schedule is not None else self._loops
        return min(self.of(loop, point.rates) for loop in loops for point in plant.points())

    def at(self, point: PlantPoint) -> float:
        """Return the smallest margin of the loops with one constant plant; 0 if unstable."""
        slopes, constants = (point.viscous,), (point.constant,)
        return self(
            LoggedPlant(
                point.inertia, point.viscous, point.coulomb, point.constant, slopes, constants
            )
        )

    def of(self, loop: FeedbackLoop, rates: AxisRates) -> float:
        """Return the margin of one loop with one plant; 0 if it is unstable."""
        closed = self._sensitivity(loop, rates)
        poles, vectors = np.linalg.eig(closed.a)
        if poles.size and np.max(np.abs(poles)) >= 1.0:
            return 0.0
        return 1.0 / self._peak(closed, poles, vectors)

    def _scheduled(self, point: PlantPoint) -> tuple[FeedbackLoop, ...]:
        assert self._schedule is not None
        corners = [
            read_state_space(corner.discrete, self._period) for corner in self._schedule.corners
        ]
        running = interpolate_controller(
            corners, weights(self._schedule.corners, self._schedule.parameters, point)
        )
        return tuple(FeedbackLoop(loop.name, running, loop.sees) for loop in self._loops)

    def _sensitivity(self, loop: FeedbackLoop, rates: AxisRates) -> Lti:
        """Return 1/(1 + L) with the states of controller, delay and axis.

        Its input is added to the controller's drive.
        """
        c = loop.system
        wait = delay(self._delay, self._period)
        axis = measured_axis(rates, self._lag, self._period, loop.sees).system
        # outputs after the speed; input of the command
        seen = axis.c[1:]
        push = axis.b[:, :1]
        n, d, m = c.order, wait.order, axis.order
        a = np.zeros((n + d + m, n + d + m))
        b = np.zeros((n + d + m, 1))
        rows = np.zeros((1, n + d + m))
        # the requested drive
        rows[:, :n] = c.c
        rows[:, n + d :] = c.d @ seen
        a[:n, :n] = c.a
        a[:n, n + d :] = c.b @ seen
        a[n : n + d, n : n + d] = wait.a
        a[n + d :, n : n + d] = push @ wait.c
        a[n + d :, n + d :] = axis.a
        b[n : n + d] = wait.b
        b[n + d :] = push @ wait.d
        return Lti(a + b @ rows, b, rows, np.eye(1), self._period)

    def _peak(self, closed: Lti, poles: ComplexVector, vectors: ComplexVector) -> float:
        """Return the largest gain of a stable loop.

        The modes locate its frequency, and the matrices give its value.
        """
        try:
            residues = (closed.c @ vectors)[0] * np.linalg.solve(vectors, closed.b.astype(complex))[
                :, 0
            ]
        except np.linalg.LinAlgError:  # the matrix is defective: the modes are no basis
            return norm(closed)[0]

        def by_modes(circle: ComplexVector) -> Vector:
            return np.asarray(
                np.abs(closed.d[0, 0] + (residues / (circle[:, None] - poles)).sum(axis=1))
            )

        angles = np.concatenate([self._angles, np.abs(np.angle(poles))])
        responses = by_modes(
            np.concatenate([self._circle, np.exp(1j * angles[len(self._angles) :])])
        )
        order = np.argsort(angles, kind="stable")
        angles, responses = angles[order], responses[order]
        looks = np.empty(0)
        expected = 0.0
        for k in np.flatnonzero(responses >= NEAR * responses.max()).tolist():
            if (
                responses[k] < responses[max(k - 1, 0)]
                or responses[k] < responses[min(k + 1, len(responses) - 1)]
            ):
                continue
            low = angles[max(k - 1, 0)]
            high = angles[min(k + 1, len(angles) - 1)]
            for _ in range(ZOOMS):
                near = np.linspace(low, high, ZOOMED)
                inner = by_modes(np.exp(1j * near))
                best = int(np.argmax(inner))
                low = near[max(best - 1, 0)]
                high = near[min(best + 1, ZOOMED - 1)]
            looks = np.append(looks, near[best])
            expected = max(expected, float(inner[best]))
        peak = float(np.max(gains(closed, looks / self._period)))
        return peak if abs(peak - expected) <= AGREEMENT * peak else norm(closed)[0]
