"""Output of `reduce` as text: one row for each step with its two errors, then the model."""

from __future__ import annotations

from frictool.documents.laws import Load
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.documents.resonances import Oscillation
from frictool.presentation.sections import aligned
from frictool.reduce.loop_comparison import LoopComparison
from frictool.reduce.reduction_chain import ReductionChain, ReductionStep
from frictool.reduce.simulation_check import SimulationCheck
from frictool.reduce.step_report import StepFigure, StepReport

HEADING = ("step", "blocks", "neglects", "error expected", "measured", "of distance")


def lines(
    chain: ReductionChain,
    checked: SimulationCheck,
    model: Model,
    loop: LoopComparison | None = None,
) -> list[str]:
    """Return the lines of the whole report."""
    unit = si_unit("position", model.axis)
    rows = [
        HEADING,
        *(
            _row(report, len(step.mechanism.blocks), unit)
            for step, report in zip(chain.steps, checked.reports, strict=False)
        ),
    ]
    rows.append(_row(checked.reports[-1], 1, unit))
    output = [
        f"{chain.whole.name}: {len(chain.whole.blocks)} blocks and "
        f"{len(chain.whole.links)} links to one inertia",
        "",
        *aligned(rows),
        "",
    ]
    for report in checked.reports:
        output += [
            f"{report.step}: {report.did}",
            *(f"  {_figure(one)}" for one in report.figures),
            *(f"  {note}" for note in report.notes),
        ]
    if chain.play:
        output += ["backlash:", *(f"  {_figure(one)}" for one in chain.play)]
    output += [*_model(model), "", checked.verdict]
    return output if loop is None else [*output, "", *_in_loop(loop, unit)]


def unfinished(name: str, steps: tuple[ReductionStep, ...]) -> list[str]:
    """Return lines on the completed steps of a reduction that failed before its simulation."""
    rows = [HEADING, *(_row(step.report, len(step.mechanism.blocks), "") for step in steps)]
    return [f"{name}: stopped after {len(steps)} steps", "", *aligned(rows)]


def _in_loop(loop: LoopComparison, unit: str) -> list[str]:
    heading = (
        "step at",
        "from",
        "to",
        "apart at most",
        "at the end",
        "response whole",
        "response reduced",
    )
    rows = [
        (
            f"{one.time:g} s",
            f"{one.origin:.4g}",
            f"{one.target:.4g} {unit}",
            f"{one.distance:.3g} {unit}",
            f"{one.at_the_end:.3g} {unit}",
            f"{one.whole_s:.4g} s",
            f"{one.reduced_s:.4g} s",
        )
        for one in loop.steps
    ]
    verdict = "in the loop: both agree" if loop.refused is None else f"in the loop: {loop.refused}"
    return [*aligned([heading, *rows]), verdict]


def _row(report: StepReport, blocks: int, unit: str) -> tuple[str, ...]:
    expected = "0" if report.predicted == 0.0 else f"{report.predicted:.2g} of {report.of}"
    if report.predicted > 0.0 and report.covered is not None:
        expected += f", in {report.covered}"
    if report.measured is None:
        return (report.step, str(blocks), report.neglects, expected, "–", "–")
    return (
        report.step,
        str(blocks),
        report.neglects,
        expected,
        f"{report.measured.distance:.3g} {unit}",
        f"{100.0 * report.measured.share:.2g} %",
    )


def _figure(one: StepFigure) -> str:
    return f"{one.name} {one.value + 0.0:.5g}{f' {one.unit}' if one.unit else ''}"


def _model(model: Model) -> list[str]:
    output = ["one inertia:"]
    for name in ("inertia", "viscous", "coulomb", "breakaway", "offset", "stribeck_velocity"):
        one = getattr(model.parameters, name)
        if one is None or (one.value == 0.0 and one.low is None):
            continue
        interval = "" if one.low is None else f" ({one.interval[0]:.4g} to {one.interval[1]:.4g})"
        output.append(f"  {name} {one.value:.5g}{interval} {one.unit}")
    backward = model.laws.backward if model.laws is not None else None
    if backward is not None and backward.coulomb is not None and backward.breakaway is not None:
        output.append(
            f"  backward: coulomb {backward.coulomb.value:.5g}, "
            f"breakaway {backward.breakaway.value:.5g} {backward.coulomb.unit}"
        )
    if model.laws is not None and model.laws.load is not None:
        output += [f"  load in addition to friction: {one}" for one in _load(model.laws.load)]
    if model.resonances is not None:
        for kind, roots in (("pole", model.resonances.poles), ("zero", model.resonances.zeros)):
            output += [
                f"  resonance, pair of {kind}s at {one.rad_s:.5g} rad/s, "
                f"damping {one.damping:.4g}{_between(one)}"
                for one in roots
            ]
    return output


def _load(load: Load) -> list[str]:
    terms = []
    if load.stiffness is not None:
        terms.append(f"{load.stiffness.value:.5g} {load.stiffness.unit} x")
    if load.gravity is not None:
        terms.append(
            f"{load.gravity.sine.value:.5g} sin x "
            f"{load.gravity.cosine.value:+.5g} cos x {load.gravity.sine.unit}"
        )
    for one in load.ripples:
        angle = f"2 pi x {one.cycles:.6g} / ({one.per.value:.6g} {one.per.unit})"
        terms.append(
            f"{one.sine.value:.5g} sin {one.cosine.value:+.5g} cos of {angle}, {one.sine.unit}"
        )
    return terms


def _between(one: Oscillation) -> str:
    return (
        ""
        if one.interval_rad_s is None
        else f" ({one.interval_rad_s[0]:.5g} to {one.interval_rad_s[1]:.5g} rad/s)"
    )
