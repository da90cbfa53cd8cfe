"""A candidate becomes a controller only here: the loop rebuilt in physical units from the coefficients as they are stored, sampled at the
bench's period with its delay, at every vertex, and again with the coefficients rounded. Nothing that the method says is believed."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from frictool.documents import controller as stored
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.synth.problem import CLAIM, Candidate, Problem
from frictool.verify.controller import loop_checks
from frictool.verify.count_current import count_current
from frictool.verify.margins import margins, rounded, small_gain
from frictool.verify.speed_loop import performance

RELAX = "raise weights.command or weights.noise, or lower weights.bandwidth_rad_s"
COUNT_LIMIT = 4.0  # times the drive's limit that one encoder count may ask for; beyond, the loop is a switch
NUMBERS: tuple[Literal["double", "float"], ...] = ("double", "float")


def accept(problem: Problem, candidate: Candidate, linear: stored.LinearController) -> stored.Verified:
    """What was verified of the loop that `linear` closes.

    Raises NoSolutionError (exit 4) naming the vertex and its figure where the loop is unstable with 0 samples of delay, 1 or the bench's,
    or misses the specified modulus margin at the bench's, also with rounded coefficients; or where one count asks for too much drive.
    """
    system = Lti.of(linear.discrete, problem.period)
    required = problem.spec.modulus_margin or 0.0
    vertices = tuple(_vertex(problem, system, candidate, point) for point in problem.box.vertices)
    for vertex in vertices:
        worst = max(vertex.checks, key=lambda check: check.spectral_radius)
        if not vertex.stable:
            raise NoSolutionError(
                f"not verified: the sampled loop is unstable at vertex {_where(vertex)} with {worst.delay_samples} samples of delay "
                f"(spectral radius {worst.spectral_radius:.4f}); {RELAX}"
            )
    weakest = min(vertices, key=lambda vertex: vertex.modulus_margin)
    if weakest.modulus_margin < required:
        raise NoSolutionError(
            f"not verified: modulus margin {weakest.modulus_margin:.4f} < {required:g} at vertex {_where(weakest)} "
            f"with {problem.delay} samples of delay; {RELAX}"
        )
    worst_norm = max(vertex.sampled_norm for vertex in vertices)
    return stored.Verified(
        candidate.gamma,
        worst_norm,
        required,
        vertices,
        count_drive=_count(problem, system),
        rounded=tuple(_rounded(problem, system, number, worst_norm, required) for number in NUMBERS),
        margins=_margins(problem, system),
    )


def _vertex(problem: Problem, system: Lti, candidate: Candidate, point: PlantPoint) -> stored.Vertex:
    delays = sorted({0, 1, problem.delay})
    checks = loop_checks(system, point, problem.lag, tuple(delays))
    sampled_norm = performance(system, problem.running(point.rates))
    return stored.Vertex(
        name=point.name,
        inertia=point.inertia,
        viscous=point.viscous,
        coulomb=point.coulomb,
        constant=point.constant,
        norm=sampled_norm if problem.sampled else performance(candidate.designed, problem.plant(point.rates)),
        sampled_norm=sampled_norm,
        modulus_margin=checks[delays.index(problem.delay)].modulus_margin,
        stable=all(check.spectral_radius < 1.0 for check in checks) and math.isfinite(sampled_norm),
        checks=checks,
    )


def _count(problem: Problem, system: Lti) -> float:
    actuator, encoder = problem.model.bench.actuator, problem.model.bench.encoder
    asked = count_current(system, encoder.resolution)
    if asked > COUNT_LIMIT * actuator.limit.value:
        unit = "A" if actuator.drive == "current" else "V"
        raise NoSolutionError(
            f"not verified: one encoder count asks for {asked:.4g} {unit}, more than {COUNT_LIMIT:g} times the limit of "
            f"{actuator.limit.value:g} {unit}; raise weights.command or weights.noise"
        )
    return asked


def _rounded(problem: Problem, system: Lti, number: Literal["double", "float"], claimed: float, required: float) -> stored.Rounded:
    k = rounded(system, number)
    gamma, where = max((performance(k, problem.running(point.rates)), point.name) for point in problem.box.vertices)
    margin = min(loop_checks(k, point, problem.lag, (problem.delay,))[0].modulus_margin for point in problem.box.vertices)
    if not gamma <= CLAIM * claimed or margin < required:
        raise NoSolutionError(
            f"not verified: with coefficients rounded to {number} the norm is {gamma:.4g} at vertex {where} where {claimed:.4g} is "
            f"claimed, the modulus margin {margin:.3f} where {required:g} is specified; bring the weights nearer to each other"
        )
    return stored.Rounded(number, gamma, margin)


def _margins(problem: Problem, system: Lti) -> stored.Margins:
    found = [margins(system, point.rates, problem.lag, problem.delay) for point in problem.box.vertices]
    friction = max(small_gain(system, point.rates, problem.lag, problem.delay) for point in problem.box.vertices)
    return stored.Margins(
        gain_increase=_finite(min(one.gain_up for one in found)),
        gain_decrease=max(one.gain_down for one in found) or None,
        phase_deg=float(np.degrees(min(one.phase for one in found))),
        delay_s=_finite(min(one.delay for one in found)),
        small_gain=friction,
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _where(vertex: stored.Vertex) -> str:
    names = ("inertia", "viscous", "coulomb", "constant")
    return f"{vertex.name} ({', '.join(f'{name} {getattr(vertex, name):.4g}' for name in names)})"
