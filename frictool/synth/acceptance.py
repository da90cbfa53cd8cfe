"""A candidate becomes a controller only here: the loop rebuilt in physical units from the coefficients as they are stored, sampled at the
bench's period with its delay, at every vertex, and again with the coefficients rounded. Nothing that the method says is believed."""

from __future__ import annotations

import itertools
import math

import numpy as np

from frictool.documents import controller as stored
from frictool.errors import NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.synth.blocks import Blocks
from frictool.synth.problem import CLAIM, Candidate, Problem
from frictool.ties import largest, smallest
from frictool.verify.controller import check_feedback, limiter_brake, loop_checks
from frictool.verify.count_current import count_current
from frictool.verify.effective import Feedback, feedbacks, friction_to_speed, from_position, open_loop, running
from frictool.verify.margins import loop_margins
from frictool.verify.norms import norm
from frictool.verify.resonant_loop import ResonantCheck, require, resonant_check
from frictool.verify.rounding import Held, held, rounded_linear
from frictool.verify.speed_loop import performance
from frictool.verify.stored_forms import limited_radius
from frictool.verify.words import delay_words, plant_words

COUNT_LIMIT = 4.0  # times the drive's limit that one encoder count may ask for; beyond, the loop is a switch
HELD: tuple[stored.Number, ...] = ("double", "float")  # every controller is verified with
OFFERED: tuple[stored.Number, ...] = ("q31", "q15")  # told where the loop stands them; export refuses them elsewhere


def accept(problem: Problem, candidate: Candidate, linear: stored.LinearController, around: Blocks) -> stored.Verified:
    """What was verified of the loops that `linear` closes with the blocks around it.

    Raises NoSolutionError (exit 4) naming the vertex and its figure where a loop is unstable with 0 samples of delay, 1 or the bench's,
    or misses the specified modulus margin at the bench's, also with rounded coefficients; or where one count asks for too much drive.
    """
    loops = _loops(problem, linear, around)
    required = problem.spec.modulus_margin or 0.0
    vertices = tuple(_vertex(problem, linear, loops, candidate, point) for point in problem.box.vertices)
    for vertex in vertices:
        if not vertex.stable:
            worst = vertex.checks[largest(check.spectral_radius for check in vertex.checks)[1]]
            raise NoSolutionError(
                f"not verified: the sampled loop is unstable at vertex {_where(vertex, problem)} with {delay_words(worst.delay_samples)} "
                f"(spectral radius {worst.spectral_radius:.4f}); {problem.hint}"
            )
    margin, at = smallest(vertex.modulus_margin for vertex in vertices)
    if margin < required:
        raise NoSolutionError(
            f"not verified: modulus margin {margin:.4f} < {required:g} at vertex {_where(vertices[at], problem)} "
            f"with {delay_words(problem.delay)}; {problem.hint}"
        )
    _brake(problem, around)
    resonant(problem, loops)
    worst_norm = max(vertex.sampled_norm for vertex in vertices)
    rounded = [_rounded(problem, linear, around, number) for number in (*HELD, *OFFERED)]
    for one in rounded[: len(HELD)]:
        if not _stands(one, worst_norm, required):
            raise NoSolutionError(
                f"not verified: with coefficients rounded to {one.number} the worst norm is {one.gamma:.4g} where {worst_norm:.4g} is "
                f"claimed, the modulus margin {one.modulus_margin:.3f} where {required:g} is specified; bring the weights nearer to each "
                "other"
            )
    return stored.Verified(
        candidate.gamma,
        worst_norm,
        required,
        vertices,
        count_drive=_count(problem, loops),
        rounded=tuple(one for one in rounded if _stands(one, worst_norm, required)),
        margins=_margins(problem, loops),
    )


def resonant(problem: Problem, loops: tuple[Feedback, ...]) -> ResonantCheck | None:
    """The loops with the model's resonances, at the bench's delay the worst margin; None where it has none.

    Raises NoSolutionError where one of them is unstable, or misses the specified margin.
    """
    resonances = problem.model.resonances
    if resonances is None:
        return None
    required, found = problem.spec.modulus_margin or 0.0, None
    for samples in _delays(problem):
        now = resonant_check(loops, problem.box.vertices, problem.lag, samples, resonances)
        require(now, resonances, required if samples == problem.delay else 0.0)
        found = now if samples == problem.delay else found
    return found


def _loops(problem: Problem, linear: stored.LinearController, around: Blocks, hold: Held = float) -> tuple[Feedback, ...]:
    return feedbacks(problem.design.structure, linear, around.position_law, around.velocity, problem.period, hold)


