"""The scheduled controller: its weights are barycentric, and what is stored was verified between
the corners too."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.model_polytope import polytope
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.documents.writing import to_yaml
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.synth.controller_schedule import verified_schedule
from frictool.synth.design import design_controller, problem
from frictool.synth.methods import solver
from frictool.verify.scheduled_loop import interpolate_controller, weights
from studies.rigs.clutch_model import ROOT, clutch_model

RIG, HERE = ROOT / "configs/clutch", Provenance("a test", "0")
SHARES = st.tuples(*[st.floats(0.0, 1.0)] * 4)


def inside(share: tuple[float, ...]) -> PlantPoint:
    box = polytope(clutch_model()).vertices
    low, high = box[0], box[-1]
    values = [
        getattr(low, n) + x * (getattr(high, n) - getattr(low, n))
        for x, n in zip(share, NAMES, strict=True)
    ]
    return PlantPoint("p", *values)


NAMES = ("inertia", "viscous", "coulomb", "constant")


@given(SHARES)
def test_the_weights_are_barycentric(share: tuple[float, ...]) -> None:
    corners, point = polytope(clutch_model()).vertices, inside(share)
    alpha = weights(corners, NAMES, point)
    assert np.all(alpha >= 0.0)
    assert np.sum(alpha) == pytest.approx(1.0)
    for name in NAMES:
        assert alpha @ [getattr(corner, name) for corner in corners] == pytest.approx(
            getattr(point, name), rel=1e-9, abs=1e-12
        )


def test_outside_its_interval_a_parameter_counts_as_at_its_end() -> None:
    corners = polytope(clutch_model()).vertices
    beyond = replace(corners[5], inertia=corners[5].inertia * 0.5)
    assert weights(corners, NAMES, beyond) == pytest.approx(np.eye(len(corners))[5])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.integers(1, 4), st.data())
def test_a_sum_with_one_weight_is_that_controller(
    seed: int, count: int, data: st.DataObject
) -> None:
    which = data.draw(st.integers(0, count - 1))
    random = np.random.default_rng(seed)
    controllers = [
        Lti(*(random.normal(size=shape) for shape in ((3, 3), (3, 1), (1, 3), (1, 1))), 1e-3)
        for _ in range(count)
    ]
    found = interpolate_controller(controllers, np.eye(count)[which])
    assert found.period == controllers[0].period
    for part in "abcd":
        assert np.array_equal(getattr(found, part), getattr(controllers[which], part))


def test_the_clutch_scheduled_holds_more_than_frozen_and_is_stored() -> None:
    design = msgspec.structs.replace(load(RIG / "designs/speed.yaml", Design), scheduled=True)
    controller = design_controller(clutch_model(), load(RIG / "spec.yaml", Spec), design, HERE)
    assert controller.schedule is not None
    assert len(controller.schedule.corners) == 16
    assert controller.schedule.gamma < controller.verified.gamma_verified
    assert controller.schedule.modulus_margin >= 0.5
    assert msgspec.yaml.decode(to_yaml(controller), type=Controller) == controller


def test_a_schedule_that_misses_the_margin_is_refused() -> None:
    design, spec = load(RIG / "designs/speed.yaml", Design), load(RIG / "spec.yaml", Spec)
    posed = problem(clutch_model(), spec, design)
    candidate = solver("lpv")(posed)
    with pytest.raises(NoSolutionError, match="the scheduled loop has a modulus margin"):
        verified_schedule(
            replace(posed, spec=msgspec.structs.replace(spec, modulus_margin=0.9)), candidate
        )
    runaway = replace(
        candidate, scheduled=tuple(replace(k, a=k.a + np.eye(k.order)) for k in candidate.scheduled)
    )
    with pytest.raises(NoSolutionError, match="itself unstable"):
        verified_schedule(posed, runaway)


@pytest.mark.parametrize("change", [{"method": "minimax"}, {"order": 3}, {"schedule": ("regime",)}])
def test_what_cannot_be_scheduled_is_said(change: dict[str, object]) -> None:
    design = load(RIG / "designs/speed.yaml", Design)
    with pytest.raises(
        (ValueError, FrictoolError),
        match=r"scheduled`? (belongs to methods lpv, lft_lpv, |cannot be combined with `order`)",
    ):
        Design(**{**msgspec.structs.asdict(design), "scheduled": True, **change})
