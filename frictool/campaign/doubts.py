"""Reasons why a controller that passes its test on a model may fail on the axis.

- The axis rings after it stops, but the model is rigid. The controller is then checked on nominal
  plants of two inertias that ring like the axis (verify/ringing_loop.py). The reason is dropped if
  these loops have the specified margin, and if the steps of the test meet the specification.
- The logs show a lag or delay that the bench does not state (`late_position`). The reason is
  dropped if the loops tolerate this delay, and if the steps of the test meet the specification on
  the nominal plant with this additional lag.
- The model is valid on one side of a position only, and the steps of the test leave this side.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from msgspec import structs

from frictool.adapters.two_inertias import two_inertias
from frictool.campaign.design_trial import DesignTest
from frictool.campaign.trials.controller_judge import ControllerJudge
from frictool.documents.controller import Controller
from frictool.documents.mechanism import Mechanism
from frictool.documents.metric_table import requirement_title
from frictool.documents.missing_effects import (
    intolerable_lag,
    undeclared_ringing,
    unstated_lag,
)
from frictool.documents.model import Model
from frictool.documents.resonances import Ringing
from frictool.documents.spec import Spec
from frictool.verify.ringing_loop import SLOWER, doubt_words, ringing_check
from frictool.verify.verification_view import ringing_line
from frictool.verify.vertices import vertex_points

Document = TypeVar("Document", Controller, Model)


@dataclass(frozen=True)
class Doubts:
    """Effects that a model lacks, and their consequence for a controller.

    - reasons: reasons why the controller may fail on the axis; without a reason, the verdict of the
      test is valid
    - notes: lines on effects that the controller tolerates
    """

    reasons: tuple[str, ...]
    notes: tuple[str, ...]

    def lines(self) -> list[str]:
        """Return one line for each note and for each reason."""
        return [*self.notes, *(f"undecided: {reason}" for reason in self.reasons)]


def doubts_of(model: Model, controller: Controller, test: DesignTest | None) -> Doubts:
    """Return reasons why a controller may fail on the axis, and effects that it tolerates.

    test: test that the controller passes on the model; None if no test was simulated.
    """
    found = []
    oscillation = undeclared_ringing(model)
    if oscillation is not None:
        found.append(_of_ringing(controller, oscillation, test))
    if model.late_position is not None:
        found.append(_of_late_position(model, controller, test))
    if model.valid_side is not None:
        found.append(_of_side(model, controller, test))
    return Doubts(
        tuple(reason for reason, _ in found if reason), tuple(note for _, note in found if note)
    )


def slower_factor(controller: Controller, test: DesignTest) -> float | None:
    """Return the factor by which a controller must be slower for an axis that rings.

    The factor is 1 if the axis does not ring. It is SLOWER[0] if the loop has the specified margin,
    but the steps of the test fail on a plant of two inertias. Otherwise, it is
    `RingingCheck.slower`.
    """
    oscillation = undeclared_ringing(test.model)
    if oscillation is None:
        return 1.0
    check = ringing_check(controller, vertex_points(controller), oscillation)
    if check.shown and _failed(controller, oscillation, test):
        return SLOWER[0]
    return check.slower


def _of_ringing(
    controller: Controller, oscillation: Ringing, test: DesignTest | None
) -> tuple[str, str]:
    check = ringing_check(controller, vertex_points(controller), oscillation)
    if check.doubt:
        return check.doubt, ""
    note = ringing_line(check)
    if test is None:
        return "", note
    if failed := _failed(controller, oscillation, test):
        return failed, ""
    return "", f"{note}; the steps meet the specification on these plants, too"


def _failed(controller: Controller, oscillation: Ringing, test: DesignTest) -> str:
    """Return the reason why a plant of two inertias fails in the steps; "" if none fails."""
    # a mechanism has no margin; `ringing_check` contains the margin
    spec = structs.replace(test.spec, modulus_margin=None)
    for plant in two_inertias(oscillation):
        if failure := _failure(test, spec, controller, plant.mechanism(test.model)):
            return doubt_words(plant, failure)
    return ""


def _failure(test: DesignTest, spec: Spec, controller: Controller, plant: Model | Mechanism) -> str:
    """Return a requirement that the loop with `plant` violates in the test; "" if it passes."""
    scenario = structs.replace(test.scenario, given={})
    judge = ControllerJudge(plant, scenario, spec, [{}])
    verdict = judge(controller)
    missed = (one.metric.name for one in verdict.requirements if not one.met)
    return next(
        (f"{requirement_title(name)} is not met" for name in missed),
        next(iter(verdict.failed.values()), ""),
    )


def _of_late_position(
    model: Model, controller: Controller, test: DesignTest | None
) -> tuple[str, str]:
    late = model.late_position
    assert late is not None
    if reason := intolerable_lag(late, controller):
        return reason, ""
    lag, longest = unstated_lag(late), late.interval[1]
    if test is None:
        return f"the logs show {lag}, which was not simulated; leave out --no-play", ""
    failure = _failure(test, test.spec, _slower(controller, longest), _slower(test.model, longest))
    return (f"with {lag}, as in the logs, {failure}", "") if failure else ("", f"passes with {lag}")


def _slower(document: Document, lag: float) -> Document:
    """Return the model or controller with a drive whose time constant is longer by `lag` [s]."""
    bench = document.bench
    time_constant = bench.actuator.loop_time_constant_s + lag
    actuator = structs.replace(bench.actuator, loop_time_constant_s=time_constant)
    return structs.replace(document, bench=structs.replace(bench, actuator=actuator))


def _of_side(model: Model, controller: Controller, test: DesignTest | None) -> tuple[str, str]:
    side = model.valid_side
    assert side is not None
    if test is not None:
        path = test.judge.reference_range(controller)
        if left := side.left_words(model.axis, *path, "steps"):
            return f"{left}; limit the steps to this side (--scenario), or log the other side", ""
    place = side.place(model.axis)
    return "", f"the model is valid {place} only; elsewhere, the logs show another load"
