"""Controller document to simulate a candidate; its norms and margins are not verified."""

from __future__ import annotations

from frictool.documents import controller as stored
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.synth.design import controller_document, problem, running_linear
from frictool.synth.methods import solver
from frictool.synth.surrounding_blocks import blocks
from frictool.synth.synthesis_problem import SynthesisProblem

UNVERIFIED = Provenance("candidate of a search", "0")


class CandidateControllers:
    """Function with a cache that returns the controller of a candidate's design.

    Designs with equal weights and gains share the linear controller in its stored forms. Raises
    FrictoolError if the method has no solution, or if a block does not suit the model.
    """

    def __init__(self, model: Model, spec: Spec) -> None:
        self.model, self.spec = model, spec
        self._solved: dict[tuple[object, ...], stored.LinearController | FrictoolError] = {}

    def __call__(self, design: Design) -> stored.Controller:
        """Return the controller document of a design, with unverified norms and margins."""
        posed = problem(self.model, self.spec, design)
        return controller_document(
            posed,
            self._linear(posed),
            _unverified(posed),
            blocks(self.model, design),
            UNVERIFIED,
        )

    def _linear(self, posed: SynthesisProblem) -> stored.LinearController:
        design = posed.design
        key = (
            *(design.method, design.weights, design.schedule, design.channel_effort, design.pid),
            *(design.structure, design.form),
        )
        if key not in self._solved:
            try:
                self._solved[key] = running_linear(posed, solver(design.method)(posed))
            except FrictoolError as error:
                self._solved[key] = error
        solved = self._solved[key]
        if isinstance(solved, FrictoolError):
            raise solved
        return solved


def _unverified(posed: SynthesisProblem) -> stored.Verified:
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
