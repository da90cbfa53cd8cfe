"""The claims for the vertices hold inside the box: a worse plant there ends the synthesis."""

from __future__ import annotations

from dataclasses import replace

import pytest

from frictool.documents.design import Design
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth import robustness as beyond
from frictool.synth.design import problem
from frictool.synth.lpv import lpv
from frictool.verify import interior_search
from frictool.verify.interior_search import WorstPlant, searched
from studies.rigs.clutch_model import ROOT, clutch_model

RIG = ROOT / "configs/clutch"


@pytest.mark.parametrize(
    ("factor", "told"), [(1.02, "above .* vertices"), (float("inf"), "unstable inside the box")]
)
def test_a_worse_plant_inside_is_refused(
    factor: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    posed = problem(
        clutch_model(), load(RIG / "spec.yaml", Spec), load(RIG / "designs/speed.yaml", Design)
    )

    def worse(*given: object) -> WorstPlant:
        found = searched(*given)
        return replace(found, norm=factor * found.norm)

    monkeypatch.setattr(interior_search, "searched", worse)
    monkeypatch.setattr(interior_search, "POINTS", 4)
    with pytest.raises(NoSolutionError, match=told):
        beyond.robustness(posed, lpv(posed).controller)
