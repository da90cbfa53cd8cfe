"""Method `lpv_grid`: Lyapunov matrices X and Y as polynomials of the scheduled parameters.

The inequalities of thesis (5.62) are solved on a grid of parameters, and also checked between the
grid points. Method `lpv` has one X and one Y, and is therefore valid for parameters that jump.
Method `lpv_grid` assumes constant or slowly varying parameters and reaches a lower gamma. All
plants on the grid are exact; no plant is linearised. If Coulomb friction is scheduled, its largest
value is used everywhere, because the Coulomb friction only scales the friction input of the plant.
The target hardware runs the controller of the plant `frozen_at` in the design (thesis 5.3.4). The
loop with this frozen controller is verified at every vertex.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from frictool.documents.design import Grid
from frictool.errors import FrictoolError, NoSolutionError
from frictool.lmi.grid_inequalities import Values
from frictool.lmi.gridded_controllers import certified_gamma, scheduled_controllers
from frictool.lmi.gridded_synthesis import Family, GriddedSolution, GridSchedule, minimise
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.plant.parameter_box import DYNAMIC, Box, enclosing_box, largest_coulomb
from frictool.plant.polytope import PARAMETERS, Parameter, PlantPoint, Polytope
from frictool.synth.lpv import identified_plant
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem, check_claim


def lpv_grid(problem: SynthesisProblem) -> ControllerCandidate:
    """Return the controller of the plant `frozen_at` and, if requested, scheduled controllers.

    Raises NoSolutionError if the inequalities have no solution, or if the norm of the loop exceeds
    the gamma of the inequalities. Raises FrictoolError for options that this method does not
    support (regimes, pole regions, linearised vertices, scheduled sampled controllers).
    """
    design = problem.design
    options = design.grid or Grid()
    _refuse(problem)
    posed = problem.posed_with_constant_input()
    box = enclosing_box(problem.box.vertices)
    wanted = design.schedule or PARAMETERS
    names: tuple[Parameter, ...] = tuple(
        name for name in DYNAMIC if name in wanted and box[name][1] > box[name][0]
    )
    centre = problem.box.centre
    coulomb = largest_coulomb(box) if "coulomb" in wanted else centre.coulomb

    def plant(point: PlantPoint) -> GeneralisedPlant:
        return posed.plant(
            PlantPoint(point.name, point.inertia, point.viscous, coulomb, point.constant).rates
        )

    def family(values: Values) -> list[GeneralisedPlant]:
        return [plant(_at(box, centre, names, values))]

    speed = 2.0 * options.speed_per_s * (problem.period if problem.sampled else 1.0)
    schedule = GridSchedule(
        (speed,) * len(names),
        (0 if design.scheduled else options.degree, options.degree),
        options.points,
    )
    solution = minimise(family, schedule, design.recentring)
    frozen = centre if design.frozen_at == "centre" else identified_plant(problem)
    values = _values(box, frozen, names)
    frozen_plant = plant(_at(box, frozen, names, values))
    note = _note(solution, names, options)
    where = f"the {design.frozen_at} plant"
    if not design.scheduled:
        k = solution.frozen(frozen_plant, values)
        check_claim(k, frozen_plant, solution.gamma, where)
        return problem.candidate(k, solution.gamma, solution.optimum, [note])
    ends = list(product((-1.0, 1.0), repeat=len(names)))
    k, *corners = scheduled_controllers(
        solution, [values, *ends], [frozen_plant, *(family(end)[0] for end in ends)]
    )
    check_claim(k, frozen_plant, solution.gamma, where)
    points = [
        replace(_at(box, centre, names, end), name=f"v{index}", coulomb=coulomb)
        for index, end in enumerate(ends, start=1)
    ]
    over = Polytope(centre, tuple(points), names)
    return problem.candidate(
        k,
        solution.gamma,
        solution.optimum,
        [note, _sums(solution, family, corners, ends)],
        corners,
        over,
    )


def _sums(
    solution: GriddedSolution, family: Family, corners: Sequence[Lti], ends: Sequence[Values]
) -> str:
    worst = 0.0
    for values in solution.points:
        shares = [
            np.prod([0.5 * (1.0 + e * v) for e, v in zip(end, values, strict=True)]) for end in ends
        ]
        a, b, c, d = (
            np.tensordot(shares, [getattr(k, part) for k in corners], 1) for part in "abcd"
        )
        worst = max(
            worst, certified_gamma(solution, values, family(values)[0], Lti(a, b, c, d, 0.0))
        )
    if np.isinf(worst):
        return (
            "interpolated controllers have no bound at some points of the grid; they are verified "
            "for constant plants only"
        )
    return (
        f"interpolated controllers keep gamma {worst:.4g} at the grid points for moving parameters"
    )


def _refuse(problem: SynthesisProblem) -> None:
    design = problem.design
    if design.scheduled and problem.sampled:
        raise FrictoolError(
            "method lpv_grid: found `scheduled: true` with domain discrete; allowed: domain "
            "continuous, or `scheduled: false`"
        ).at("design", "method")
    if design.schedule is not None and "regime" in design.schedule:
        raise FrictoolError(
            "method lpv_grid: found schedule regime; allowed: inertia, viscous, coulomb, "
            "constant; for regimes, write method lpv or lft_lpv"
        ).at("design", "schedule")
    if design.poles is not None:
        raise FrictoolError(
            "method lpv_grid: supports no pole region; remove `poles` and raise weights.command, "
            "or use method lpv"
        ).at("design", "poles")
    if design.vertices != "exact":
        raise FrictoolError(
            f"method lpv_grid: found vertices {design.vertices}; allowed: exact, because the grid "
            "needs no linearisation"
        ).at("design", "vertices")


def _at(box: Box, others: PlantPoint, names: tuple[str, ...], values: Values) -> PlantPoint:
    """Return the plant `others`, with its scheduled parameters set from the normalised `values`.

    -1 and 1 stand for the ends of a parameter's interval in `box`.
    """
    levels = {name: getattr(others, name) for name in DYNAMIC}
    for name, value in zip(names, values, strict=True):
        low, high = box[name]
        levels[name] = 0.5 * (low + high) + 0.5 * value * (high - low)
    return PlantPoint(
        "grid", levels["inertia"], levels["viscous"], others.coulomb, levels["constant"]
    )


def _values(box: Box, point: PlantPoint, names: tuple[str, ...]) -> Values:
    """Return a plant's scheduled parameters, normalised to -1 to 1 over their intervals.

    Raises NoSolutionError if a parameter is outside its interval.
    """
    scaled = tuple(
        (2.0 * getattr(point, name) - sum(box[name])) / (box[name][1] - box[name][0])
        for name in names
    )
    if np.any(np.abs(scaled) > 1.0 + 1e-9):
        raise NoSolutionError(
            f"the plant {point.name} of `frozen_at` is outside the scheduled intervals; write "
            "`frozen_at: centre`, or widen the intervals"
        )
    return scaled


def _note(solution: GriddedSolution, names: tuple[str, ...], options: Grid) -> str:
    moving = (
        f"which move by up to {options.speed_per_s:g} of their intervals per s"
        if options.speed_per_s
        else "which are constant"
    )
    return (
        f"grid over {', '.join(names) or 'no parameters'}, {moving}; X and Y of degree "
        f"{options.degree}: inequalities solved at {len(solution.points)} points, checked at "
        f"{solution.checked}, not proved between them"
    )
