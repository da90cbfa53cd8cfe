"""Speed loop by matrix inequalities at the polytope's vertices, position by the square-root law (5.2.3, 5.4.4, annex C).

The speed controller is synthesised directly at the bench's period with its computational delay (sampled by Tustin, the continuous
designs of the annex are unstable), for the centre and every vertex with common Lyapunov matrices, and frozen at the centre (5.3.4).
The frozen controller is not covered by the inequalities at the vertices: it is accepted only after the sampled loop, rebuilt from
the stored coefficients, was verified there.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.documents import controller as stored
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.lmi.discrete_hinf import Lyapunov, controller, minimise
from frictool.plant.generalised import GeneralisedPlant, Weights, generalised_plant
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint, Polytope, polytope
from frictool.synth.disturbance import disturbance
from frictool.synth.realisation import stored_forms
from frictool.synth.weights import speed_weights
from frictool.verify.controller import loop_checks
from frictool.verify.speed_loop import performance

SIGN_CONVENTION = (
    "eta = integral(speed reference) - position; drive = c x + d eta; x[k+1] = a x + b eta; "
    "a positive drive accelerates towards positive position; sections: (b0 + b1/z + b2/z^2)/(1 + a1/z + a2/z^2)"
)


def design_controller(model: Model, spec: Spec, design: Design, provenance: Provenance) -> stored.Controller:
    """A verified controller document.

    Raises NoSolutionError (exit 4) where the inequalities have no solution, or the sampled loop of the solution is unstable with
    0 or 1 sample of delay, or misses the specified modulus margin at the bench's delay; the message names the vertex and its figure. Or
    where the model's load is no disturbance that the drive can bear.
    """
    bench = model.bench
    disturbance(model)  # refuses what no loop of this structure can do
    period, delay, lag = bench.sample_period_s, bench.delay_samples, bench.actuator.loop_time_constant_s
    weights = speed_weights(model, spec, design)
    box = polytope(model)
    lyapunov, coefficients = _solve(box, lag, period, delay, weights, design.recentring)
    found = stored_forms(coefficients)
    system = Lti.of(found.discrete, period)
    norms = {point.name: performance(system, _plant(point, lag, period, delay, weights)) for point in box.vertices}
    verified = _verify(system, box, norms, lyapunov.gamma, spec, lag, delay)
    return stored.Controller(
        format="controller/1",
        name=design.name,
        axis=bench.axis,
        structure=design.structure,
        method=design.method,
        domain="discrete",
        sample_period_s=period,
        delay_samples=delay,
        drive=bench.actuator.drive,
        drive_limit=bench.actuator.limit.value,
        sign_convention=SIGN_CONVENTION,
        linear=found,
        position_law=_position_law(model, design),
        prefilter=None
        if design.prefilter is None
        else stored.Prefilter(design.prefilter.natural_frequency_rad_s, design.prefilter.damping),
        verified=verified,
        bench=bench,
        provenance=provenance,
    )


def _solve(box: Polytope, lag: float, period: float, delay: int, weights: Weights, recentring: float) -> tuple[Lyapunov, Lti]:
    """The Lyapunov matrices and the centre's controller.

    The command must enter every vertex alike (B2 constant, 5.61): through the delay's register. A bench without delay gets that
    register inside its controller, whose output then depends on the samples before only.
    """
    plants = [_plant(point, lag, period, max(delay, 1), weights) for point in (box.centre, *box.vertices)]
    try:
        lyapunov = minimise(plants, recentring)
        k = controller(plants[0], lyapunov)
    except np.linalg.LinAlgError as error:
        raise NoSolutionError(f"the synthesis broke down numerically ({error}); bring the weights nearer to each other") from None
    if delay > 0:
        return lyapunov, k
    n = k.order
    return lyapunov, Lti(
        np.block([[k.a, np.zeros((n, 1))], [k.c, np.zeros((1, 1))]]), np.vstack([k.b, k.d]), np.eye(n + 1)[n:], np.zeros((1, 1)), period
    )


def _plant(point: PlantPoint, lag: float, period: float, delay: int, weights: Weights) -> GeneralisedPlant:
    return generalised_plant("speed", point.rates, lag, weights, period, delay)


def _verify(found: Lti, box: Polytope, norms: dict[str, float], gamma: float, spec: Spec, lag: float, delay: int) -> stored.Verified:
    required = spec.modulus_margin or 0.0
    vertices = tuple(_vertex(found, point, norms[point.name], lag, delay) for point in box.vertices)
    for vertex in vertices:
        worst = max(vertex.checks, key=lambda check: check.spectral_radius)
        if not vertex.stable:
            raise NoSolutionError(
                f"not verified: the sampled loop is unstable at vertex {_where(vertex)} with {worst.delay_samples} samples of delay "
                f"(spectral radius {worst.spectral_radius:.4f}); raise weights.command or weights.noise, or lower weights.bandwidth_rad_s"
            )
    weakest = min(vertices, key=lambda vertex: vertex.modulus_margin)
    if weakest.modulus_margin < required:
        raise NoSolutionError(
            f"not verified: modulus margin {weakest.modulus_margin:.3f} < {required:g} at vertex {_where(weakest)} "
            f"with {delay} samples of delay; raise weights.command or weights.noise, or lower weights.bandwidth_rad_s"
        )
    return stored.Verified(gamma, max(norms.values()), required, vertices)


def _vertex(found: Lti, point: PlantPoint, norm: float, lag: float, delay: int) -> stored.Vertex:
    delays = sorted({0, 1, delay})
    checks = loop_checks(found, point, lag, tuple(delays))
    at_bench = checks[delays.index(delay)]
    return stored.Vertex(
        name=point.name,
        inertia=point.inertia,
        viscous=point.viscous,
        coulomb=point.coulomb,
        constant=point.constant,
        norm=norm,
        modulus_margin=at_bench.modulus_margin,
        stable=all(check.spectral_radius < 1.0 for check in checks) and math.isfinite(norm),
        checks=checks,
    )


def _where(vertex: stored.Vertex) -> str:
    names = ("inertia", "viscous", "coulomb", "constant")
    return f"{vertex.name} ({', '.join(f'{name} {getattr(vertex, name):.4g}' for name in names)})"


def _position_law(model: Model, design: Design) -> stored.PositionLaw:
    law, today = design.position_law, model.parameters
    force = today.coulomb.value * law.virtual_coulomb_factor
    gain = math.sqrt((2.0 if law.formula == "sqrt(2F/J)" else 1.0) * force / today.inertia.value)
    if gain <= 0.0:
        raise NoSolutionError("the square-root law needs Coulomb friction: the model's coulomb is zero")
    return stored.PositionLaw(
        gain=gain,
        formula=law.formula,
        band=law.band.value,
        action=law.action,
        settled_speed=law.settled_speed.value,
        rest_speed=0.0 if law.rest_speed is None else law.rest_speed.value,
        speed_filter_rad_s=law.speed_filter_rad_s or 0.0,
    )
