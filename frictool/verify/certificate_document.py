"""A controller document's certificate: the loop that it is about, built from the stored coefficients, and its proof."""

from __future__ import annotations

from frictool.documents.certificate import Certificate, CertifiedWeights
from frictool.documents.controller import Controller, Vertex
from frictool.errors import NoSolutionError
from frictool.verify.certificate import Proved, prove
from frictool.verify.certificate_loop import Loop

PARAMETERS = ("inertia", "viscous", "coulomb", "constant")


def certified_loop(controller: Controller, weights: CertifiedWeights) -> Loop:
    """The loop as it runs: the coefficients of the form that runs, at the sample period, with the bench's delay and drive lag."""
    return Loop(
        controller=controller.linear.discrete,
        controlled="position" if controller.structure == "position" else "speed",
        delay=controller.delay_samples,
        lag=controller.bench.actuator.loop_time_constant_s,
        period=controller.sample_period_s,
        weights=weights,
        sections=controller.linear.sos if controller.linear.form == "sos" else (),
    )


def prove_document(controller: Controller, certificate: Certificate) -> tuple[Proved, ...]:
    """Everything that the certificate states, proved of the controller's stored coefficients.

    Raises NoSolutionError where an inequality does not hold, or where the certificate's box leaves out a vertex of the document.
    """
    for vertex in controller.verified.vertices:
        for name in PARAMETERS:
            low, high = getattr(certificate.box, name)
            if not low <= getattr(vertex, name) <= high:
                raise NoSolutionError(_outside(vertex, name, low, high))
    try:
        return prove(certificate, certified_loop(controller, certificate.weights))
    except NoSolutionError as error:
        raise NoSolutionError(f"{controller.name}: {error}") from None


def _outside(vertex: Vertex, name: str, low: float, high: float) -> str:
    return (
        f"not proved: vertex {vertex.name} has {name} {getattr(vertex, name):.6g}, the certificate's box {low:.6g} to {high:.6g}; "
        "synthesise the controller anew"
    )
