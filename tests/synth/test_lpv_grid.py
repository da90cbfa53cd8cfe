"""Method lpv_grid on the clutch's speed loop: what it claims holds at its plants, and it asks no
more than lpv."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.design import Design, Grid, Poles
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.plant.polytope import PlantPoint
from frictool.synth.design import problem
from frictool.synth.lpv import lpv
from frictool.synth.lpv_grid import lpv_grid
from frictool.synth.synthesis_problem import SynthesisProblem
from frictool.verify.hinf_norm import norm
from frictool.verify.speed_loop import check_loop
from studies.rigs.clutch_model import ROOT, clutch_model

RIG = ROOT / "configs/clutch"


def _problem(**changes: object) -> SynthesisProblem:
    design = msgspec.structs.replace(
        load(RIG / "designs/speed.yaml", Design), method="lpv_grid", **changes
    )
    return problem(clutch_model(), load(RIG / "spec.yaml", Spec), design)


@pytest.mark.parametrize("domain", ["discrete", "continuous"])
def test_it_asks_no_more_than_the_polytope_and_keeps_what_it_claims(domain: str) -> None:
    posed = _problem(schedule=("viscous", "coulomb"), domain=domain, grid=Grid(speed_per_s=1.0))
    found, polytopic = lpv_grid(posed), lpv(posed)
    assert found.gamma is not None
    assert found.optimum is not None
    assert polytopic.optimum is not None
    assert found.optimum <= polytopic.optimum * (1.0 + 2e-3)
    assert found.gamma == pytest.approx(posed.design.recentring * found.optimum)
    centre = posed.box.centre
    plant = posed.plant(
        PlantPoint("frozen", centre.inertia, centre.viscous, 0.18, centre.constant).rates
    )
    assert norm(plant.closed(found.designed))[0] <= 1.01 * found.gamma
    assert "viscous" in found.notes[0]
    assert "not proved between them" in found.notes[0]


def test_the_frozen_controller_of_the_identified_plant_is_another_one() -> None:
    posed = _problem(schedule=("constant",))
    centre = lpv_grid(posed)
    model = clutch_model(constant=(12.8e-3, 13.9e-3, 14.0e-3))
    design = msgspec.structs.replace(posed.design, frozen_at="identified")
    identified = lpv_grid(problem(model, posed.spec, design))
    assert not np.allclose(
        identified.controller.response([30.0]), centre.controller.response([30.0]), rtol=1e-3
    )


def test_scheduled_controllers_keep_gamma_at_their_corners() -> None:
    posed = _problem(
        schedule=("constant", "coulomb"),
        domain="continuous",
        scheduled=True,
        grid=Grid(speed_per_s=0.5),
    )
    found = lpv_grid(posed)
    assert found.gamma is not None
    assert found.over is not None
    assert [corner.constant for corner in found.over.vertices] == pytest.approx([12.8e-3, 14.0e-3])
    for k, corner in zip(found.scheduled, found.over.vertices, strict=True):
        assert check_loop(k, corner.rates, 0.003, 1).stable
    assert "interpolated controllers" in found.notes[1]
    with pytest.raises(FrictoolError, match="domain continuous"):
        lpv_grid(_problem(schedule=("constant",), scheduled=True))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"schedule": ("regime",)}, "found schedule regime; allowed"),
        ({"poles": Poles(decay_rad_s=1.0), "domain": "continuous"}, "no pole region"),
        ({"vertices": "inertia"}, "allowed: exact"),
    ],
)
def test_what_it_does_not_do_is_refused(changes: dict[str, object], told: str) -> None:
    with pytest.raises(FrictoolError, match=told):
        lpv_grid(_problem(**changes))
