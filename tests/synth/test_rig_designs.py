"""Every design of the clutch's rig synthesises; every one under refused/ is refused, for the reason
that its first lines give."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.documents.design import Design
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth.design import design_controller
from studies.rigs.clutch_model import ROOT, clutch_model

RIG = ROOT / "configs/clutch"
WHY = {
    "annex_c": r"unstable at vertex v\d+ .* with 1 sample of delay \(spectral radius 1\.\d+\)",
    "position_frozen": r"modulus margin 0\.3\d+ < 0\.5 at vertex",
    "text_weights": r"modulus margin 0\.\d+ < 0\.5 at vertex",
}


QUICK = ("annex", "fast")  # test_design.py takes "speed", `make accept` all of them


@pytest.mark.parametrize(
    "path", [RIG / f"designs/{name}.yaml" for name in QUICK], ids=lambda path: path.stem
)
def test_what_is_offered_synthesises(path: Path) -> None:
    controller = design_controller(
        clutch_model(), load(RIG / "spec.yaml", Spec), load(path, Design), Provenance("a test", "0")
    )
    assert all(
        vertex.stable and vertex.modulus_margin >= 0.5 for vertex in controller.verified.vertices
    )


@pytest.mark.parametrize(
    "path", sorted((RIG / "refused").glob("*.yaml")), ids=lambda path: path.stem
)
def test_what_must_be_refused_is(path: Path) -> None:
    with pytest.raises(NoSolutionError, match=WHY[path.stem]):
        design_controller(
            clutch_model(),
            load(RIG / "spec.yaml", Spec),
            load(path, Design),
            Provenance("a test", "0"),
        )


def test_every_refused_design_has_its_reason() -> None:
    assert {path.stem for path in (RIG / "refused").glob("*.yaml")} == set(WHY)
