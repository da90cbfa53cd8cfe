"""Report of the last step of a reduction, the step to one inertia."""

from __future__ import annotations

from frictool.documents.mechanism import FrictionOf
from frictool.documents.quantity import Axis, si_unit
from frictool.reduce.backlash import steepest
from frictool.reduce.one_inertia import DirectionFriction, OneInertia
from frictool.reduce.reduction_chain import ReductionChain
from frictool.reduce.resistance_step import neglected_memory
from frictool.reduce.step_report import StepFigure, StepReport


def final(chain: ReductionChain, axis: Axis) -> StepReport:
    """Return the report of the last step: error of the polynomials, and neglected effects."""
    one = chain.one
    effort, position, inertia = (si_unit(name, axis) for name in ("effort", "position", "inertia"))
    figures = [StepFigure("inertia", one.inertia, inertia)]
    notes, neglects = [], []
    predicted = 0.0
    for name, side in (("forward", one.forward), ("backward", one.backward)):
        degree = len(side.coulomb.coefficients) - 1
        error = side.coulomb.error
        if degree:
            figures.append(
                StepFigure(f"polynomial {name} of degree {degree}: worst error", error, effort)
            )
            predicted = max(predicted, side.misses)
    if not (one.forward.flat and one.backward.flat):
        neglects.append("error of the polynomials")
    neglects += neglected_memory(chain.last, chain.last.links)
    velocities = {link.parameters["stribeck_velocity"].value for link in _stribeck(chain)}
    if len(velocities) > 1:
        neglects.append(f"difference of {len(velocities)} Stribeck velocities")
    if one.play.width > 0.0:
        figures += _of_play(one, inertia, effort, position)
        neglects.append("masses behind the backlash")
        notes.append(
            f"the position of {', '.join(one.play.behind)} within the backlash is not observable: "
            "no sensor is behind "
            f"{', '.join(link.name for link in one.play.chain)}"
        )
        if len(one.play.chain) > 1:
            notes.append(
                f"{len(one.play.chain)} backlashes in a chain open one after another; "
                "the model opens them together"
            )
    if chain.kept:
        notes.append(
            f"{', '.join(chain.kept)} stays compliant: model.yaml lists the resonances, and "
            "--reduced writes the mechanism"
        )
        neglects.append("the twist of the links that stay compliant")
    did = "one inertia, C_r(theta, sign) by polynomials, one backlash"
    return StepReport(
        "one inertia",
        did,
        ", ".join(neglects) or "nothing",
        predicted,
        "the mean friction",
        tuple(figures),
        tuple(notes),
    )


def _stribeck(chain: ReductionChain) -> list[FrictionOf]:
    links = chain.last.links.values()
    return [
        link
        for link in links
        if isinstance(link, FrictionOf) and "stribeck_velocity" in link.parameters
    ]


def _of_play(one: OneInertia, inertia: str, effort: str, position: str) -> list[StepFigure]:
    def misplaced(side: DirectionFriction) -> float:
        return 0.5 * one.play.width * steepest(one.positions, side.curve)

    return [
        StepFigure("inertia inside the backlash", one.inner, inertia),
        StepFigure("share of the inertia inside the backlash", one.inner / one.inertia, ""),
        StepFigure("backlash", one.play.width, position),
        StepFigure("friction inside the backlash", one.inside, effort),
        StepFigure(
            "largest error of friction if the position is wrong by half the backlash",
            max(map(misplaced, (one.forward, one.backward))),
            effort,
        ),
    ]
