"""Picture of the README: a measured record, its model, and the verdict on a controller.

    python -m studies.first_page DATA_EMPS.mat docs/first_page.svg

`make -C configs/emps picture` runs this command.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from frictool.documents import load
from frictool.documents.model import Model
from frictool.identify import IdentificationRequest, identify
from frictool.identify.from_logs import IdentifiedModel
from frictool.identify.model_page.evidence import sliding_records, slip_samples
from frictool.identify.model_page.friction_panels import friction_panels
from frictool.identify.validate import Validation, validate
from frictool.logs import read_log
from frictool.presentation.colours import MUTED
from frictool.presentation.svg import PAGE, drawing, render_compact
from frictool.report import judge
from frictool.report.requirement import Requirement, Verdict
from frictool.simulate import simulate
from frictool.synth import synthesise

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RIG = Path(__file__).parents[1] / "configs/emps"
MEASURED, SIMULATED, MET, MISSED = "#8fb2dc", "#12365f", "#2f7d4f", "#b3261e"
SIZE = (11.0, 3.3)  # inches
EVERY = 25  # samples between the points of a drawn curve
MM = 1e3
WORDS = {"response_time_95": "response 95 %", "modulus_margin": "modulus margin"}


def main(recorded: Path, target: Path) -> None:
    """Identify the model of a record, design and judge a controller, and write the picture."""
    bench, spec = load(RIG / "bench.yaml"), load(RIG / "spec.yaml")
    record = read_log(recorded, bench)
    identified = identify([record], bench, IdentificationRequest())
    model = identified.model
    controller = synthesise(
        model, spec, load(RIG / "designs/speed.yaml"), vertices_only=True
    ).controller
    run = simulate(model, controller, load(RIG / "scenarios/steps.yaml"))
    verdict = judge(spec, [run], controller)
    with drawing("first page", {**PAGE, "font.size": 9.0}):
        figure = Figure(figsize=SIZE)
        grid = figure.add_gridspec(2, 3, height_ratios=(2.4, 1.0), width_ratios=(1.15, 1.0, 1.0))
        figure.subplots_adjust(
            left=0.06, right=0.99, bottom=0.15, top=0.89, wspace=0.27, hspace=0.12
        )
        above = figure.add_subplot(grid[0, 0])
        _motion(above, figure.add_subplot(grid[1, 0], sharex=above), validate(model, record))
        _friction(figure.add_subplot(grid[:, 1]), identified)
        _verdict(figure.add_subplot(grid[:, 2]), verdict, len(run.axes))
        text = render_compact(figure, "measured and simulated position, friction, verdict")
    target.write_text(text + "\n", encoding="utf-8")


def _motion(above: Axes, below: Axes, validation: Validation) -> None:
    """Draw measured and simulated position, and their difference, over time."""
    time = validation.time[::EVERY]
    measured, simulated = (
        MM * one["position"][::EVERY] for one in (validation.measured, validation.simulated)
    )
    above.plot(time, measured, color=MEASURED, linewidth=4.0, label="measured")
    above.plot(time, simulated, color=SIMULATED, linewidth=1.0, label="simulated from the drive")
    above.set(ylabel="position [mm]", title="The model replays 25 s without feedback")
    above.tick_params(labelbottom=False)
    above.legend(loc="upper right", frameon=False, fontsize=8)
    above.set_ylim(top=1.45 * float(measured.max()))
    below.plot(time, simulated - measured, color=SIMULATED, linewidth=1.0)
    below.set(xlabel="time [s]", ylabel="error [mm]")


def _friction(axes: Axes, identified: IdentifiedModel) -> None:
    """Draw the friction over the speed with its band."""
    model: Model = identified.model
    panel, *_ = friction_panels(model, slip_samples(model, sliding_records(identified)), None)
    panel.draw(axes)
    axes.set_title("Friction over speed, with its 95 % band")


def _verdict(axes: Axes, verdict: Verdict, plants: int) -> None:
    """Draw each requirement's figure as a share of its limit."""
    axes.set_title(f"Verdict on {plants} plants: {'PASS' if verdict.passed else 'FAIL'}")
    rows = verdict.requirements
    for place, one in zip(np.arange(len(rows))[::-1], rows, strict=True):
        colour = MET if one.met else MISSED
        axes.barh(place, _share(one), height=0.34, color=colour)
        name = WORDS.get(one.name, one.name.replace("_", " "))
        words = f"{name}: {one.value_text} {one.sign} {one.limit_text}"
        axes.text(0.0, place + 0.28, words, color=colour)
    axes.axvline(1.0, color=MUTED, linewidth=1.2)
    axes.set(xlim=(0.0, 1.08), ylim=(-0.5, len(rows) - 0.2), xlabel="share of the limit")
    axes.set_yticks([])


def _share(one: Requirement) -> float:
    """Return value/limit for an upper limit, limit/value for a lower one."""
    value = 0.0 if one.value is None else one.value
    return one.limit / value if one.relation == ">=" else value / one.limit


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
