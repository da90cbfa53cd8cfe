"""H-infinity synthesis with Lyapunov matrices that depend on scheduled parameters, on a grid that
is checked between its points.

X(r) and Y(r) of (5.62) are constant, affine or quadratic in r, each r_j in [-1, 1] with a bounded
speed (lmi/grid_inequalities.py). Speeds without bound and constant X, Y are theorem 5.3.1; one r is
an LTI problem.

A grid proves nothing between its points: after each solution the inequalities are evaluated on a
finer grid that is offset from it, and the points where they fail join the grid. What is said to
hold was evaluated so, and is still no proof for every r; the frozen controller has the norm of its
own loops. Several plants at one r (vertices of parameters that X and Y do not depend on) are
covered with their hull.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from frictool.errors import NoSolutionError
from frictool.lmi.grid_inequalities import GridInequalities, GridPlants, ParameterBasis, Values
from frictool.lmi.hinf_synthesis import (
    INFEASIBLE,
    NO_GAMMA,
    RELAX,
    SETTLED,
    SMALLEST_INVERSE,
    STRICT,
    TRACE_SLACK,
    scale_level,
)
from frictool.lmi.parrott_reconstruction import central
from frictool.lmi.pole_regions import TransformVariable, frame, refuse_fixed_modes
from frictool.lmi.sdp import AffineConstraint, solve, upper_triangle
from frictool.lmi.state_balancing import balancing, even_out
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]
Family = Callable[[Values], Sequence[GeneralisedPlant]]  # scheduled values -> the plants there
PASSES = 6  # of balancing, at most
ROUNDS = 12  # of points that join the grid
JOINING = 4  # of them at once, the worst
FINER = (
    1,
    16,
    8,
    4,
)  # intervals of the finer grid to one of the first, for 0, 1, 2, 3 and more parameters
# of the recentring (its power): the gamma at which the finer grid is judged, so that something is
# left between its points
INSIDE = 0.75


@dataclass(frozen=True)
class GridSchedule:
    """How X and Y depend on the parameters.

    rates (r,): bounds of their speeds, in half-widths per s, per sample for sampled plants;
    infinite: X and Y do not depend on that one. degrees: of X and Y, 0 to 2. points: of the first
    grid along each parameter.
    """

    rates: tuple[float, ...]
    degrees: tuple[int, int] = (1, 1)
    points: int = 3


@dataclass(frozen=True)
class GriddedSolution:
    """X, Y by the terms of their bases, in the states x = t x_balanced of the frame's variable;
    gamma >= optimum, at which they hold.

    motions: corners of the rates (steps in discrete time), in the frame's unit of time. points: of
    the grid in the end. checked: at how many points in all, the finer grid's among them, the
    inequalities were evaluated.
    """

    x: Matrix
    y: Matrix
    bases: tuple[ParameterBasis, ParameterBasis]
    motions: tuple[Values, ...]
    t: Matrix
    frame: TransformVariable
    optimum: float
    gamma: float
    points: tuple[Values, ...]
    checked: int

    def frozen(self, plant: GeneralisedPlant, values: Sequence[float]) -> Lti:
        """The central controller of a plant at r, which keeps gamma there.

        Raises NoSolutionError where X and Y do not admit one to working precision.
        """
        x, y = (
            np.tensordot(basis.at(values), v, 1)
            for basis, v in zip(self.bases, (self.x, self.y), strict=True)
        )
        try:
            found = central(self.frame.plant(plant).transformed(self.t), x, y, self.gamma)
        except np.linalg.LinAlgError as error:
            raise NoSolutionError(
                f"the controller's reconstruction broke down numerically ({error}); {RELAX}"
            ) from None
        return self.frame.back(found, plant.period)


def minimise(family: Family, schedule: GridSchedule, recentring: float) -> GriddedSolution:
    """The smallest gamma on the grid, then X and Y recentred at `recentring` times it, at which
    they hold between its points too.

    `family`: the plants of one domain at values (r,) in [-1, 1]. Raises NoSolutionError where the
    inequalities are infeasible, where they do not hold, evaluated again, at what the solver
    returns, or still fail between the points after ROUNDS refinements.
    """
    try:
        return _GridSearch(family, schedule, recentring).found()
    except np.linalg.LinAlgError as error:
        raise NoSolutionError(
            f"the gridded synthesis broke down numerically ({error}); {RELAX}"
        ) from None


class _GridSearch:
    """The grid as it grows, and the coordinates as they settle."""

    def __init__(self, family: Family, schedule: GridSchedule, recentring: float) -> None:
        self.family, self.recentring, parameters = family, recentring, len(schedule.rates)
        self.grid: list[Values] = list(
            product(*[np.linspace(-1.0, 1.0, schedule.points).tolist()] * parameters)
        )
        count = FINER[min(parameters, 3)] * (schedule.points - 1)
        offset = (
            [-1.0, *(-1.0 + (2.0 * np.arange(count) + 1.0) / count).tolist(), 1.0]
            if count
            else [0.0]
        )
        self.finer: list[Values] = list(product(*[offset] * parameters))
        everywhere = [plant for values in self.grid for plant in family(values)]
        self.frame = frame(everywhere, None)
        framed = [self.frame.plant(plant) for plant in everywhere]
        self.t, self.level = even_out(framed), 1.0
        refuse_fixed_modes([plant.transformed(self.t) for plant in framed], self.frame)
        speeds = [
            rate if self.frame.disc else rate * self.frame.scale for rate in schedule.rates
        ]  # time in the frame's unit
        on = tuple(j for j, speed in enumerate(speeds) if np.isfinite(speed))
        self.bases = (
            ParameterBasis(schedule.degrees[0], on),
            ParameterBasis(schedule.degrees[1], on),
        )
        rest = (
            (0.0,) if self.frame.disc and max(schedule.degrees) == 2 else ()
        )  # a step in a square is not linear: standing still is no mean
        self.motions: list[Values] = list(
            product(*((-s, *rest, s) if np.isfinite(s) and s > 0.0 else (0.0,) for s in speeds))
        )

    def found(self) -> GriddedSolution:
        for _ in range(ROUNDS):
            x, y, optimum = self.solved()
            gamma = self.recentring * optimum
            failing = self.failing(x, y, self.recentring**INSIDE * optimum, self.finer)
            if not failing:
                checked = len(dict.fromkeys([*self.grid, *self.finer]))
                found = (optimum * self.level, gamma * self.level)
                return GriddedSolution(
                    x,
                    y,
                    self.bases,
                    tuple(self.motions),
                    self.t,
                    self.frame,
                    *found,
                    tuple(self.grid),
                    checked,
                )
            self.grid += failing[:JOINING]
        raise NoSolutionError(
            f"the inequalities hold on the grid and fail between its points after {ROUNDS} refinements (gamma {gamma * self.level:.4g}); "
            "raise `recentring`, take a lower degree or slower parameters"
        )

    def inequalities(self, points: Sequence[Values]) -> GridInequalities:
        cells = [
            GridPlants(
                values,
                tuple(
                    scale_level(self.frame.plant(plant), self.level).transformed(self.t)
                    for plant in self.family(values)
                ),
            )
            for values in points
        ]
        return GridInequalities(cells, self.bases, self.motions)

    def solved(self) -> tuple[Matrix, Matrix, float]:
        """X, Y in the last coordinates, recentred, and the optimum in units of the last level."""
        for k in range(PASSES + 1):
            problem = self.inequalities(self.grid)
            optimum = _optimum(problem)
            gamma, inner = self.recentring * optimum, float(np.sqrt(self.recentring)) * optimum
            smallest = solve(_trace(problem), problem.at(inner, 1.0, STRICT)).x
            if (
                k == PASSES or abs(optimum - 1.0) <= SETTLED
            ):  # the level is the optimum of the pass before
                break
            if np.all(np.isfinite(smallest)):
                self.t = self.t @ balancing(*_mean(problem, *problem.blocks(smallest, inner)))
            self.level *= optimum
        for x in (_widest(problem, inner, smallest), smallest):
            if np.all(np.isfinite(x)) and np.all(
                problem.margins(*problem.blocks(x, inner), gamma) > 0.0
            ):
                return *problem.blocks(x, inner), optimum
        raise NoSolutionError(
            f"the matrix inequalities do not hold where the solver stopped (gamma {gamma * self.level:.4g}); "
            "raise `recentring` or relax the weights"
        )

    def failing(self, x: Matrix, y: Matrix, gamma: float, points: Sequence[Values]) -> list[Values]:
        """The points at which the inequalities do not hold, the worst first."""
        margins = self.inequalities(points).margins(x, y, gamma)
        return [points[k] for k in np.argsort(margins) if not margins[k] > 0.0]


def _optimum(problem: GridInequalities) -> float:
    found = solve(-np.eye(problem.unknowns + 2)[-2], problem.free())
    inverse = float(found.x[-2])
    if (
        not np.all(np.isfinite(found.x))
        or inverse <= SMALLEST_INVERSE
        or found.status in INFEASIBLE
    ):
        raise NoSolutionError(NO_GAMMA)
    return 1.0 / inverse


def _mean(problem: GridInequalities, x: Matrix, y: Matrix) -> tuple[Matrix, Matrix]:
    """X and Y averaged over the grid."""
    weights = [
        np.mean([basis.at(cell.values) for cell in problem.cells], axis=0)
        for basis in problem.bases
    ]
    return np.tensordot(weights[0], x, 1), np.tensordot(weights[1], y, 1)


def _trace(problem: GridInequalities) -> Vector:
    """Of the mean of X and Y over the grid, as an objective."""
    unit = np.eye(problem.n)[upper_triangle(problem.n)]
    weights = [
        np.mean([basis.at(cell.values) for cell in problem.cells], axis=0)
        for basis in problem.bases
    ]
    return np.concatenate([np.kron(weights[0], unit), np.kron(weights[1], unit)])


def _widest(problem: GridInequalities, gamma: float, smallest: Vector) -> Vector:
    """The point of the largest b in [X bI; bI Y] > 0, with a mean trace not much above the
    smallest."""
    trace = np.append(_trace(problem), 0.0)
    limit = AffineConstraint(
        np.full((1, 1), TRACE_SLACK * float(trace[:-1] @ smallest)), -trace[None]
    )
    return solve(-np.eye(problem.unknowns + 1)[-1], [*problem.at(gamma, None, STRICT), limit]).x
