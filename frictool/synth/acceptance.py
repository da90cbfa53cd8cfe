"""Acceptance test that a controller candidate must pass before its document is written.

At every vertex, the sampled loop is rebuilt in physical units from the stored coefficients, with
the sample period and the delay in bench.yaml. The rounded coefficients are checked in the same
way. Results of the synthesis method, such as a bound of the norm, are not used.
"""

from __future__ import annotations

import itertools

from frictool.documents import controller as stored
from frictool.errors import NoSolutionError
from frictool.presentation.tie_rule import largest, smallest
from frictool.synth.load_disturbance import stiffness_of
from frictool.synth.surrounding_blocks import SurroundingBlocks
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem
from frictool.verify.document_check import check_feedback, limiter_brake
from frictool.verify.feedback_loops import FeedbackLoop
from frictool.verify.loop_values import (
    HELD,
    OFFERED,
    LinearLoops,
    delays_checked,
    tolerates_rounding,
)
from frictool.verify.loop_wording import delay_words, plant_words
from frictool.verify.resonant_loop import ResonantCheck, require_margin, resonant_check
from frictool.verify.speed_loop import is_required
from frictool.verify.spring_loop import SpringCheck, require_spring_margin, spring_check

COUNT_LIMIT = 4.0  # largest drive after one encoder count, in multiples of the drive's limit


def accept(
    problem: SynthesisProblem,
    candidate: ControllerCandidate,
    linear: stored.LinearController,
    around: SurroundingBlocks,
) -> stored.Verified:
    """Test a controller candidate, and return the norms and margins of its loops.

    - linear: stored form of the candidate's linear controller
    - around: blocks around the linear controller

    Raises NoSolutionError if a condition is violated:

    - All loops are stable with the delay in bench.yaml, and with each longer delay that is checked.
      With the delay in bench.yaml, all loops have the specified modulus margin. Both conditions
      also apply to the loops with the model's resonances and spring.
    - With coefficients rounded to double or float, the loops have the specified margin, and the
      norm is at most 1 % larger than without rounding.
    - The loop through the virtual friction of a limit-cycle limiter is stable at rest.
    - One encoder count changes the drive by at most COUNT_LIMIT times the drive's limit.
    """
    loops = linear_loops(problem, linear, around)
    required = problem.spec.modulus_margin or 0.0
    vertices = tuple(loops.vertex(point) for point in loops.points)
    for vertex in vertices:
        if not vertex.stable:
            checks = [
                check for check in vertex.checks if is_required(check.delay_samples, problem.delay)
            ]
            worst = checks[largest(check.spectral_radius for check in checks)[1]]
            raise NoSolutionError(
                f"not verified: the sampled loop is unstable at vertex {_where(vertex, problem)} "
                f"with {delay_words(worst.delay_samples)} "
                f"(spectral radius {worst.spectral_radius:.4f}); {problem.method.more_margin}"
            )
    margin, at = smallest(vertex.modulus_margin for vertex in vertices)
    if margin < required:
        raise NoSolutionError(
            f"not verified: modulus margin {margin:.4f} < {required:g} at vertex "
            f"{_where(vertices[at], problem)} "
            f"with {delay_words(problem.delay)}; {problem.method.more_margin}"
        )
    _brake(problem, around)
    resonant(problem, loops.feedbacks())
    sprung(problem, loops.feedbacks())
    worst_norm = max(vertex.sampled_norm for vertex in vertices)
    rounded = [loops.rounded(number) for number in (*HELD, *OFFERED)]
    for one in rounded[: len(HELD)]:
        if not tolerates_rounding(one, worst_norm, required):
            raise NoSolutionError(
                f"not verified: with {one.number} coefficients, the norm is {one.gamma:.4g} "
                f"instead of {worst_norm:.4g} and the modulus margin {one.modulus_margin:.3f} "
                f"(specified: {required:g}); make the weights more equal"
            )
    return stored.Verified(
        candidate.gamma,
        worst_norm,
        required,
        vertices,
        count_drive=_count(problem, loops),
        rounded=tuple(one for one in rounded if tolerates_rounding(one, worst_norm, required)),
        margins=loops.margins(),
    )


