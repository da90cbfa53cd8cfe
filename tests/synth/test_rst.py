"""The RST of order 5 on the clutch: stable, an integrator in it, its response as said, and no straw
man."""

from __future__ import annotations

import sys
from functools import cache

import msgspec
import numpy as np
import pytest

from frictool.adapters.model_polytope import polytope
from frictool.documents.design import Design, Domain
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import PlantWeights, template
from frictool.plant.linear_axis import linear_axis
from frictool.synth.realisation import stored_forms
from frictool.synth.rst import PlacementRule, _PlacementSearch, rst
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem
from frictool.verify.speed_loop import check_loop
from studies.rigs.clutch_model import ROOT, clutch_model


def _problem(domain: Domain = "discrete", delay: int = 1, **changes: object) -> SynthesisProblem:
    design = load(ROOT / "configs/clutch/designs/rst.yaml", Design)
    design = msgspec.structs.replace(design, **{"domain": domain} | changes)
    model = clutch_model()
    weights = PlantWeights(template(20.0, 0.5, 2.0 / 63.0), 0.1, 0.05)
    return SynthesisProblem(
        polytope(model),
        3e-3,
        1e-3,
        delay,
        weights,
        design,
        model,
        load(ROOT / "configs/clutch/spec.yaml", Spec),
    )


@cache
def _found() -> ControllerCandidate:
    with pytest.MonkeyPatch.context() as patch:  # a shorter refinement than the product's
        patch.setattr(sys.modules["frictool.synth.rst"], "FREQUENCIES", 6)
        patch.setattr(sys.modules["frictool.synth.rst"], "STARTS", 1)
        return rst(_problem())


def test_order_integrator_and_stored_forms() -> None:
    k = _found().controller
    assert k.order == 5
    assert k.a[0, 0] == 1.0
    assert stored_forms(k).discrete.a[0][0] == 1.0
    assert _found().gamma is None


def test_the_margin_in_the_note_is_the_sampled_loop_s_own() -> None:
    problem, (note, *_) = _problem(), _found().notes
    worst = min(
        check_loop(_found().controller, point.rates, problem.lag, 1).modulus_margin
        for point in problem.box.vertices
    )
    assert f"modulus margin {worst:.3f}" in note
    assert worst > 0.49


def test_tuned_better_than_the_rule_s_textbook_numbers() -> None:
    """Dominant poles that just meet the response time with damping 0.7, the others twenty times
    further out."""
    tuning = _PlacementSearch(_problem())
    textbook = tuning.trial(PlacementRule(2.0 * tuning.slowest, 0.7, 20.0))
    assert textbook is not None
    best = tuning.trial(PlacementRule(*_rule()))
    assert best is not None
    assert tuning.merit(best) > tuning.merit(textbook)


def _rule() -> tuple[float, float, float]:
    """Return the numbers of the rule that the note prints, to its digits."""
    words = _found().notes[0].split()
    frequency, damping, auxiliary = float(words[4]), float(words[8].rstrip(",")), float(words[12])
    return frequency, damping, auxiliary / frequency


@pytest.mark.parametrize(("domain", "delay"), [("discrete", 0), ("discrete", 2), ("continuous", 1)])
def test_one_trial_in_each_domain_and_delay(domain: Domain, delay: int) -> None:
    """Nominal poles are placed exactly, so that the nominal loop is stable whenever the trial is
    given."""
    tuning = _PlacementSearch(_problem(domain, delay))
    trial = tuning.trial(PlacementRule(2.0 * tuning.slowest, 0.8, 20.0))
    assert trial is not None
    assert trial.controller.order == 5
    assert trial.controller.period == (1e-3 if domain == "discrete" else 0.0)
    assert 0.0 < trial.margin < 1.0


def test_the_step_response_is_the_loop_s() -> None:
    """Against a slow simulation of the same loop, difference equation by difference equation."""
    problem = _problem(prefilter=None)
    tuning = _PlacementSearch(problem)
    trial = tuning.trial(PlacementRule(2.0 * tuning.slowest, 0.8, 20.0))
    assert trial is not None
    k, rates, x, drive = trial.controller, problem.box.centre.rates, np.zeros(5), 0.0
    axis, state, positions = linear_axis(rates, problem.lag, 1e-3).system, np.zeros(3), []
    for _ in range(660):
        positions.append(-state[2])
        eta = 1.0 + state[2]
        now = float((k.c @ x + k.d[0] * eta)[0])
        x = k.a @ x + k.b[:, 0] * eta
        state = (
            axis.a @ state + axis.b[:, 0] * drive
        )  # the drive of the sample before: one sample of delay
        drive = now
    overshoot = 100.0 * (max(positions) - 1.0)
    assert trial.overshoot == pytest.approx(overshoot, rel=1e-6)
    assert trial.response_time == pytest.approx(
        (np.flatnonzero(np.abs(np.array(positions) - 1.0) > 0.05)[-1] + 1) * 1e-3
    )


def test_what_it_cannot_do_is_refused() -> None:
    with pytest.raises(NoSolutionError, match="order 3 is below the order 4 of the plant"):
        rst(_problem(order=3))
    speed = load(ROOT / "configs/clutch/designs/speed.yaml", Design)
    with pytest.raises(ValueError, match="rst belongs to structure position"):
        msgspec.structs.replace(speed, method="rst", recentring=1.1)
