"""Controllers of the clutch with a certificate, as `frictool synth` writes them: the speed loop of
eta (`speed`, `fast`), and a cascade fed by the filtered difference of positions (`pi_speed`)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Literal

import msgspec
import pytest

from frictool.adapters.model_polytope import polytope
from frictool.documents.certificate import Box
from frictool.documents.controller import Controller, Robustness
from frictool.documents.design import Design
from frictool.documents.digests import with_digests
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.plant.parameter_box import enclosing_box
from frictool.synth.certificate_bounds import certify
from frictool.synth.design import design_controller
from frictool.verify import interior_search
from frictool.verify.certificate_document import certified_loop
from frictool.verify.certificate_loop import SENSITIVITY
from frictool.verify.loop_values import loops_of
from frictool.verify.vertices import vertex_points
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.clutch_speed_controller import clutch_speed_controller

RIG = ROOT / "configs/clutch"
Named = Literal["speed", "fast", "pi_speed"]
INTERIOR = 20  # points inside the box; every recomputation of `inside` has to take as many
FOLDERS = {"speed": "designs", "fast": "designs", "pi_speed": "laws"}


@contextmanager
def few_interior_points() -> Iterator[None]:
    """Evaluate INTERIOR plants between the vertices, where their number is not the subject."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(interior_search, "POINTS", INTERIOR)
        yield


@cache
def certified(name: Named) -> Controller:
    """With figures inside the box, and the bounds of a solver that older versions stored; the
    certificate's bound stands for them."""
    spec, design = load(RIG / "spec.yaml", Spec), load(RIG / f"{FOLDERS[name]}/{name}.yaml", Design)
    found = (
        clutch_speed_controller()
        if name == "speed"
        else design_controller(clutch_model(), spec, design, Provenance("a test", "0"))
    )
    certificate, _ = certify(
        certified_loop(found, found.weights or SENSITIVITY),
        Box(**enclosing_box(polytope(clutch_model()).vertices)),
    )
    bound = certificate.bounds[0].below
    with few_interior_points():
        inside = loops_of(found, vertex_points(found)).seen_inside()
    verified = msgspec.structs.replace(
        found.verified, robustness=Robustness(INTERIOR, inside, bound, bound, bound)
    )
    return with_digests(
        msgspec.structs.replace(found, verified=verified, certificate=certificate, weights=None)
    )
