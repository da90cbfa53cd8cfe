"""H-infinity synthesis with parameter-dependent Lyapunov matrices on a refined grid.

The Lyapunov matrices X(r) and Y(r) of thesis (5.62) are constant, affine or quadratic in the
scheduled parameters r. Each r_j is in [-1, 1] and varies at a bounded rate
(lmi/grid_inequalities.py). If the rates are unbounded and X and Y constant, this is theorem 5.3.1
of the thesis; if the grid has a single point, the problem is LTI.

A grid proves nothing between its points. After each solution the inequalities are evaluated on a
finer grid with an offset, and the points at which the inequalities fail join the grid. The finer
grid gives evidence, not a proof for every r. The controller at each r is therefore verified by the
norms of its closed loops. A grid point may have several plants (vertices of parameters on which X
and Y do not depend). The inequalities then hold for every plant in the convex hull of these plants.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

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
from frictool.typing import Matrix, Vector

# scheduled values -> plants at these values
Family = Callable[[Values], Sequence[GeneralisedPlant]]
PASSES = 6  # largest number of balancing passes
ROUNDS = 12  # largest number of grid refinements
JOINING = 4  # largest number of failing points that join the grid in each refinement
# intervals of the finer grid per interval of the first grid, for 0, 1, 2, and 3 or more parameters
FINER = (1, 16, 8, 4)
# the finer grid is evaluated at gamma = (smallest gamma) recentring^INSIDE, which leaves a reserve
# between the points
INSIDE = 0.75


@dataclass(frozen=True)
class GridSchedule:
    """Dependence of the Lyapunov matrices X and Y on the scheduled parameters r_j.

    - rates: bound of |dr_j/dt| for each parameter, in 1/s (for sampled plants, per sample). X and Y
      do not depend on a parameter whose rate is unbounded (inf).
    - degrees: degrees of X and Y, 0 to 2
    - points: number of points of the first grid along each parameter
    """

    rates: tuple[float, ...]
    degrees: tuple[int, int] = (1, 1)
    points: int = 3


@dataclass(frozen=True)
class GriddedSolution:
    """Solution of the gridded synthesis: coefficients x of X(r) and y of Y(r) in their `bases`.

    X and Y solve the inequalities at `gamma` >= `optimum`, the smallest gamma. X and Y are valid
    for plants in the complex variable p that `frame` defines, and for states equal to t times the
    balanced states.

    - motions: corners of the rates (steps in discrete time) in the unit of time of `frame`
    - points: values of r at the final grid points
    - checked: number of points at which the inequalities were evaluated, including the finer grid
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
        """Return the central controller of `plant` for parameters that are constant at `values`.

        The norm of the closed loop is below gamma. Raises NoSolutionError if X and Y do not admit a
        controller to working precision.
        """
        x, y = (
            np.tensordot(basis.at(values), v, 1)
            for basis, v in zip(self.bases, (self.x, self.y), strict=True)
        )
        try:
            controller = central(self.frame.plant(plant).transformed(self.t), x, y, self.gamma)
        except np.linalg.LinAlgError as error:
            raise NoSolutionError(
                f"the controller's reconstruction broke down numerically ({error}); {RELAX}"
            ) from None
        return self.frame.back(controller, plant.period)


def minimise(family: Family, schedule: GridSchedule, recentring: float) -> GriddedSolution:
    """Return X(r) and Y(r) that solve the inequalities at `recentring` times the smallest gamma.

    The smallest gamma is computed on the grid. X and Y also satisfy the inequalities at the points
    of the finer grid. `family` maps values r_j in [-1, 1] to plants, all continuous or all sampled.
    Raises NoSolutionError if the inequalities are infeasible, if the solver's result violates them,
    or if the inequalities fail between the points after ROUNDS refinements.
    """
    try:
        return _GridSearch(family, schedule, recentring).solution()
    except np.linalg.LinAlgError as error:
        raise NoSolutionError(
            f"the gridded synthesis broke down numerically ({error}); {RELAX}"
        ) from None


