"""Design of a controller document: run a synthesis method, verify and store its candidate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import msgspec

from frictool.adapters.model_polytope import polytope
from frictool.documents import controller as stored
from frictool.documents.certificate import Box, Certificate
from frictool.documents.design import Design
from frictool.documents.digests import with_digests
from frictool.documents.missing_effects import refuse_sensor_lag, undeclared_ringing
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.parameter_box import enclosing_box
from frictool.runtime.object_view import ResultView
from frictool.synth.acceptance import accept, resonant, sprung, unstable_earlier
from frictool.synth.certificate_bounds import certified_weights, certify
from frictool.synth.controller_schedule import verified_schedule
from frictool.synth.feasibility import check_feasible
from frictool.synth.load_disturbance import disturbance, stiffness_of
from frictool.synth.lpv import bound
from frictool.synth.methods import solver
from frictool.synth.realisation import running_in_sections, stored_forms
from frictool.synth.robustness import robustness, sensitivity_inside
from frictool.synth.surrounding_blocks import SurroundingBlocks, blocks
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem
from frictool.synth.weight_relaxation import Trade, relaxed_problem
from frictool.synth.weights import ChosenWeights, DerivedValue, choose_weights
from frictool.verify.certificate_document import certified_loop
from frictool.verify.certificate_loop import SENSITIVITY
from frictool.verify.document_check import NOT_EVALUABLE
from frictool.verify.feedback_loops import feedbacks_of
from frictool.verify.proved_bound import ProvedBound
from frictool.verify.recheck import needs_search
from frictool.verify.rest_proof import prove_rest

WHOLE = (
    "bounds and certificate apply to the speed loop; the proportional law around it is verified at "
    "the vertices and at plants between them"
)
NOT_VARYING = "no bound was found for parameters that vary at any speed"
MEASURED = {"position": "position reference", "speed_cascade": "integral(speed reference)"}


@dataclass(frozen=True, eq=False, repr=False)
class SynthesisResult(ResultView):
    """Verified controller document, with information for the output of `synth`.

    - derived: values that were derived for keys that the design leaves out
    - trade: result of the weight relaxation; None unless the design has `relax: auto`
    - notes: sentences for the user
    - proved: proved bounds of the certificate
    """

    controller: stored.Controller
    derived: tuple[DerivedValue, ...]
    trade: Trade | None
    notes: tuple[str, ...]
    proved: tuple[ProvedBound, ...] = ()


@dataclass(frozen=True)
class ProofScope:
    """Options of the verification for plants between the vertices.

    - vertices_only: True to verify the vertices only, without a certificate
    - varying: True to also compute a bound of the norm for parameters that vary arbitrarily fast
    """

    vertices_only: bool = False
    varying: bool = False


def design_controller(
    model: Model, spec: Spec, design: Design, provenance: Provenance
) -> stored.Controller:
    """Design a controller, verify it at the vertices only, and return its document.

    Raises NoSolutionError as `synthesise_verified` does.
    """
    return synthesise_verified(
        model, spec, design, provenance, scope=ProofScope(vertices_only=True)
    ).controller


def synthesise_verified(
    model: Model,
    spec: Spec,
    design: Design,
    provenance: Provenance,
    *,
    scope: ProofScope = ProofScope(),
    progress: Callable[[str], None] = lambda _: None,
) -> SynthesisResult:
    """Design a controller and verify it.

    `scope` selects the verification between the vertices. `progress` is called with the name of
    each step of the work. Raises NoSolutionError if the method finds no controller, if the
    verification fails (the message names the vertex and the value), or if the drive cannot hold the
    load of the model.
    """
    disturbance(model)  # refuses loads that these structures cannot handle
    possible = check_feasible(model, spec, design)
    posed, chosen = _posed(model, spec, design)
    peak = math.inf if spec.drive_peak is None else spec.drive_peak.value
    composed = blocks(model, design, peak)
    trade = None
    if design.relax == "auto":
        progress("the trade between disturbance rejection and effort")
        posed, trade = relaxed_problem(posed, chosen, bound, progress=progress)
    progress(f"synthesis by {design.method}")
    candidate = solver(design.method)(replace(posed, progress=progress))
    progress("verification at the vertices")
    try:
        linear = running_linear(posed, candidate)
        verified = accept(posed, candidate, linear, composed)
    except NOT_EVALUABLE as error:
        raise NoSolutionError(
            f"not verified: the loop cannot be evaluated ({error}); {posed.method.more_margin}"
        ) from None
    controller, notes = (
        controller_document(posed, linear, verified, composed, provenance),
        (*possible, *candidate.notes, *composed.notes),
    )
    if earlier := unstable_earlier(verified.vertices, posed.delay):
        notes = (*notes, earlier)
    if controller.resonances is not None:
        notes = (*notes, _with_resonances(posed, controller))
    if controller.stiffness is not None:
        notes = (*notes, *_with_spring(posed, controller))
    if design.scheduled:
        progress("verification of the scheduled controller")
        controller = msgspec.structs.replace(
            controller, schedule=verified_schedule(posed, candidate)
        )
    proved: tuple[ProvedBound, ...] = ()
    if not scope.vertices_only:
        controller, proved, remarks = _beyond(posed, controller, scope, progress)
        notes = (*notes, *remarks)
    if controller.certificate is None and posed.weighs:
        controller = msgspec.structs.replace(controller, weights=certified_weights(posed.weights))
    return SynthesisResult(
        with_digests(controller), (*chosen.derived, *composed.derived), trade, notes, proved
    )


def _with_resonances(posed: SynthesisProblem, controller: stored.Controller) -> str:
    check = resonant(posed, feedbacks_of(controller))
    assert check is not None
    assert controller.resonances is not None
    return (
        f"with the resonances of {', '.join(controller.resonances.links)}: stable, modulus margin "
        f"at least {check.modulus_margin:.3f} "
        f"({check.where}); norms, bounds and certificate do not include resonances"
    )


def _with_spring(posed: SynthesisProblem, controller: stored.Controller) -> tuple[str, ...]:
    check = sprung(posed, feedbacks_of(controller))
    if check is None:
        return ()
    return (
        f"with the spring: stable, modulus margin at least {check.modulus_margin:.3f} "
        f"({check.where}); norms, bounds and certificate do not include the spring",
    )


def running_linear(
    posed: SynthesisProblem, candidate: ControllerCandidate
) -> stored.LinearController:
    """Return the linear controller of a candidate in all forms that a document stores.

    The field `form` names the form that runs on the target hardware.
    """
    design = posed.design
    # conditional integration instead of back-calculation, as in thesis 5.2.2
    conditional = posed.method.provided_gains and design.form == "state_space"
    linear = stored_forms(candidate.controller, conditional)
    if design.speed_input:
        linear = msgspec.structs.replace(linear, input="speed_error")
    return running_in_sections(linear, posed.period) if design.form == "sos" else linear


def _beyond(
    posed: SynthesisProblem,
    controller: stored.Controller,
    scope: ProofScope,
    progress: Callable[[str], None],
) -> tuple[stored.Controller, tuple[ProvedBound, ...], tuple[str, ...]]:
    progress("proof for every constant plant of the box")
    loops = feedbacks_of(controller)
    certificate, proved, remarks = _certificate(posed, controller)
    if certificate is not None:
        progress("proof of rest in the band")
        certificate = _with_rest(posed, controller, certificate)
    controller = msgspec.structs.replace(controller, certificate=certificate)
    if scope.varying or needs_search(controller):
        progress("search for the worst plant of the box")
        inside = (
            robustness(posed, loops[0].system, varying=scope.varying)
            if posed.weighs
            else sensitivity_inside(posed, loops)
        )
        verified = msgspec.structs.replace(controller.verified, robustness=inside)
        controller = msgspec.structs.replace(controller, verified=verified)
        if scope.varying and inside.common is None:
            remarks = (*remarks, NOT_VARYING)
    if posed.weighs and len(loops) > 1:
        sensitivity_inside(posed, loops)
        remarks = (*remarks, WHOLE)
    return controller, proved, remarks


def _certificate(
    posed: SynthesisProblem, controller: stored.Controller
) -> tuple[Certificate | None, tuple[ProvedBound, ...], tuple[str, ...]]:
    weights = certified_weights(posed.weights) if posed.weighs else SENSITIVITY
    box = Box(**enclosing_box(posed.box.vertices))
    try:
        return *certify(certified_loop(controller, weights), box), ()
    except NoSolutionError as error:
        return None, (), (str(error),)


def _with_rest(
    posed: SynthesisProblem, controller: stored.Controller, certificate: Certificate
) -> Certificate:
    """Add to the certificate the proof of rest or, without a rest band, a simulated limit cycle."""
    at_rest = prove_rest(controller, certificate)
    if at_rest is not None:
        return msgspec.structs.replace(certificate, rest=at_rest, cycle=None)
    from frictool.synth.cycle_search import find_cycle  # loads the engine

    return msgspec.structs.replace(
        certificate, rest=None, cycle=find_cycle(posed.model, controller)
    )


def problem(model: Model, spec: Spec, design: Design) -> SynthesisProblem:
    """Return the synthesis problem of a design; rules derive the weights that the design omits.

    The weight relaxation (`relax: auto`) is not applied.
    """
    return _posed(model, spec, design)[0]


def _posed(model: Model, spec: Spec, design: Design) -> tuple[SynthesisProblem, ChosenWeights]:
    bench = model.bench
    refuse_sensor_lag(bench, "synth designs a controller")
    chosen = choose_weights(model, spec, design)
    lag = bench.actuator.loop_time_constant_s
    if design.prewarp_rad_s is not None and design.prewarp_rad_s * bench.sample_period_s >= math.pi:
        raise FrictoolError(
            f"prewarp_rad_s: found {design.prewarp_rad_s:g}; allowed: below "
            f"{math.pi / bench.sample_period_s:.6g} rad/s, half the sampling frequency "
            "of the bench; write the value of weights.bandwidth_rad_s, or remove the key"
        ).at("design", "prewarp_rad_s")
    posed = SynthesisProblem(
        polytope(model),
        lag,
        bench.sample_period_s,
        bench.delay_samples,
        chosen.weights,
        design,
        model,
        spec,
    )
    return posed, chosen


def controller_document(
    posed: SynthesisProblem,
    linear: stored.LinearController,
    verified: stored.Verified,
    composed: SurroundingBlocks,
    provenance: Provenance,
) -> stored.Controller:
    """Return the controller document of a design with its verified linear controller.

    composed: blocks around the linear controller.
    """
    design = posed.design
    bench = posed.model.bench
    return stored.Controller(
        format="controller/1",
        name=design.name,
        axis=bench.axis,
        structure=design.structure,
        method=design.method,
        domain=design.domain,
        sample_period_s=posed.period,
        delay_samples=posed.delay,
        drive=bench.actuator.drive,
        drive_limit=bench.actuator.limit.value,
        sign_convention=sign_convention(design),
        linear=linear,
        position_law=composed.position_law,
        velocity=composed.velocity,
        limiter=composed.limiter,
        friction_compensation=composed.friction_compensation,
        prefilter=composed.prefilter,
        profile=composed.profile,
        feedforward=composed.feedforward,
        verified=verified,
        bench=bench,
        provenance=provenance,
        resonances=posed.model.resonances,
        stiffness=stiffness_of(posed.model),
        ringing=undeclared_ringing(posed.model),
        logged_positions=posed.model.logged_positions,
        measurement_hold_samples=design.measurement_hold_samples,
    )


def sign_convention(design: Design) -> str:
    """Return the text that defines signals, signs and coefficients of a controller document."""
    entering = "eta"
    measured = f"{MEASURED[design.structure]} - position"
    if design.speed_input:
        entering, measured = "e", "speed reference - speed"
    return (
        f"{entering} = {measured}; drive = c x + d {entering}; x[k+1] = a x + b {entering}; "
        "a positive drive accelerates towards positive position; sections: (b0 + b1/z + "
        "b2/z^2)/(1 + a1/z + a2/z^2)"
    )