def _vertex(
    problem: Problem, linear: stored.LinearController, loops: tuple[Feedback, ...], candidate: Candidate, point: PlantPoint
) -> stored.Vertex:
    delays = _delays(problem)
    checks = loop_checks(loops, point, problem.lag, tuple(delays))
    margin = checks[delays.index(problem.delay)].modulus_margin
    sampled_norm = _norm(problem, linear, point, margin)
    return stored.Vertex(
        name=point.name,
        inertia=point.inertia,
        viscous=point.viscous,
        coulomb=point.coulomb,
        constant=point.constant,
        norm=sampled_norm if problem.sampled else performance(candidate.designed, problem.plant(point.rates)),
        sampled_norm=sampled_norm,
        modulus_margin=margin,
        stable=all(check.spectral_radius < 1.0 for check in checks) and math.isfinite(sampled_norm),
        checks=checks,
    )


def _delays(problem: Problem) -> list[int]:
    return sorted({0, 1, problem.delay})


def _norm(problem: Problem, linear: stored.LinearController, point: PlantPoint, margin: float) -> float:
    """Of the weighted loop, or of the sensitivity where nothing is weighed."""
    if problem.weighs:
        return performance(running(linear, problem.period), problem.running(point.rates))
    return 1.0 / margin if margin > 0.0 else math.inf


def _brake(problem: Problem, around: Blocks) -> None:
    """Raises NoSolutionError where the virtual friction of a limiter would not come to rest."""
    brake = limiter_brake(around.limiter, around.velocity, problem.model.bench.actuator.constant.value, problem.period)
    for one, point, samples in itertools.product(brake, problem.box.vertices, _delays(problem)):
        found = check_feedback(one, point.rates, problem.lag, samples)
        if not found.stable:
            raise NoSolutionError(
                f"not verified: the limiter's virtual friction is unstable at rest, at vertex {point.name} with {samples} samples of "
                f"delay (spectral radius {found.spectral_radius:.4f}); raise limiter.virtual_speed, or velocity.filter_rad_s"
            )


def _count(problem: Problem, loops: tuple[Feedback, ...]) -> float:
    actuator, encoder = problem.model.bench.actuator, problem.model.bench.encoder
    asked = max(count_current(from_position(loop), encoder.resolution) for loop in loops)
    if asked > COUNT_LIMIT * actuator.limit.value:
        unit = "A" if actuator.drive == "current" else "V"
        raise NoSolutionError(
            f"not verified: one encoder count asks for {asked:.4g} {unit}, more than {COUNT_LIMIT:g} times the limit of "
            f"{actuator.limit.value:g} {unit}; {problem.softer}"
        )
    return asked


def _rounded(problem: Problem, linear: stored.LinearController, around: Blocks, number: stored.Number) -> stored.Rounded:
    """The worst figures with the coefficients as the format holds them; an anti-windup that it makes unstable counts as no margin."""
    holding, points = rounded_linear(linear, number), problem.box.vertices
    if limited_radius(holding, problem.period) >= 1.0:
        return stored.Rounded(number, math.inf, 0.0)
    loops = _loops(problem, holding, around, held(number))
    margins = [loop_checks(loops, point, problem.lag, (problem.delay,))[0].modulus_margin for point in points]
    gamma = max(_norm(problem, holding, point, margin) for point, margin in zip(points, margins, strict=True))
    return stored.Rounded(number, gamma, min(margins))


def _stands(rounded: stored.Rounded, claimed: float, required: float) -> bool:
    return rounded.gamma <= CLAIM * claimed and rounded.modulus_margin >= required and math.isfinite(rounded.gamma)


def _margins(problem: Problem, loops: tuple[Feedback, ...]) -> stored.Margins:
    points = problem.box.vertices
    found = [loop_margins(open_loop(loop, point.rates, problem.lag, problem.delay)) for loop in loops for point in points]
    friction = max(norm(friction_to_speed(loops[-1], point.rates, problem.lag, problem.delay))[0] for point in points)
    return stored.Margins(
        gain_increase=_finite(min(one.gain_up for one in found)),
        gain_decrease=max(one.gain_down for one in found) or None,
        phase_deg=float(np.degrees(min(one.phase for one in found))),
        delay_s=_finite(min(one.delay for one in found)),
        small_gain=friction,
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _where(vertex: stored.Vertex, problem: Problem) -> str:
    return f"{vertex.name} ({plant_words(vertex, problem.model.bench)})"
