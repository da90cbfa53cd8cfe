"""Synthesis of a controller from documents in memory, as `frictool synth` does from files."""

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

    The controller is verified in the form that the target hardware runs.

    Parameters
    ----------
    model : Model
        Identified model.
    spec : Spec
        Specification of the closed loop.
    design : Design
        Structure, method and weights.
    vertices_only : bool
        Verify the vertices only, without certificate.
    varying : bool
        Also compute a bound for parameters that vary arbitrarily fast. The certificate applies to
        constant parameters only.
    provenance : Provenance, optional
        Origin that the document states; by default the call of this function.
    progress : callable
        Called with the name of each step of the work.

    Returns
    -------
    SynthesisResult
        Verified controller document with derived values and notes.

    Raises
    ------
    NoSolutionError
        If the method has no solution, the verification fails, or no parameter of the model was
        identified.
    InputFileError
        If one document describes a rotary axis and another a linear axis.
    """
    require_identified(model)
    same_axis({Path("model"): model, Path("spec"): spec, Path("design"): design})
    origin = provenance or provenance_of_call(
        "frictool.synth.synthesise", model=model, spec=spec, design=design
    )
    scope = ProofScope(vertices_only, varying)
    return synthesise_verified(model, spec, design, origin, scope=scope, progress=progress)


def require_identified(model: Model) -> None:
    """Raise NoSolutionError if no parameter of the model was identified from a log."""
    if model.bench_values_only is None:
        return
    raise NoSolutionError(
        f"bench_values_only: no parameter was identified for the model {model.name}; identify the "
        f"axis "
        "from a log that gives its inertia or its friction"
    ).at("model", "bench_values_only")
