"""Import of a controller from another tool, with verification.

The controller must pass the checks of acceptance.py; the norm of the loop may have any value. The
weights only define the norm that the document states.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import msgspec

from frictool.adapters.model_polytope import polytope
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.design_blocks import PositionLawDesign, PrefilterDesign
from frictool.documents.digests import with_digests
from frictool.documents.model import Model
from frictool.documents.provenance import provenance_of_call
from frictool.documents.spec import Spec
from frictool.documents.synthesis_methods import METHODS, SynthesisMethod
from frictool.documents.weights import Weights
from frictool.synth.acceptance import accept
from frictool.synth.certificate_bounds import certified_weights
from frictool.synth.design import controller_document
from frictool.synth.feasibility import check_feasible
from frictool.synth.realisation import stored_forms
from frictool.synth.surrounding_blocks import blocks
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem
from frictool.synth.weights import choose_weights
from frictool.systems.lti_conversion import as_lti

EXTERNAL = SynthesisMethod(
    "none: the controller exists",
    "for a controller that was designed with another tool",
    (),
    more_margin="lower the controller's gain, or give it more phase lead",
    less_noise="lower the controller's gain at high frequencies",
)


@dataclass(frozen=True)
class _ExternalProblem(SynthesisProblem):
    """Synthesis problem whose error messages advise the user to change the controller."""

    @property
    def method(self) -> SynthesisMethod:
        return EXTERNAL


def external_controller(
    system: Any,
    model: Model,
    spec: Spec,
    *,
    name: str = "own",
    position_law: PositionLawDesign | None = None,
    prefilter: PrefilterDesign | None = None,
    weights: Weights | None = None,
) -> Controller:
    """Convert a linear system to a controller document, and verify it at the model's vertices.

    The loops are checked with a delay of 0 samples, 1 sample and the delay in bench.yaml. A
    continuous system is discretised by Tustin's method at the sample period in bench.yaml. The
    system may have one integrator; all its other poles must be stable.

    Parameters
    ----------
    system : LTI system of python-control or scipy.signal
        Controller from the position error [rad | m] to the drive [A | V]. With a `position_law`,
        the input of the controller is eta = integral(speed reference) - position.
    model : Model
        Identified model whose intervals span the vertices.
    spec : Spec
        Specification with the modulus margin.
    name : str
        Name of the controller document.
    position_law, prefilter : PositionLawDesign, PrefilterDesign, optional
        Blocks around the controller.
    weights : Weights, optional
        Weights of the norm in the document; by default derived from `spec`.

    Returns
    -------
    Controller
        Document with method "own".

    Raises
    ------
    FrictoolError
        If `system` is not an LTI system of python-control or scipy.signal.
    NoSolutionError
        If a loop is unstable or has less than the specified modulus margin.
    """
    design = Design(
        format="design/1",
        name=name,
        axis=model.axis,
        structure="position" if position_law is None else "speed_cascade",
        method=next(iter(METHODS)),  # a valid design needs a method; this method is never run
        weights=weights or Weights(),
        position_law=position_law,
        prefilter=prefilter,
    )
    check_feasible(model, spec, design)
    bench = model.bench
    chosen = choose_weights(model, spec, design)
    lag = bench.actuator.loop_time_constant_s
    period = bench.sample_period_s
    posed = _ExternalProblem(
        polytope(model), lag, period, bench.delay_samples, chosen.weights, design, model, spec
    )
    lti = as_lti(system, period)
    composed = blocks(model, design)
    linear = stored_forms(lti)
    verified = accept(posed, ControllerCandidate(lti, lti), linear, composed)
    origin = provenance_of_call("frictool.synth.external_controller", model=model, spec=spec)
    document = controller_document(posed, linear, verified, composed, origin)
    return with_digests(
        msgspec.structs.replace(document, method="own", weights=certified_weights(chosen.weights))
    )
