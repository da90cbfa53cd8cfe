"""A candidate becomes a controller only here: the loop rebuilt in physical units from the coefficients as they are stored, sampled at the
bench's period with its delay, at every vertex. Nothing that the method says is believed."""

from __future__ import annotations

import math

from frictool.documents import controller as stored
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.synth.problem import Candidate, Problem
from frictool.verify.controller import loop_checks
from frictool.verify.speed_loop import performance

RELAX = "raise weights.command or weights.noise, or lower weights.bandwidth_rad_s"


def accept(problem: Problem, candidate: Candidate, linear: stored.LinearController) -> stored.Verified:
    """What was verified of the loop that `linear` closes.

    Raises NoSolutionError (exit 4) naming the vertex and its figure where the loop is unstable with 0 samples of delay, 1 or the bench's,
    or misses the specified modulus margin at the bench's.
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
            f"not verified: modulus margin {weakest.modulus_margin:.3f} < {required:g} at vertex {_where(weakest)} "
            f"with {problem.delay} samples of delay; {RELAX}"
        )
    return stored.Verified(candidate.gamma, max(vertex.sampled_norm for vertex in vertices), required, vertices)


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


def _where(vertex: stored.Vertex) -> str:
    names = ("inertia", "viscous", "coulomb", "constant")
    return f"{vertex.name} ({', '.join(f'{name} {getattr(vertex, name):.4g}' for name in names)})"
