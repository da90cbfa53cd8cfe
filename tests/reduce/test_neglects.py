"""Each step neglects exactly the effects that it states."""

from __future__ import annotations

import msgspec

from frictool.documents.mechanism import FrictionOf, Link, Mechanism, Spring
from frictool.documents.quantity import Quantity
from frictool.reduce.final_step import final
from frictool.reduce.reduction_chain import ReductionChain, chain
from frictool.reduce.step_report import StepFigure
from frictool.reduce.text_view import _figure
from tests.support.small_mechanisms import mechanism, rotor, screw

Q = Quantity


def _friction(law: str, velocity: float, **more: Quantity) -> FrictionOf:
    falling = {
        "coulomb": Q(0.1, unit="N m"),
        "breakaway": Q(0.2, unit="N m"),
        "viscous": Q(0.0, unit="N m s/rad"),
    }
    return FrictionOf(
        "shaft", law, {**falling, "stribeck_velocity": Q(velocity, unit="rad/s"), **more}
    )


def packed(sprung: bool) -> Mechanism:
    """A shaft in a packing with bristles and in a seal, on a spring or not."""
    bristles = {"stiffness": Q(1e3, unit="N m/rad"), "damping": Q(1.0, unit="N m s/rad")}
    links: dict[str, Link] = {
        "packing": _friction("lugre", 0.1, **bristles),
        "seal": _friction("stribeck", 0.2),
    }
    if sprung:
        links["spring"] = Spring(("shaft", "ground"), stiffness=Q(0.01, unit="N m/rad"))
    return mechanism({"shaft": rotor(1e-3)}, links, "shaft", "shaft", travel=(-1.0, 1.0))


def _neglected(found: ReductionChain, step: str) -> str:
    return next(one.report.neglects for one in found.steps if one.report.step == step)


def test_bristles_are_named_where_they_are_left_out() -> None:
    sprung, alone = chain(packed(True), None), chain(packed(False), None)
    assert "presliding and memory of packing (lugre)" in _neglected(sprung, "resisting curve")
    assert "presliding" not in final(sprung, "rotary").neglects
    assert _neglected(alone, "resisting curve") == "nothing"
    assert "presliding and memory of packing (lugre)" in final(alone, "rotary").neglects


def test_two_stribeck_velocities_that_become_one_are_told() -> None:
    assert "2 Stribeck velocities" in final(chain(packed(True), None), "rotary").neglects
    whole = packed(False)
    one = msgspec.structs.replace(whole, links={"seal": whole.links["seal"]})
    assert final(chain(one, None), "rotary").neglects == "nothing"


def test_curves_that_losses_made_are_no_absence_of_a_load() -> None:
    told = next(
        step.report
        for step in chain(screw(0.3), None).steps
        if step.report.step == "resisting curve"
    )
    assert told.did == "the loads are already a curve for each direction"


def test_no_zero_has_a_sign() -> None:
    assert _figure(StepFigure("margin", -0.0, "N m")) == "margin 0 N m"
