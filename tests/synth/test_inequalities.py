"""Messages when the inequalities have no solution, or none that holds."""

from __future__ import annotations

import re

import msgspec
import pytest

from frictool.documents.design import Design
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.synth.design import problem
from frictool.synth.lmi_synthesis import slow_weight
from studies.rigs.clutch_model import ROOT, clutch_model


def told(static_error: float) -> str:
    design = load(ROOT / "configs/clutch/designs/speed.yaml", Design)
    slow = msgspec.structs.replace(
        design, weights=msgspec.structs.replace(design.weights, static_error=static_error)
    )
    return slow_weight(problem(clutch_model(), load(ROOT / "configs/clutch/spec.yaml", Spec), slow))


def test_a_weight_that_is_no_integrator_is_not_blamed() -> None:
    assert told(0.03) == ""


@pytest.mark.parametrize("static_error", [1e-3, 1e-5])
def test_one_that_nearly_is_is_named_with_a_static_error_for_which_it_is_none(
    static_error: float,
) -> None:
    found = re.search(
        r"a static error of (\S+) has a pole at .* try weights.static_error (\S+)$",
        told(static_error),
    )
    assert found is not None
    assert float(found[1]) == pytest.approx(static_error, rel=0.05)
    assert told(float(found[2])) == ""