def resonant(problem: SynthesisProblem, loops: tuple[FeedbackLoop, ...]) -> ResonantCheck | None:
    """Return the worst margin of the loops with the model's resonances; None without resonances.

    Raises NoSolutionError if a loop is unstable
    or has less than the specified modulus margin.
    """
    resonances = problem.model.resonances
    if resonances is None:
        return None
    required = problem.spec.modulus_margin or 0.0
    check = None
    for samples in _required(problem):
        now = resonant_check(loops, problem.box.vertices, problem.lag, samples, resonances)
        require_margin(now, resonances, required if samples == problem.delay else 0.0)
        check = now if samples == problem.delay else check
    return check


def sprung(problem: SynthesisProblem, loops: tuple[FeedbackLoop, ...]) -> SpringCheck | None:
    """Return the worst margin of the loops with the model's spring; None without a spring.

    Raises NoSolutionError if a loop is unstable or has less than the specified modulus margin.
    """
    stiffness, resonances = stiffness_of(problem.model), problem.model.resonances
    if stiffness is None:
        return None
    required = problem.spec.modulus_margin or 0.0
    check = None
    for samples in _required(problem):
        axis = problem.lag, samples
        now = spring_check(loops, problem.box.vertices, axis, stiffness, resonances)
        require_spring_margin(now, required if samples == problem.delay else 0.0)
        check = now if samples == problem.delay else check
    return check


def linear_loops(
    problem: SynthesisProblem, linear: stored.LinearController, around: SurroundingBlocks
) -> LinearLoops:
    """Return the loops that `linear` and its surrounding blocks close, for every vertex."""
    return LinearLoops(
        structure=problem.design.structure,
        domain=problem.design.domain,
        linear=linear,
        position_law=around.position_law,
        velocity=around.velocity,
        weights=problem.weights if problem.weighs else None,
        points=problem.box.vertices,
        period=problem.period,
        delay=problem.delay,
        lag=problem.lag,
        count=problem.model.bench.encoder.resolution,
    )


def _brake(problem: SynthesisProblem, around: SurroundingBlocks) -> None:
    brake = limiter_brake(
        around.limiter, around.velocity, problem.model.bench.actuator.constant.value, problem.period
    )
    for one, point, samples in itertools.product(brake, problem.box.vertices, _required(problem)):
        check = check_feedback(one, point.rates, problem.lag, samples)
        if not check.stable:
            raise NoSolutionError(
                "the limiter's virtual friction is unstable at rest, at vertex "
                f"{point.name} with {delay_words(samples)} "
                f"(spectral radius {check.spectral_radius:.4f}); raise limiter.virtual_speed "
                "or velocity.filter_rad_s"
            )


def _required(problem: SynthesisProblem) -> tuple[int, ...]:
    return tuple(one for one in delays_checked(problem.delay) if is_required(one, problem.delay))


def unstable_earlier(vertices: tuple[stored.Vertex, ...], delay: int) -> str:
    """Return a note if a loop is unstable with a delay shorter than `delay`, else "".

    - vertices: results of the check at each vertex
    - delay: delay in bench.yaml [samples]
    """
    found = [
        (check.spectral_radius, check.delay_samples, vertex.name)
        for vertex in vertices
        for check in vertex.checks
        if check.spectral_radius >= 1.0 and not is_required(check.delay_samples, delay)
    ]
    if not found:
        return ""
    radius, samples, name = max(found)
    return (
        f"the loop is unstable with {delay_words(samples)} at vertex {name} (spectral radius "
        f"{radius:.4f}): faster hardware must wait until the bench's delay ({delay_words(delay)}) "
        "has passed"
    )


def _count(problem: SynthesisProblem, loops: LinearLoops) -> float:
    actuator = problem.model.bench.actuator
    requested = loops.count_drive()
    if requested > COUNT_LIMIT * actuator.limit.value:
        unit = "A" if actuator.drive == "current" else "V"
        raise NoSolutionError(
            f"not verified: one encoder count changes the drive by {requested:.4g} {unit}, "
            f"more than {COUNT_LIMIT:g} times the limit of "
            f"{actuator.limit.value:g} {unit}; {problem.method.less_noise}"
        )
    return requested


def _where(vertex: stored.Vertex, problem: SynthesisProblem) -> str:
    return f"{vertex.name} ({plant_words(vertex, problem.model.bench)})"
