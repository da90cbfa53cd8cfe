"""The axis stays below `mechanics.top_speed`, or a line says that it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from frictool.campaign import automatic_design, design_trial
from frictool.campaign.automatic_design import design_automatically
from frictool.campaign.design_trial import DesignTest, design_test, longest_step_of
from frictool.campaign.search_tests import search_tests
from frictool.cli.synth_play import PlayedTest
from frictool.documents.design import Design
from frictool.documents.design_blocks import PrefilterDesign
from frictool.documents.quantity import Quantity
from frictool.synth.search.candidate_controller import CandidateControllers
from frictool.synth.search.design_scales import design_scales
from frictool.synth.search.pi_cascade import PI_CASCADE
from frictool.synth.search.played_search import Candidate
from tests.support.turntable import POSSIBLE, turntable


def turning(top_speed: float) -> DesignTest:
    model = turntable(breakaway=(1.4, 1.7, 2.0))
    top = Quantity(value=top_speed, unit="rad/s")
    mechanics = structs.replace(model.bench.mechanics, top_speed=top)
    bench = structs.replace(model.bench, mechanics=mechanics)
    return design_test(structs.replace(model, bench=bench), POSSIBLE)


def played(test: DesignTest, design: Design) -> PlayedTest:
    controller = CandidateControllers(test.model, test.spec)(design)
    return PlayedTest(test, test.judge(controller), False, None)


def free_prefilter(frequency: float) -> Design:
    test = turning(1000.0)
    scales = design_scales(test.model, test.spec, longest_step_of(test.scenario), 0.4)
    design = PI_CASCADE.design(scales, PI_CASCADE.values(PI_CASCADE.starts[0]))
    return structs.replace(design, prefilter=PrefilterDesign(frequency, 0.9))


@pytest.mark.parametrize("share", [1.01, 0.7, 0.05])
def test_a_slower_prefilter_keeps_the_top_speed(
    share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(design_trial, "DRAWN", 0)
    design = free_prefilter(30.0)
    fast = played(turning(1000.0), design)
    assert not fast.overspeed
    speed = float(fast.verdict.speeds.max())
    test = turning(share * speed)
    controllers = CandidateControllers(test.model, test.spec)
    tests = search_tests(test)
    search = automatic_design._Search(test, tests, None, controllers, print)  # type: ignore[arg-type]
    found = search.slower_prefilter(Candidate(design, np.zeros(9), (fast.verdict,)))
    assert (found is None) == (share > 1.0)
    if found is not None:
        kept = played(test, found)
        # another plant than the three fastest ones may be a little faster now
        assert kept.verdict.speeds.max() == pytest.approx(share * speed, rel=0.1)
        assert "above mechanics.top_speed" in played(test, design).overspeed


@pytest.mark.accept
def test_a_search_keeps_the_top_speed_if_the_slower_prefilter_meets_the_specification(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(design_trial, "DRAWN", 4)
    monkeypatch.setattr(design_trial, "OTHERS", 2)
    monkeypatch.setattr(automatic_design, "FAMILIES", (replace(PI_CASCADE, candidates=12),))
    free = design_automatically(turning(1000.0)).design
    speed = float(played(turning(1000.0), free).verdict.speeds.max())
    for share, kept in ((0.9, True), (0.2, False)):
        test = turning(share * speed)
        design = design_automatically(test).design
        one = played(test, design)
        assert one.all_met
        assert (design == free) == (not kept)
        assert ("above mechanics.top_speed" in one.overspeed) == (not kept)
