"""Output of `reduce` as JSON, in SI."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.reduce.loop_comparison import LoopComparison
from frictool.reduce.reduction_chain import ReductionChain
from frictool.reduce.simulation_check import SimulationCheck
from frictool.reduce.step_report import StepFigure, StepReport


def json_view(
    chain: ReductionChain,
    checked: SimulationCheck,
    model: Model,
    loop: LoopComparison | None = None,
) -> dict[str, Any]:
    """Return the result of a reduction as a JSON object."""
    one = chain.one
    sizes = [len(step.mechanism.blocks) for step in chain.steps] + [1]
    return {
        "name": chain.whole.name,
        "axis": model.axis,
        "blocks": len(chain.whole.blocks),
        "source": chain.source,
        "sensor": chain.sensor,
        "position_unit": si_unit("position", model.axis),
        "steps": [
            _step(report, blocks) for report, blocks in zip(checked.reports, sizes, strict=True)
        ],
        "backlash": [_figure(figure) for figure in chain.play],
        "curve": {
            "position": one.positions.tolist(),
            "forward": one.forward.curve.tolist(),
            "backward": one.backward.curve.tolist(),
            "breakaway_forward": one.forward.breakaway.tolist(),
            "breakaway_backward": one.backward.breakaway.tolist(),
        },
        "kept": list(chain.kept),
        "tolerance": checked.tolerance,
        "runs": checked.runs,
        "reduced": checked.refused is None,
        "verdict": checked.verdict,
        "in_loop": None
        if loop is None
        else {
            "agree": loop.refused is None,
            "refused": loop.refused,
            "steps": [asdict(s) for s in loop.steps],
        },
    }


def _step(report: StepReport, blocks: int) -> dict[str, Any]:
    measured = report.measured
    return {
        "step": report.step,
        "blocks": blocks,
        "did": report.did,
        "neglects": report.neglects,
        "expected_error": report.predicted,
        "of": report.of,
        "covered_by": report.covered,
        "measured": None
        if measured is None
        else {
            "distance": measured.distance,
            "way": measured.travelled,
            "share": measured.share,
            "run": measured.where,
            "to_whole": measured.whole,
        },
        "figures": [_figure(figure) for figure in report.figures],
        "notes": list(report.notes),
    }


def _figure(figure: StepFigure) -> dict[str, Any]:
    return {"name": figure.name, "value": figure.value, "unit": figure.unit}
