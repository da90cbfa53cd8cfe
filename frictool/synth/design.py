"""From model, specification and design to a controller document: the problem posed, a method's candidate, its stored forms, acceptance."""

from __future__ import annotations

from frictool.documents import controller as stored
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.spec import Spec
from frictool.plant.polytope import polytope
from frictool.synth.acceptance import accept
from frictool.synth.disturbance import disturbance
from frictool.synth.methods import METHODS
from frictool.synth.position_law import position_law
from frictool.synth.problem import Problem
from frictool.synth.realisation import stored_forms
from frictool.synth.weights import speed_weights

MEASURED = {"position": "position reference", "speed_cascade": "integral(speed reference)"}


def design_controller(model: Model, spec: Spec, design: Design, provenance: Provenance) -> stored.Controller:
    """A verified controller document.

    Raises NoSolutionError (exit 4) where the method finds no controller, where what it finds is not verified as it will run (the message
    names the vertex and its figure), or where the model's load is no disturbance that the drive can bear.
    """
    disturbance(model)  # refuses what no loop of these structures can do
    posed = problem(model, spec, design)
    candidate = METHODS[design.method](posed)
    linear = stored_forms(candidate.controller)
    verified = accept(posed, candidate, linear)
    bench, prefilter = model.bench, design.prefilter
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
        position_law=None if design.position_law is None else position_law(model, design.position_law),
        prefilter=None if prefilter is None else stored.Prefilter(prefilter.natural_frequency_rad_s, prefilter.damping),
        verified=verified,
        bench=bench,
        provenance=provenance,
    )


def problem(model: Model, spec: Spec, design: Design) -> Problem:
    """The design's problem on the model's polytope, with the weights given or derived."""
    bench = model.bench
    lag = bench.actuator.loop_time_constant_s
    return Problem(
        polytope(model), lag, bench.sample_period_s, bench.delay_samples, speed_weights(model, spec, design), design, model, spec
    )


def sign_convention(design: Design) -> str:
    """What the numbers of a controller document mean."""
    return (
        f"eta = {MEASURED[design.structure]} - position; drive = c x + d eta; x[k+1] = a x + b eta; "
        "a positive drive accelerates towards positive position; sections: (b0 + b1/z + b2/z^2)/(1 + a1/z + a2/z^2)"
    )
