"""Verdicts on an axis that rings after it stops, is late, or has a model of one side only."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest
from msgspec.structs import replace

from frictool.adapters.resonance_filter import resonance_filters
from frictool.adapters.two_inertias import TwoInertias, two_inertias
from frictool.campaign import doubts
from frictool.campaign.design_trial import DesignTest, design_test
from frictool.campaign.doubts import doubts_of, slower_factor
from frictool.campaign.draws.factor_space import space_of
from frictool.campaign.draws.spread_factors import spread_factors
from frictool.campaign.trials.campaign_warnings import doubt_of, remarks_of
from frictool.campaign.trials.trial_player import CampaignSetting, TrialPlayer
from frictool.campaign.views.played_view import played_json, played_lines
from frictool.documents.controller import Controller, Margins
from frictool.documents.mechanism import Coupling
from frictool.documents.missing_effects import missing_effects
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.documents.resonances import Oscillation, Resonances, Ringing
from frictool.documents.valid_side import ValidSide
from frictool.report.verdict import judge
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.verify.model_check import check_model
from frictool.verify.ringing_loop import lowest_tolerated, ringing_check, unknown_resonance
from frictool.verify.vertices import vertex_points
from studies.rigs.campaign_rig import trial
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario
from studies.rigs.verified_controller import truthful
from tests.support.provenance import HERE

SPEC = clutch_spec(rest=None, response_time_95_s=None, oscillations=None)
FAST, SLOW = 6000.0, 60.0  # rad/s, far above the loop and within it


def ringing_model(rad_s: float) -> Model:
    return replace(clutch_model(), ringing=Ringing(rad_s, 0.03))


def player(setting: CampaignSetting) -> TrialPlayer:
    return TrialPlayer(setting, space_of(spread_factors(setting.scenario)), seed=3)


@pytest.fixture(scope="module")
def loop() -> Controller:
    """Return a controller of the clutch that has a margin of 0.3 at its two vertices."""
    made = truthful(controller())
    return replace(made, verified=replace(made.verified, modulus_margin_specified=0.3))


def test_the_loop_tolerates_resonances_above_the_stated_frequency_only(loop: Controller) -> None:
    above = lowest_tolerated(loop)
    assert above is not None
    points = vertex_points(loop)

    def margin(hertz: float) -> float:
        rings = Ringing(2.0 * math.pi * hertz, 0.02, in_motion=True)
        return ringing_check(loop, points, rings).modulus_margin

    assert all(margin(factor * above) > 0.0 for factor in (1.0, 1.3, 2.0))
    assert margin(above / 2.0**0.25) == 0.0
    assert f"below {above:.3g} Hz" in unknown_resonance(loop)[0]
    assert unknown_resonance(replace(loop, ringing=Ringing(FAST, 0.03))) == []


@pytest.fixture(scope="module")
def short() -> DesignTest:
    return design_test(clutch_model(), SPEC, scenario(seconds=0.4))


@pytest.mark.parametrize("plant", [*two_inertias(Ringing(80.0, 0.04))], ids=str)
def test_every_plant_has_the_measured_oscillation(plant: TwoInertias) -> None:
    """The mechanism oscillates at 80 rad/s, and its transfer function has the poles and zeros."""
    model = clutch_model()
    made = plant.mechanism(model)
    blocks = [made.blocks[name].inertia for name in ("motor", "load")]
    motor, load = (one.value for one in blocks if one is not None)
    link = made.links["drive_train"]
    assert isinstance(link, Coupling)
    assert link.compliance is not None
    assert link.compliance.damping is not None
    k, c = link.compliance.stiffness.value, link.compliance.damping.value
    total = model.parameters.inertia.value
    assert motor + load == pytest.approx(total)
    assert load / motor == pytest.approx(plant.ratio)
    encoder = motor if plant.encoder == "motor" else load
    free = motor * load / total
    moving = encoder if plant.rests else free
    root = np.roots([moving, c, k])[0]
    assert abs(root) == pytest.approx(80.0)
    assert -root.real / abs(root) == pytest.approx(0.04)
    s = 1j * np.geomspace(5.0, 2000.0, 30)
    link_impedance = c * s + k
    effort = link_impedance + (load * s**2 if plant.encoder == "motor" else 0.0)
    expected = effort / (free * total * s**2 + link_impedance * total) * total
    (filtered,) = resonance_filters(plant.resonances())
    a, b, c_row, d = filtered.a, filtered.b, filtered.c, filtered.d
    found = [(c_row @ np.linalg.solve(one * np.eye(len(a)) - a, b) + d)[0, 0] for one in s]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_slower_loop_tolerates_the_ringing(loop: Controller) -> None:
    """The named factor suffices for a faster oscillation of the axis; half of it does not."""
    points = vertex_points(loop)
    rings = Ringing(300.0, 0.03, (280.0, 320.0))
    check = ringing_check(loop, points, rings)
    assert not check.shown
    assert check.slower is not None
    assert ringing_check(loop, points, rings.scaled(check.slower)).shown
    assert not ringing_check(loop, points, rings.scaled(0.5 * check.slower)).shown
    assert f"slow the loop by a factor of {check.slower:g}" in check.doubt
    assert len(check.doubt) <= 170


def test_a_ringing_axis_decides_the_verdict(
    loop: Controller, short: DesignTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        doubts, "two_inertias", lambda one: [TwoInertias(one, 1.0, "load", rests=True)]
    )
    assert doubts_of(clutch_model(), loop, short).lines() == []
    fine = doubts_of(ringing_model(FAST), loop, short)
    assert not fine.reasons
    assert "meet the specification" in fine.notes[0]
    (unstable,) = doubts_of(ringing_model(SLOW), loop, None).reasons
    assert "9.55 Hz" in unstable
    strict = limited_test(short, overshoot_percent=1e-3)
    (missed,) = doubts_of(ringing_model(FAST), loop, strict).reasons
    assert "overshoot is not met" in missed
    known = replace(
        ringing_model(SLOW), resonances=Resonances((Oscillation(SLOW, 0.03),), ("belt",))
    )  # the loop is verified with these resonances
    assert not doubts_of(known, loop, None).reasons


def limited_test(test: DesignTest, **limits: float) -> DesignTest:
    """Return the test with other limits."""
    return design_test(test.model, replace(SPEC, **limits), test.scenario)


@pytest.mark.parametrize(
    ("side", "place", "valid"),
    [("above", 4.0, True), ("above", 7.0, False), ("below", 41.0, True), ("below", 39.0, False)],
)
def test_the_steps_must_stay_on_the_valid_side(
    loop: Controller, short: DesignTest, side: Literal["above", "below"], place: float, valid: bool
) -> None:
    """The steps reach from 5 to 40 rad."""
    of = Quantity(place, place - 0.5, place + 0.5, "rad")
    model = replace(clutch_model(), valid_side=ValidSide(side, of))
    found = doubts_of(model, loop, short)
    assert (not found.reasons) == valid
    assert side in found.lines()[0]
    assert not doubts_of(model, loop, None).reasons  # the linear loop contains no load


@pytest.mark.parametrize(("place", "valid"), [(3.0, True), (7.0, False)])
def test_simulated_verdicts_are_undecided_beyond_the_valid_side(
    loop: Controller, place: float, valid: bool
) -> None:
    """The steps reach from 5 to 40 rad; `report` and `campaign` judge them on a sided model."""
    of = Quantity(place, place - 0.5, place + 0.5, "rad")
    model = replace(clutch_model(), valid_side=ValidSide("above", of))
    log = simulate_closed_loop(model, loop, scenario(seconds=0.4), HERE)
    loose = clutch_spec(rest=None, response_time_95_s=None, oscillations=None, modulus_margin=None)
    log.metadata["log"].pop("missing_effects")
    verdict = judge(loose, [log], loop)
    assert not any(verdict.meets) or valid
    del log.metadata["log"]["valid_side"]
    everywhere = judge(loose, [log], loop).requirements
    assert any(one.met for one in everywhere)
    for one, plain in zip(verdict.requirements, everywhere, strict=True):
        assert one.met == (plain.met if valid else plain.met and None)
    setting = trial().setting._replace(plant=model, spec=loose)
    doubt = doubt_of(player(setting))
    assert (doubt == "") == valid
    assert valid or "above 7 rad" in doubt


@pytest.mark.parametrize(("high", "warned"), [(38.0, False), (36.0, True)])
def test_steps_far_beyond_the_logs_of_the_model_have_a_warning(
    loop: Controller, high: float, warned: bool
) -> None:
    """The steps reach from 5 to 40 rad, 6 % or 13 % of the logged range beyond it."""
    logged = Span(5.0, high, "rad")
    model = replace(clutch_model(), logged_positions=logged)
    log = simulate_closed_loop(model, loop, scenario(seconds=0.4), HERE)
    words = f"the model's logs only from 5 to {high:g} rad"
    assert any(words in one for one in log.warnings) == warned
    assert any(words in one for one in judge(SPEC, [log], loop).remarks) == warned
    del log.metadata["log"]["logged_positions"]  # as in a recorded log
    assert not any(words in one for one in judge(SPEC, [log], loop).remarks)
    known = replace(loop, logged_positions=logged)
    assert any(words in one for one in judge(SPEC, [log], known).remarks) == warned


def test_simulated_verdicts_contain_the_ringing_without_a_margin(loop: Controller) -> None:
    loose = clutch_spec(rest=None, response_time_95_s=None, oscillations=None, modulus_margin=None)
    log = simulate_closed_loop(clutch_model(), loop, scenario(seconds=0.4), HERE)
    for rad_s, met in ((FAST, True), (SLOW, None)):
        rung = replace(loop, ringing=Ringing(rad_s, 0.03))
        verdict = judge(loose, [log], rung)
        assert {one.met for one in verdict.requirements} <= {met, False}
        setting = trial().setting._replace(controller=rung, spec=loose)
        assert ("9.55 Hz" in doubt_of(player(setting))) == (met is None)


def test_an_undecided_test_is_no_pass(loop: Controller, short: DesignTest) -> None:
    loose = limited_test(short, overshoot_percent=50.0)
    verdict = loose.judge(loop, [0])
    headlines = [
        played_lines(verdict, loose.names, loose.about, "", decided=decided)[-1]
        for decided in (True, False)
    ]
    assert headlines[0].startswith("PASS")
    assert headlines[1].startswith("UNDECIDED")
    assert not played_json(verdict, loose.names, loose.about, decided=False)["passed"]


def test_verify_and_reports_state_the_ringing(loop: Controller) -> None:
    model = ringing_model(SLOW)
    check = check_model(loop, model)
    assert not check.holds
    assert check.ringing is not None
    assert check.ringing.modulus_margin == 0.0
    log = simulate_closed_loop(model, loop, scenario(seconds=0.2), HERE)
    words = f"after stops, the position rings at {SLOW / (2.0 * math.pi):.3g} Hz"
    assert any(words in one for one in judge(SPEC, [log], loop).remarks)
    rung = replace(loop, ringing=model.ringing)
    (margin,) = (
        one for one in judge(SPEC, [log], rung).requirements if one.key == "modulus_margin"
    )
    assert margin.met is None
    assert "9.55 Hz" in margin.reason
    setting = trial().setting._replace(plant=model)
    remarks = remarks_of(setting, space_of(spread_factors(setting.scenario)))
    assert any(words in one for one in remarks)


@pytest.mark.parametrize(("lag", "passes"), [(2e-3, True), (10e-3, False)])
def test_a_lag_that_the_bench_lacks_decides_the_verdict(
    loop: Controller, short: DesignTest, lag: float, passes: bool
) -> None:
    """The loop has a modulus margin of 0.3 without the lag."""
    late = Estimate(value=lag, low=0.9 * lag, high=lag, unit="s", source="identified")
    model = replace(clutch_model(), late_position=late)
    found = doubts_of(model, loop, with_model(short, model))
    assert bool(found.notes) == passes
    assert bool(found.reasons) != passes
    assert doubts_of(model, loop, None).reasons
    assert passes or "modulus margin is not met" in found.reasons[0]
    bounded = replace(loop, verified=replace(loop.verified, margins=Margins(0.01, delay_s=5e-3)))
    setting = trial().setting._replace(plant=model, controller=bounded)
    assert ("tolerates a delay of only 5 ms" in doubt_of(player(setting))) != passes
    log = simulate_closed_loop(model, bounded, scenario(seconds=0.2), HERE)
    judged = judge(SPEC, [log]).requirements
    assert any(one.met for one in judged) == passes
    assert passes or any("tolerates a delay of only 5 ms" in one.reason for one in judged)
    (told,) = missing_effects(model)
    assert f"{1e3 * lag:.3g} ms" in told


def test_the_search_needs_a_slower_loop(loop: Controller, short: DesignTest) -> None:
    assert slower_factor(loop, short) == 1.0  # the axis does not ring
    rings = with_model(short, ringing_model(300.0))
    factor = slower_factor(loop, rings)
    assert factor is not None
    assert factor > 1.0


def with_model(test: DesignTest, model: Model) -> DesignTest:
    """Return the test with another model."""
    return design_test(model, test.spec, test.scenario)
