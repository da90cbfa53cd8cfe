"""H-infinity synthesis over a polytope with one Lyapunov matrix (thesis 5.3.1), by elimination.

    minimise              computes the smallest gamma that is possible for all plants together, and
                          matrices R and S that all plants share (X and Y in (5.61))
    controller            computes the central controller of one plant, with these R and S
    vertex_controllers    computes one controller per vertex, all in the same state coordinates;
                          the inequalities guarantee gamma for each barycentric sum (5.64)

The plants are in continuous or discrete time. The solver's result is reliable only for a
well-conditioned problem, even if the solver reports success. Therefore the problem is solved
several times. Each solution changes the coordinates and the scale of the next problem, so that R
and S become nearly equal and diagonal, and gamma nearly one. Then two more problems are solved at
a gamma slightly above the optimum. The first minimises trace(R + S). The second limits this trace
to TRACE_SLACK times its minimum and maximises b subject to [R bI; bI S] >= 0. [R I; I S] is then
far from singular, which avoids very large coefficients of the controller.

For one plant, two Riccati equations give gamma, R and S (riccati_synthesis.py). If they do not
apply, or do not give usable R and S, the solver is used.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.errors import NoSolutionError
from frictool.lmi.bounded_real import BoundedRealInequalities
from frictool.lmi.parrott_reconstruction import central
from frictool.lmi.pole_regions import (
    PoleDisc,
    PoleHalfPlane,
    PoleRegion,
    TransformVariable,
    frame,
    refuse_fixed_modes,
)
from frictool.lmi.riccati_synthesis import lyapunov_blocks, smallest_gamma
from frictool.lmi.sdp import AffineConstraint, solve, upper_triangle
from frictool.lmi.state_balancing import balancing, even_out
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.typing import Matrix, Vector

__all__ = [
    "LyapunovPair",
    "PoleDisc",
    "PoleHalfPlane",
    "controller",
    "minimise",
    "vertex_controllers",
]

PASSES = 8  # largest number of balancing passes
DIVERGED = 1e3  # ratio of gamma to the last pass's gamma above which the problem diverges
SETTLED = 1e-3  # relative change of gamma below which the passes end, if the inequalities hold
INFEASIBLE = frozenset(
    {"PrimalInfeasible", "DualInfeasible", "AlmostPrimalInfeasible", "AlmostDualInfeasible"}
)
SMALLEST_INVERSE = 1e-8  # 1/gamma that counts as zero, given the solver's precision
NO_GAMMA = (
    "no finite gamma: no controllers satisfy the matrix inequalities of all plants with one "
    "Lyapunov matrix, to working precision; "
    "narrow the intervals or relax the weights"
)
RELAX = "reduce the ratio of the largest to the smallest weight, or relax the weights"
# margin of the inequalities for gamma near one, larger than the solver's own tolerance
STRICT = 1e-6
# tried weights on every state, which make Riccati solutions strict; the largest usable one is kept
STATE_WEIGHTS = (3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
TRACE_SLACK = 1.5  # limit of trace(R + S) in the recentring, relative to its minimum


@dataclass(frozen=True)
class LyapunovPair:
    """Lyapunov blocks R and S in the state coordinates x = t x_balanced.

    R and S solve the inequalities at `gamma` for the plants in the complex variable p that `frame`
    defines. Without a pole region, R and S also solve the inequalities of the plants in s or z.
    `optimum` is the smallest gamma.
    """

    r: Matrix
    s: Matrix
    t: Matrix
    optimum: float
    gamma: float
    frame: TransformVariable


def minimise(
    plants: Sequence[GeneralisedPlant], recentring: float, pole_region: PoleRegion | None = None
) -> LyapunovPair:
    """Return R and S that solve the inequalities at `recentring` times the smallest gamma.

    The plants are all continuous or all sampled. Raises NoSolutionError if feedback cannot move a
    pole into the region of stability (or the `pole_region`), if the inequalities are infeasible, or
    if the solver's result violates them. Raises ValueError if B2, C2, D12 or D21 differ between the
    plants.
    """
    try:
        return _minimise(plants, recentring, pole_region)
    except np.linalg.LinAlgError as error:
        raise NoSolutionError(f"the synthesis broke down numerically ({error}); {RELAX}") from None


def _minimise(
    plants: Sequence[GeneralisedPlant], recentring: float, pole_region: PoleRegion | None
) -> LyapunovPair:
    chosen = frame(plants, pole_region)
    framed = [chosen.plant(plant) for plant in plants]
    t = even_out(framed)
    level = 1.0
    before = np.nan
    refuse_fixed_modes([plant.transformed(t) for plant in framed], chosen)
    if len(framed) == 1 and (found := _by_riccati(framed[0], t, recentring, chosen)) is not None:
        return found
    for _ in range(PASSES + 1):
        problem = BoundedRealInequalities(
            [scale_level(plant, level).transformed(t) for plant in framed]
        )
        optimum, r, s = _optimum(problem)
        if optimum * level > DIVERGED * before:
            raise NoSolutionError(NO_GAMMA)
        gamma = recentring * optimum
        inner = np.sqrt(recentring) * optimum
        smallest = _smallest(problem, inner)
        if abs(optimum * level - before) <= SETTLED * before:
            for x in (_widest(problem, inner, smallest), smallest):
                if problem.hold(*problem.blocks(x, inner), gamma):
                    return LyapunovPair(
                        *problem.blocks(x, inner), t, optimum * level, gamma * level, chosen
                    )
        level = before = optimum * level
        t = t @ _next(problem.blocks(smallest, inner), (r, s))
    raise NoSolutionError(
        "the solver's result violates the matrix inequalities (gamma "
        f"{recentring * before:.4g}); "
        "raise `recentring` or relax the weights"
    )


def _by_riccati(
    plant: GeneralisedPlant, t: Matrix, recentring: float, chosen: TransformVariable
) -> LyapunovPair | None:
    """Return R and S of one plant, in the variable `chosen`, by Riccati equations.

    The result is None if the equations do not apply, if R and S violate the inequalities, or if
    R and S admit no controller. t: first balancing of the plant's states.
    """
    optimum = smallest_gamma(plant.transformed(t))
    if optimum is None:
        return None
    scaled = scale_level(plant, optimum)
    start = lyapunov_blocks(scaled.transformed(t), np.sqrt(recentring), STATE_WEIGHTS[-1])
    if start is None:
        return None
    t = t @ balancing(*start)
    balanced = scaled.transformed(t)
    inequalities = BoundedRealInequalities([balanced])
    for weight in STATE_WEIGHTS:
        blocks = lyapunov_blocks(balanced, np.sqrt(recentring), weight)
        if blocks is None or not inequalities.hold(*blocks, recentring):
            continue
        with contextlib.suppress(NoSolutionError):
            central(balanced, *blocks, recentring)
            return LyapunovPair(*blocks, t, optimum, recentring * optimum, chosen)
    return None


def controller(plant: GeneralisedPlant, lyapunov: LyapunovPair, ease: float = 1.0) -> Lti:
    """Return the central controller of one plant; its loop has a norm of at most `lyapunov.gamma`.

    With `ease` > 1 the result is the central controller for the larger norm `ease` times
    `lyapunov.gamma`. This controller is slower, and the inequalities guarantee only the larger
    norm. The norm of the loop is often still below `lyapunov.gamma`, but this must be verified.
    Raises NoSolutionError if (R, S) do not admit a controller to working precision, ValueError if
    `ease` is below 1.
    """
    if not ease >= 1.0:
        raise ValueError(f"ease, a factor on gamma, is {ease:g}; allowed: 1 or more")
    framed = lyapunov.frame.plant(plant).transformed(lyapunov.t)
    try:
        central_controller = central(framed, lyapunov.r, lyapunov.s, ease * lyapunov.gamma)
    except np.linalg.LinAlgError as error:
        raise NoSolutionError(
            f"the controller's reconstruction broke down numerically ({error}); {RELAX}"
        ) from None
    return lyapunov.frame.back(central_controller, plant.period)


def vertex_controllers(
    plants: Sequence[GeneralisedPlant], lyapunov: LyapunovPair, ease: float = 1.0
) -> tuple[Lti, ...]:
    """Return a controller for each plant, all in the same state coordinates.

    A convex combination of the controllers stabilises the convex combination of the plants with the
    same weights. The norm of this loop is at most `ease` times gamma (thesis 5.46, 5.64).
    """
    return tuple(controller(plant, lyapunov, ease) for plant in plants)


def scale_level(plant: GeneralisedPlant, level: float) -> GeneralisedPlant:
    """Return `plant` scaled so that its closed-loop norm is divided by `level`.

    R and S that solve the inequalities of `plant` also solve the scaled inequalities.
    """
    root = np.sqrt(level)
    return replace(
        plant,
        b1=plant.b1 / root,
        c1=plant.c1 / root,
        d11=plant.d11 / level,
        d12=plant.d12 / root,
        d21=plant.d21 / root,
    )


def _optimum(problem: BoundedRealInequalities) -> tuple[float, Matrix, Matrix]:
    objective = np.zeros(2 * problem.half + 2)
    objective[-2] = -1.0
    solution = solve(objective, problem.free())
    inverse = float(solution.x[-2])
    if (
        not np.all(np.isfinite(solution.x))
        or inverse <= SMALLEST_INVERSE
        or solution.status in INFEASIBLE
    ):
        raise NoSolutionError(NO_GAMMA)
    return 1.0 / inverse, *problem.blocks(solution.x, 1.0 / inverse)


def _next(*pairs: tuple[Matrix, Matrix]) -> Matrix:
    for r, s in pairs:
        if (
            np.all(np.isfinite(r))
            and np.all(np.isfinite(s))
            and min(np.linalg.eigvalsh(r)[-1], np.linalg.eigvalsh(s)[-1]) > 0.0
        ):
            return balancing(r, s)
    raise NoSolutionError(NO_GAMMA)


def _trace(problem: BoundedRealInequalities) -> Vector:
    return np.concatenate([np.eye(problem.n)[upper_triangle(problem.n)]] * 2)


def _smallest(problem: BoundedRealInequalities, gamma: float) -> Vector:
    return solve(_trace(problem), problem.at(gamma, 1.0 + STRICT, STRICT)).x


def _widest(problem: BoundedRealInequalities, gamma: float, smallest: Vector) -> Vector:
    """Return the decision vector with the largest b in [R bI; bI S] >= 0.

    trace(R + S) is at most TRACE_SLACK times its minimum.
    """
    trace = np.append(_trace(problem), 0.0)
    limit = AffineConstraint(
        np.full((1, 1), TRACE_SLACK * float(trace[:-1] @ smallest)), -trace[None]
    )
    push = np.zeros(len(trace))
    push[-1] = -1.0
    return solve(push, [*problem.at(gamma, None, STRICT), limit]).x
