"""Speed controller of the clutch, synthesised once."""

from __future__ import annotations

from functools import cache

from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.synth.design import design_controller
from studies.rigs.clutch_model import ROOT, clutch_model

RIG = ROOT / "configs/clutch"
HERE = Provenance("a test", "0")


def speed_spec() -> Spec:
    return load(RIG / "spec.yaml", Spec)


def speed_design() -> Design:
    return load(RIG / "designs/speed.yaml", Design)


@cache
def clutch_speed_controller() -> Controller:
    return design_controller(clutch_model(), speed_spec(), speed_design(), HERE)
