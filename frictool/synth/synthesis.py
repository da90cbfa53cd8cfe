"""Documents in memory to a verified controller: what `frictool synth` does."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from frictool.documents.bench_values import bench_values_words
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.documents.registry import same_axis
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth.design import SynthesisResult, synthesise_verified


def synthesise(
    model: Model,
    spec: Spec,
    design: Design,
    *,
    vertices_only: bool = False,
    provenance: Provenance | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> SynthesisResult:
    """Synthesise a controller for every plant within the intervals of model and bench, verified as
    it will run.

    vertices_only: faster, without bounds over the whole box and without a certificate. progress:
    callback for the current step. Raises NoSolutionError (exit 4) if the method has no solution, if
    the controller is not verified, or if nothing of the model was identified; InputFileError if the
    documents are not for one kind of axis.
    """
    if model.bench_values_only is not None:
        words = bench_values_words(f"the model {model.name}", model.bench_values_only)
        raise NoSolutionError(
            f"bench_values_only: {words}; identify the axis from a log that gives its inertia or its friction"
        ).at("model", "bench_values_only")
    same_axis({Path("model"): model, Path("spec"): spec, Path("design"): design})
    origin = provenance or provenance_of_call(
        "frictool.synth.synthesise", model=model, spec=spec, design=design
    )
    return synthesise_verified(
        model, spec, design, origin, beyond=not vertices_only, progress=progress
    )