class _GridSearch:
    def __init__(self, family: Family, schedule: GridSchedule, recentring: float) -> None:
        self.family = family
        self.recentring = recentring
        parameters = len(schedule.rates)
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
        self.t = even_out(framed)
        self.level = 1.0
        refuse_fixed_modes([plant.transformed(self.t) for plant in framed], self.frame)
        speeds = [
            rate if self.frame.disc else rate * self.frame.scale for rate in schedule.rates
        ]  # rates in the frame's unit of time
        on = tuple(j for j, speed in enumerate(speeds) if np.isfinite(speed))
        self.bases = (
            ParameterBasis(schedule.degrees[0], on),
            ParameterBasis(schedule.degrees[1], on),
        )
        rest = (
            (0.0,) if self.frame.disc and max(schedule.degrees) == 2 else ()
        )  # with quadratic terms, the corners of the steps do not cover a step of 0
        self.motions: list[Values] = list(
            product(*((-s, *rest, s) if np.isfinite(s) and s > 0.0 else (0.0,) for s in speeds))
        )

    def solution(self) -> GriddedSolution:
        for _ in range(ROUNDS):
            x, y, optimum = self.solved()
            gamma = self.recentring * optimum
            failing = self.failing(x, y, self.recentring**INSIDE * optimum, self.finer)
            if not failing:
                checked = len(dict.fromkeys([*self.grid, *self.finer]))
                levels = (optimum * self.level, gamma * self.level)
                return GriddedSolution(
                    x,
                    y,
                    self.bases,
                    tuple(self.motions),
                    self.t,
                    self.frame,
                    *levels,
                    tuple(self.grid),
                    checked,
                )
            self.grid += failing[:JOINING]
        raise NoSolutionError(
            f"the inequalities hold on the grid but fail between its points after {ROUNDS} "
            f"refinements (gamma {gamma * self.level:.4g}); "
            "raise `recentring`, or lower the degree of X and Y or the rates"
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
        for k in range(PASSES + 1):
            problem = self.inequalities(self.grid)
            optimum = _optimum(problem)
            gamma = self.recentring * optimum
            inner = float(np.sqrt(self.recentring)) * optimum
            smallest = solve(_trace(problem), problem.at(inner, 1.0, STRICT)).x
            if (
                k == PASSES or abs(optimum - 1.0) <= SETTLED
            ):  # the level is the optimum of the previous pass
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
            "the solver's result violates the matrix inequalities (gamma "
            f"{gamma * self.level:.4g}); "
            "raise `recentring` or relax the weights"
        )

    def failing(self, x: Matrix, y: Matrix, gamma: float, points: Sequence[Values]) -> list[Values]:
        margins = self.inequalities(points).margins(x, y, gamma)
        return [points[k] for k in np.argsort(margins) if not margins[k] > 0.0]


def _optimum(problem: GridInequalities) -> float:
    solution = solve(-np.eye(problem.unknowns + 2)[-2], problem.free())
    inverse = float(solution.x[-2])
    if (
        not np.all(np.isfinite(solution.x))
        or inverse <= SMALLEST_INVERSE
        or solution.status in INFEASIBLE
    ):
        raise NoSolutionError(NO_GAMMA)
    return 1.0 / inverse


def _mean(problem: GridInequalities, x: Matrix, y: Matrix) -> tuple[Matrix, Matrix]:
    weights = [
        np.mean([basis.at(cell.values) for cell in problem.cells], axis=0)
        for basis in problem.bases
    ]
    return np.tensordot(weights[0], x, 1), np.tensordot(weights[1], y, 1)


def _trace(problem: GridInequalities) -> Vector:
    unit = np.eye(problem.n)[upper_triangle(problem.n)]
    weights = [
        np.mean([basis.at(cell.values) for cell in problem.cells], axis=0)
        for basis in problem.bases
    ]
    return np.concatenate([np.kron(weights[0], unit), np.kron(weights[1], unit)])


def _widest(problem: GridInequalities, gamma: float, smallest: Vector) -> Vector:
    """Return the decision vector with the largest b in [X bI; bI Y] > 0.

    The mean trace of X and Y is at most TRACE_SLACK times its minimum.
    """
    trace = np.append(_trace(problem), 0.0)
    limit = AffineConstraint(
        np.full((1, 1), TRACE_SLACK * float(trace[:-1] @ smallest)), -trace[None]
    )
    return solve(-np.eye(problem.unknowns + 1)[-1], [*problem.at(gamma, None, STRICT), limit]).x
