"""Synthesis from documents in memory, the function behind `frictool synth`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.documents.registry import same_axis
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth.design import ProofScope, SynthesisResult, synthesise_verified


def synthesise(
    model: Model,
    spec: Spec,
    design: Design,
    *,
    vertices_only: bool = False,
    varying: bool = False,
    provenance: Provenance | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> SynthesisResult:
    """Synthesise a controller for every plant within the intervals of model and bench.

    The controller is verified as it will run.

    Parameters
    ----------
    model : Model
        Identified model.
    spec : Spec
        Specification of the closed loop.
    design : Design
        Structure, method and weights.
    vertices_only : bool
        Skip the search inside the box and the certificate.
    varying : bool
        Compute a bound for parameters that vary arbitrarily fast, too. The certificate holds for
        every constant plant.
    provenance : Provenance, optional
        Origin to store; the record of this call if left out.
    progress : callable
        Called with the name of each step.

    Returns
    -------
    SynthesisResult
        Verified controller document with derived values and notes.

    Raises
    ------
    NoSolutionError
        If the method has no solution, the controller fails the verification, or nothing of the
        model was identified (exit 4).
    InputFileError
        If the documents are not for one kind of axis.
    """
    require_identified(model)
    same_axis({Path("model"): model, Path("spec"): spec, Path("design"): design})
    origin = provenance or provenance_of_call(
        "frictool.synth.synthesise", model=model, spec=spec, design=design
    )
    scope = ProofScope(vertices_only, varying)
    return synthesise_verified(model, spec, design, origin, scope=scope, progress=progress)


def require_identified(model: Model) -> None:
    """Raise NoSolutionError if the model has the bench's values only."""
    if model.bench_values_only is None:
        return
    raise NoSolutionError(
        f"bench_values_only: nothing was identified for the model {model.name}; identify the axis "
        "from a log that gives its inertia or its friction"
    ).at("model", "bench_values_only")
