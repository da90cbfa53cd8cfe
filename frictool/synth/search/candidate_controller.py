"""Controller document of a candidate, for play only: its figures are not verified."""

from __future__ import annotations

from frictool.documents import controller as stored
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.spec import Spec
from frictool.synth.design import controller_document, problem, running_linear
from frictool.synth.methods import solver
from frictool.synth.surrounding_blocks import blocks
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem

UNVERIFIED = Provenance("candidate of a search", "0")


def candidate_controller(
    model: Model, spec: Spec, design: Design, solved: ControllerCandidate | None = None
) -> stored.Controller:
    """Return the controller of a design without its verification.

    Parameters
    ----------
    model, spec, design
        The documents.
    solved : ControllerCandidate, optional
        Result of the method, if it is known already.

    Raises
    ------
    FrictoolError
        If the method has no solution, or a block does not suit the model.
    """
    posed = problem(model, spec, design)
    candidate = solver(design.method)(posed) if solved is None else solved
    return controller_document(
        posed,
        running_linear(posed, candidate),
        _unverified(posed),
        blocks(model, design),
        UNVERIFIED,
    )


def _unverified(posed: SynthesisProblem) -> stored.Verified:
    """Return the vertices of a problem without any figure."""
    return stored.Verified(
        None,
        0.0,
        posed.spec.modulus_margin or 0.0,
        tuple(
            stored.Vertex(
                point.name,
                point.inertia,
                point.viscous,
                point.coulomb,
                point.constant,
                norm=0.0,
                sampled_norm=0.0,
                modulus_margin=0.0,
                stable=False,
                checks=(),
            )
            for point in posed.box.vertices
        ),
    )
