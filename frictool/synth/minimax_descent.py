"""Minimisation of the worst norm of several loops over the parameters of one controller.

    minimise t   subject to   gain(plant, frequency) <= t   and   M |S(plant, frequency)| <= 1

S is the sensitivity, M the required modulus margin. The problem is solved for finitely many
frequencies by sequential quadratic programming (scipy's SLSQP), in a trust region (box) around the
current parameters. Then the exact norm of every loop and its peak frequency are computed. The step
is accepted only if every loop is stable and the new point is better: a violation of the margin is
smaller or, without a violation, the exact worst norm is smaller. After a rejected step, the box
shrinks. The peak frequencies
are added to the finite set, so that the maximum over the set converges to the exact norm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.synth.structured_controller import StructuredController
from frictool.synth.worst_norm import OpenLoopResponses, all_stable, sensitivity_plant, true_norms
from frictool.typing import Vector

GRID = 100  # frequencies of the grid
ACTIVE = 0.6  # fraction of the worst gain; a step ignores smaller gains
REMEMBERED = 8  # peak frequencies kept per plant
STEPS = 30  # largest number of iterations of SLSQP within one box
# half-widths of the box, in scaled parameters
FIRST_BOX, LARGEST_BOX, SMALLEST_BOX = 0.5, 1.0, 1e-4
SETTLED = 1e-6  # relative improvement below which a descent has converged


@dataclass(frozen=True)
class DescentPoint:
    """Parameters of the controller, with the exact worst norm and the violation of the margin.

    missed: violation max(0, M max|S| - 1) of the required modulus margin M; S is the sensitivity.
    """

    parameters: Vector
    worst: float
    missed: float

    def better_than(self, other: DescentPoint) -> bool:
        """Return True if this point is better than `other`.

        The better point violates the margin less. If neither point violates the margin, the better
        point has the smaller norm.
        """
        if max(self.missed, other.missed) > SETTLED:
            return self.missed < other.missed * (1.0 - SETTLED)
        return self.worst < other.worst * (1.0 - SETTLED)


class MinimaxDescent:
    """Descent of the worst norm of several plants for one controller structure.

    margin: required modulus margin M of every loop; 0 if no margin is required.
    """

    def __init__(
        self,
        structure: StructuredController,
        plants: Sequence[GeneralisedPlant],
        slowest: float,
        margin: float = 0.0,
    ) -> None:
        """Build the frequency grid, which starts at `slowest` [rad/s].

        The grid ends at ten times the pole bound, or for a sampled controller at half the sampling
        frequency.
        """
        top = 0.9999 * np.pi / structure.period if structure.period else 10.0 * structure.bound
        self.structure = structure
        self.plants = list(plants)
        self.margin = margin
        self.grid = np.geomspace(slowest, top, GRID)
        self.on_grid = [OpenLoopResponses.of(plant, self.grid) for plant in plants]
        self.peaks: list[list[float]] = [[] for _ in plants]
        # frequencies of sensitivity peaks, per plant
        self.steep: list[list[float]] = [[] for _ in plants]
        self._sensitivities = [sensitivity_plant(plant) for plant in plants] if margin else []

    def on(self, structure: StructuredController) -> MinimaxDescent:
        """Return a descent for another structure with the same plants and time domain."""
        return MinimaxDescent(structure, self.plants, float(self.grid[0]), self.margin)

    def coarse(self, parameters: Vector) -> float:
        """Return an upper bound of the largest gain on the frequency grid; inf if unstable."""
        if not all_stable(self.structure.system(parameters), self.plants):
            return np.inf
        k, _ = self.structure.response(parameters, self.structure.points(self.grid))
        return float(max(np.max(open_loop.bounds(k)) for open_loop in self.on_grid))

    def point(self, parameters: Vector) -> DescentPoint:
        """Return the exact worst norm at the parameters, and store the peak frequencies."""
        k = self.structure.system(parameters)
        if not all_stable(k, self.plants):
            return DescentPoint(parameters, np.inf, np.inf)
        missed = 0.0
        if self.margin:
            missed = max(
                0.0, self.margin * self._remember(self.steep, k, self._sensitivities) - 1.0
            )
        return DescentPoint(parameters, self._remember(self.peaks, k, self.plants), missed)

    def _remember(
        self, peaks: list[list[float]], k: Lti, plants: Sequence[GeneralisedPlant]
    ) -> float:
        norms = true_norms(k, plants, peaks)
        for memory, (_, at) in zip(peaks, norms, strict=True):
            if np.isfinite(at):
                memory[:] = [*memory, float(np.clip(at, self.grid[0], self.grid[-1]))][-REMEMBERED:]
        return max(value for value, _ in norms)

    def run(self, start: Vector, rounds: int) -> DescentPoint:
        """Return the result of at most `rounds` descent steps, never worse than the start.

        start: parameters that stabilise every plant.
        """
        here = self.point(start)
        box = FIRST_BOX
        for _ in range(rounds):
            if not np.isfinite(here.worst):
                break
            proposed, promised = self._step(here, box)
            there = self.point(proposed)
            if there.better_than(here):
                settled = (
                    here.worst - there.worst < 10.0 * SETTLED * here.worst
                    and there.missed == here.missed
                )
                box = (
                    min(LARGEST_BOX, 2.0 * box)
                    if there.worst - promised < 0.3 * (here.worst - promised)
                    else box
                )
                here = there
                if settled:
                    break
            else:
                box *= 0.25
                if box < SMALLEST_BOX:
                    break
        return here

    def _step(self, here: DescentPoint, box: float) -> tuple[Vector, float]:
        """Return new parameters for the next step, and their predicted worst norm.

        Scaled parameters change by at most `box`. The prediction is the largest gain on the finite
        set of frequencies.
        """
        structure = self.structure
        low, high = structure.limits()
        scale = np.ones(structure.size)
        scale[structure.free :] = np.maximum(np.abs(here.parameters[structure.free :]), 1e-2)
        sets = _FiniteSet.of(self, here)
        start = np.append(here.parameters / scale, sets.largest(here.parameters))
        least = np.maximum(low / scale, start[:-1] - box)
        most = np.minimum(high / scale, start[:-1] + box)

        minimum = scipy.optimize.minimize(
            lambda x: x[-1],
            start,
            jac=lambda x: np.eye(len(x))[-1],
            bounds=[*zip(least, most, strict=True), (0.0, None)],
            constraints={
                "type": "ineq",
                "fun": lambda x: sets.slack(x[:-1] * scale, x[-1]),
                "jac": lambda x: sets.slack_slopes(x[:-1] * scale) * np.append(scale, 1.0),
            },
            method="SLSQP",
            options={"maxiter": STEPS, "ftol": 0.1 * SETTLED},
        )
        if not np.all(np.isfinite(minimum.x)):
            return here.parameters, here.worst
        return np.clip(minimum.x[:-1], least, most) * scale, float(minimum.x[-1])


@dataclass(frozen=True)
class _FiniteSet:
    """Gains and sensitivities at the finitely many frequencies of a descent step.

    The frequencies are the stored peak frequencies, and the grid points with a gain near the
    maximum.
    """

    structure: StructuredController
    open_loop: OpenLoopResponses
    frequencies: Vector
    steep: OpenLoopResponses | None
    steep_frequencies: Vector
    margin: float

    @staticmethod
    def of(descent: MinimaxDescent, here: DescentPoint) -> _FiniteSet:
        structure, grid = descent.structure, descent.grid
        k, _ = structure.response(here.parameters, structure.points(grid))
        chosen = [
            np.append(grid[loop.bounds(k) > ACTIVE * here.worst], peaks)
            for loop, peaks in zip(descent.on_grid, descent.peaks, strict=True)
        ]
        gains = OpenLoopResponses.joined(
            [
                OpenLoopResponses.of(plant, w)
                for plant, w in zip(descent.plants, chosen, strict=True)
            ]
        )
        steep = None
        at = np.empty(0)
        if descent.margin:
            looked = [
                np.append(grid[loop.sensitivity().gains(k) * descent.margin > ACTIVE], peaks)
                for loop, peaks in zip(descent.on_grid, descent.steep, strict=True)
            ]
            steep = OpenLoopResponses.joined(
                [
                    OpenLoopResponses.of(plant, w)
                    for plant, w in zip(descent.plants, looked, strict=True)
                ]
            ).sensitivity()
            at = np.concatenate(looked)
        return _FiniteSet(structure, gains, np.concatenate(chosen), steep, at, descent.margin)

    def largest(self, parameters: Vector) -> float:
        k, _ = self.structure.response(parameters, self.structure.points(self.frequencies))
        return float(np.max(self.open_loop.gains(k)))

    def slack(self, parameters: Vector, level: float) -> Vector:
        """Return the slack of each constraint, at least 0 if the constraint holds.

        The constraints are gain <= `level`, and (required modulus margin) |sensitivity| <= 1.
        """
        k, _ = self.structure.response(parameters, self.structure.points(self.frequencies))
        rows = [level - self.open_loop.gains(k)]
        if self.steep is not None:
            k, _ = self.structure.response(
                parameters, self.structure.points(self.steep_frequencies)
            )
            rows.append(1.0 - self.margin * self.steep.gains(k))
        return np.concatenate(rows)

    def slack_slopes(self, parameters: Vector) -> Vector:
        """Return the Jacobian of `slack`: one column per parameter, the last column for `level`."""
        k, by = self.structure.response(parameters, self.structure.points(self.frequencies))
        rows = [np.column_stack([-self.open_loop.slopes(k, by), np.ones(len(k))])]
        if self.steep is not None:
            k, by = self.structure.response(
                parameters, self.structure.points(self.steep_frequencies)
            )
            rows.append(
                np.column_stack([-self.margin * self.steep.slopes(k, by), np.zeros(len(k))])
            )
        return np.vstack(rows)
