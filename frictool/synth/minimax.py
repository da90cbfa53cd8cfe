"""Method `minimax`: the constant controller of fixed order with the smallest worst norm.

The inequalities of theorem 5.3.1 of the thesis bound the norm with a scheduled controller, but not
with a constant controller (thesis 5.3.4). This method varies the parameters of one constant
controller (structured_controller.py), and minimises the largest norm of all vertices directly.

The problem is not convex. The search draws random controllers of the least order that can stabilise
all vertices, and improves these controllers. The search then adds a pole and an equal zero to the
best two controllers and improves the result, until the requested order is reached. The added pole
and zero cancel, so that the norm does not rise with the order. At each order, new random
controllers are improved, too. The result is an upper bound of the optimum.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.presentation.tie_rule import largest
from frictool.synth.minimax_descent import DescentPoint, MinimaxDescent
from frictool.synth.structured_controller import StructuredController
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem
from frictool.synth.worst_norm import OpenLoopResponses, true_norms
from frictool.typing import Vector

Progress = Callable[[str], None]

ORDER = {"position": 4, "speed": 3}  # order if the design does not state one
DRAWN = 300  # number of random controllers drawn
STARTS = 8  # number of the best drawn controllers, which are improved
KEPT = 2  # number of controllers that get a further pole
PLACES = 4  # number of frequencies tried for each further pole
ROUNDS, LAST_ROUNDS = 25, 60  # rounds of each descent, and of the last one
LEVEL = 0.01  # relative difference of norms below which vertices are treated as equally bad
CLEAR = 1.001  # factor on the specified modulus margin, a reserve for rounded coefficients


def minimax(problem: SynthesisProblem, seed: int = 0) -> ControllerCandidate:
    """Return the best controller of several descents; the same seed gives the same controller.

    Raises NoSolutionError if no controller stabilises every vertex, or if the best controller has
    less than the specified margin.
    """
    design = problem.design
    period = problem.period if problem.sampled else 0.0
    bound = design.pole_bound_rad_s or 2.0 / problem.period
    order = design.order or ORDER[problem.controlled]
    around = _bandwidth(problem, bound)
    plants = [problem.plant(point.rates) for point in problem.box.vertices]
    typical = abs(OpenLoopResponses.of(plants[0], np.array([around])).p22[0])
    # Without a weight on the command, the structure must limit the gain at high frequencies.
    structure = StructuredController(
        order, design.integrator, not problem.weights.command, bound, around, 1.0 / typical, period
    )
    best = search(
        structure, plants, CLEAR * (problem.spec.modulus_margin or 0.0), seed, problem.progress
    )
    names = [point.name for point in problem.box.vertices]
    return _candidate(problem, structure, best, plants, names)


def _bandwidth(problem: SynthesisProblem, bound: float) -> float:
    """Return the expected crossover [rad/s]: twice the zero of W2, limited by the pole bound."""
    zero = problem.weights.error.zero
    return float(min(2.0 * zero if np.isfinite(zero) else np.inf, 0.2 * bound))


def _candidate(
    problem: SynthesisProblem,
    structure: StructuredController,
    best: DescentPoint,
    plants: Sequence[GeneralisedPlant],
    names: Sequence[str],
) -> ControllerCandidate:
    designed = structure.system(best.parameters)
    norms = [value for value, _ in true_norms(designed, plants)]
    level = sum(value > (1.0 - LEVEL) * best.worst for value in norms)
    worst = names[largest(norms, LEVEL)[1]]
    note = (
        f"minimax of order {structure.order}: worst norm {best.worst:.4g} at {worst}, {level} of "
        f"{len(norms)} vertices within "
        f"{100.0 * LEVEL:g} % of it; the best of several descents, not necessarily the optimum"
    )
    return ControllerCandidate(
        problem.discretised(designed), designed, best.worst, best.worst, (note,)
    )


def search(
    structure: StructuredController,
    plants: Sequence[GeneralisedPlant],
    margin: float,
    seed: int = 0,
    progress: Progress = lambda _: None,
) -> DescentPoint:
    """Return the controller parameters that minimise the largest norm of all plants.

    Every loop must have a modulus margin of at least `margin`. All `plants` must have the same
    order. Raises NoSolutionError if no controller stabilises every
    plant, or if the best controller has a smaller margin.
    """
    random = np.random.default_rng(seed)
    least = min(structure.order, 1 + structure.integrator + structure.rolls_off)
    now = replace(structure, order=least)
    descent = MinimaxDescent(now, plants, 1e-3 * structure.around, margin)
    points = _best([descent.run(start, ROUNDS) for start in _starts(descent, random)])
    while True:
        if not points:
            raise NoSolutionError(
                f"minimax: no controller of order {now.order} with poles below {now.bound:.4g} "
                "rad/s stabilises every vertex; raise order, change pole_bound_rad_s, or narrow "
                "the model's intervals"
            )
        progress(f"minimax: order {now.order}, worst norm {points[0].worst:.4f}")
        if now.order == structure.order:
            break
        places = structure.bound * np.exp(
            random.uniform(
                np.log(0.1 * structure.around / structure.bound), 0.0, (len(points), PLACES)
            )
        )
        grown = [
            now.grown(point.parameters, float(place))
            for point, row in zip(points, places, strict=True)
            for place in row
        ]
        now = now.wider()
        descent = descent.on(now)
        points = _best(
            [
                *(descent.run(start, ROUNDS) for start in grown),
                *(descent.run(start, ROUNDS) for start in _starts(descent, random)[:2]),
            ]
        )
    best = descent.run(points[0].parameters, LAST_ROUNDS)
    if best.missed > 1e-4:
        raise NoSolutionError(
            f"minimax: the best controller of order {structure.order} has a modulus margin of "
            f"{margin / (1.0 + best.missed):.3f} < "
            f"{margin:g}; raise order, change pole_bound_rad_s, or lower weights.bandwidth_rad_s"
        )
    return best


def _best(points: Sequence[DescentPoint]) -> list[DescentPoint]:
    stable = sorted(
        (point for point in points if np.isfinite(point.worst)),
        key=lambda point: (round(point.missed, 4), point.worst),
    )
    chosen: list[DescentPoint] = []
    for point in stable:
        if all(abs(point.worst - other.worst) > 1e-4 * other.worst for other in chosen):
            chosen.append(point)
    return chosen[:KEPT]


def _starts(descent: MinimaxDescent, random: np.random.Generator) -> list[Vector]:
    drawn = [_drawn(descent.structure, descent.plants[0], random) for _ in range(DRAWN)]
    ranked = sorted(
        ((descent.coarse(parameters), index) for index, parameters in enumerate(drawn)),
        key=lambda pair: pair[0],
    )
    return [drawn[index] for value, index in ranked[:STARTS] if np.isfinite(value)]


def _drawn(
    structure: StructuredController, plant: GeneralisedPlant, random: np.random.Generator
) -> Vector:
    """Draw a random controller whose loop crosses over near the expected frequency.

    The poles lie in the upper part of their region, the zeros near a third of the crossover
    frequency.
    """
    low, high = structure.limits()
    crossing = structure.around * np.exp(random.uniform(-1.0, 1.0))
    parameters = np.empty(structure.size)
    for j in range(structure.free):
        parameters[j] = random.uniform(max(low[j], -3.0), high[j])
    above = np.ones(1)
    for _ in range(structure.numerator - 1):
        above = np.polymul(
            above, [structure.around / (0.33 * crossing * np.exp(random.uniform(-1.5, 1.5))), 1.0]
        )
    parameters[structure.free :] = above[::-1]
    at = np.array([crossing])
    k, _ = structure.response(parameters, structure.points(at))
    parameters[structure.free :] /= abs(k[0] * OpenLoopResponses.of(plant, at).p22[0])
    return parameters
