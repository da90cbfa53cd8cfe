"""Loops around a plant whose links yield: what `synth` refuses, what `verify` finds again, what one
axis does not play."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.resonances import Oscillation, Resonances
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.synth.design import design_controller
from frictool.verify.feedback_loops import feedbacks_of, open_loop
from frictool.verify.recheck import recheck
from frictool.verify.resonant_loop import resonant_check
from studies.command_line import run
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.clutch_speed_controller import clutch_speed_controller
from tests.support.command_line import refused

RIG = ROOT / "configs/clutch"


def yielding(rad_s: float, damping: float = 0.02) -> Resonances:
    return Resonances(
        poles=(Oscillation(rad_s, damping, (0.9 * rad_s, 1.1 * rad_s)),), links=("belt",)
    )


def designed(resonances: Resonances) -> Controller:
    model = msgspec.structs.replace(clutch_model(), resonances=resonances)
    return design_controller(
        model,
        load(RIG / "spec.yaml", Spec),
        load(RIG / "designs/speed.yaml", Design),
        Provenance("test", "0"),
    )


@pytest.fixture(scope="module")
def stiff() -> Controller:
    """Its belt swings far above the loop."""
    return designed(yielding(3000.0))


def test_a_resonance_far_above_leaves_the_loop_and_is_kept_in_the_document(
    stiff: Controller,
) -> None:
    assert stiff.resonances == yielding(3000.0)
    recheck(stiff)
    without = clutch_speed_controller()
    assert without.resonances is None
    assert without.linear == stiff.linear


def test_a_resonance_within_the_loop_is_refused_with_its_figure() -> None:
    with pytest.raises(
        NoSolutionError, match=r"resonance of belt at 60 rad/s.*(unstable|modulus margin)"
    ):
        designed(yielding(60.0))


def test_the_margin_is_the_distance_of_the_loop_from_minus_one(stiff: Controller) -> None:
    """Against a grid of frequencies of the loop gain itself, with the closed form of the belt's
    filter in continuous time far below 1/T."""
    lag, vertex = stiff.bench.actuator.loop_time_constant_s, stiff.verified.vertices[0]
    point = PlantPoint(vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant)
    given = yielding(3000.0)
    found = resonant_check(feedbacks_of(stiff), [point], lag, stiff.delay_samples, given)
    from frictool.adapters.resonance_filter import resonance_filters

    loop = feedbacks_of(stiff)[0]
    grid = np.geomspace(1.0, np.pi / stiff.sample_period_s * 0.999, 4000)
    distances = [
        np.min(np.abs(1.0 + open_loop(loop, point.rates, lag, 1, one).response(grid)[:, 0, 0]))
        for one in resonance_filters(given)
    ]
    assert found.modulus_margin == pytest.approx(min(distances), rel=1e-3)
    low = np.array([5.0, 20.0, 60.0])
    plain, filtered = (
        open_loop(loop, point.rates, lag, 1, one).response(low)[:, 0, 0]
        for one in (None, resonance_filters(given)[0])
    )
    s = 1j * low
    np.testing.assert_allclose(
        filtered / plain, 1.0 / (1.0 + 2.0 * 0.02 * s / 3000.0 + s**2 / 3000.0**2), rtol=2e-3
    )


def test_a_document_whose_resonance_is_lower_than_it_was_designed_for_is_not_verified(
    stiff: Controller,
) -> None:
    with pytest.raises(
        NoSolutionError, match="not verified: with the resonance of belt at 60 rad/s"
    ):
        recheck(msgspec.structs.replace(stiff, resonances=yielding(60.0)))


def test_one_axis_does_not_play_a_model_with_resonances(stiff: Controller, tmp_path: Path) -> None:
    from frictool.documents.writing import to_yaml

    model = msgspec.structs.replace(clutch_model(), resonances=yielding(3000.0))
    (tmp_path / "model.yaml").write_text(to_yaml(model))
    (tmp_path / "controller.yaml").write_text(to_yaml(stiff))
    assert load(tmp_path / "model.yaml", Model).resonances == yielding(3000.0)
    arguments = [
        "--controller",
        tmp_path / "controller.yaml",
        "--scenario",
        RIG / "scenarios/steps.yaml",
        "-o",
        tmp_path / "run.mcap",
    ]
    refused(
        run("simulate", tmp_path / "model.yaml", *arguments),
        3,
        "resonances: found resonances of belt; a simulation as one axis cannot contain resonances",
    )
