"""A controller that somebody else designed: posed, verified and stored as one of ours, so that
everything runs with it.

What is verified is what a method's candidate is verified for (acceptance.py); no norm is asked for,
the derived weights only tell one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import msgspec

from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.design_blocks import PositionLawDesign, PrefilterDesign
from frictool.documents.digests import with_digests
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.documents.spec import Spec
from frictool.documents.weights import Weights
from frictool.plant.polytope import polytope
from frictool.synth.acceptance import accept
from frictool.synth.certificate_construction import certified_weights
from frictool.synth.design import _document
from frictool.synth.feasibility import check_feasible
from frictool.synth.realisation import stored_forms
from frictool.synth.surrounding_blocks import blocks
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem
from frictool.synth.weights import choose_weights
from frictool.systems.lti_conversion import as_lti


@dataclass(frozen=True)
class _ExternalProblem(SynthesisProblem):
    """A problem whose answer is given: there are no weights to turn."""

    @property
    def hint(self) -> str:
        return "lower the controller's gain, or give it more phase lead"

    @property
    def softer(self) -> str:
        return "lower the controller's gain at high frequencies"


def external_controller(
    system: Any,
    model: Model,
    spec: Spec,
    *,
    name: str = "own",
    position_law: PositionLawDesign | None = None,
    prefilter: PrefilterDesign | None = None,
    weights: Weights | None = None,
    provenance: Provenance | None = None,
) -> Controller:
    """`system` as a controller document, verified at the vertices of the model's intervals with 0
    and 1 sample of delay.

    system: of python-control or scipy.signal, from the position's error [rad | m] to the drive [A |
    V]; with a `position_law` from eta = integral(speed reference) - position. A continuous one is
    discretised by Tustin at the bench's period. It may have one integrator and has to be stable
    otherwise. Raises FrictoolError where it is no such system, NoSolutionError where a loop is
    unstable or misses the specified modulus margin.
    """
    design = Design(
        format="design/1",
        name=name,
        axis=model.axis,
        structure="position" if position_law is None else "speed_cascade",
        method="lpv",  # of which nothing is run
        weights=weights or Weights(),
        position_law=position_law,
        prefilter=prefilter,
    )
    check_feasible(model, spec, design)
    bench, chosen = model.bench, choose_weights(model, spec, design)
    lag, period = bench.actuator.loop_time_constant_s, bench.sample_period_s
    posed = _ExternalProblem(
        polytope(model), lag, period, bench.delay_samples, chosen.weights, design, model, spec
    )
    given = as_lti(system, period)
    composed, linear = blocks(model, design), stored_forms(given)
    verified = accept(posed, ControllerCandidate(given, given), linear, composed)
    origin = provenance or provenance_of_call(
        "frictool.synth.external_controller", model=model, spec=spec
    )
    document = _document(posed, linear, verified, composed, origin)
    return with_digests(
        msgspec.structs.replace(document, method="own", weights=certified_weights(chosen.weights))
    )
