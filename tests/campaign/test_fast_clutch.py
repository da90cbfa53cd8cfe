"""The fast design of the clutch, close to the time that its drive alone needs."""

from __future__ import annotations

from functools import cache

import msgspec
import numpy as np
import pytest

from frictool.adapters.shortest_step import shortest_step_times
from frictool.campaign import ControllerJudge, plants_of_model
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.synth.design import design_controller
from frictool.verify.vertices import vertex_points
from studies.rigs.clutch_model import ROOT, clutch_model

RIG = ROOT / "configs/clutch"
SPEC, STEPS = load(RIG / "spec.yaml", Spec), load(RIG / "scenarios/steps.yaml", Scenario)


@cache
def fast() -> Controller:
    design = load(RIG / "designs/fast.yaml", Design)
    return design_controller(clutch_model(), SPEC, design, Provenance("a test", "0"))


@pytest.mark.parametrize(
    ("model", "slowest"),
    [(clutch_model(), 0.122), (load(RIG / "nonlinear.yaml", Model), 0.126)],
    ids=["bench", "nonlinear"],
)
def test_every_corner_meets_the_specification_and_is_near_the_bound(
    model: Model, slowest: float
) -> None:
    without_margin = msgspec.structs.replace(SPEC, modulus_margin=None)
    plants = plants_of_model(model, STEPS)
    controller = fast()
    verdict = ControllerJudge(model, STEPS, without_margin, plants)(controller)
    assert len(plants) == 17
    assert np.all(verdict.met == 1)
    response = verdict.requirements[0].value
    bound = shortest_step_times(controller.bench, vertex_points(controller), 50.0, 0.05).worst
    assert bound < response <= slowest
    assert min(vertex.modulus_margin for vertex in controller.verified.vertices) >= 0.57
