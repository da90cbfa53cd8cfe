"""Loops of table 5.1 simulated by frictool, from the documents of configs/mass to the closed loop.

    python -m studies.table_5_1.product_loops configs/mass/build

prints the table of the logs in this folder (make -C configs/mass table_5_1).
"""

from __future__ import annotations

import math
import sys
from functools import cache
from pathlib import Path

import msgspec
import numpy as np

from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.logs.log_reader import read_log
from frictool.simulate.closed_loop import SimulationRequest, simulate_closed_loop
from frictool.synth.design import design_controller
from frictool.typing import Vector
from studies.table_5_1.published_figures import FIGURES, LOOPS, figures, missed
from studies.table_5_1.reference_loops import printed_step

RIG = Path(__file__).parents[2] / "configs/mass"
HERE = Provenance("a test", "0")


def model(name: str) -> Model:
    """Return the mass of a loop; the mass of 5.2.5 has a tenth of the friction."""
    return load(RIG / ("smooth.yaml" if name.startswith("smooth") else "model.yaml"), Model)


@cache
def controller(name: str) -> Controller:
    return design_controller(
        model(name), load(RIG / "spec.yaml", Spec), load(RIG / f"designs/{name}.yaml", Design), HERE
    )


def played(name: str, seconds: float, number: ProgramNumber = "double") -> Vector:
    """Return the positions (n,) [m] of a hold of `seconds`, one per sample.

    number: number format of the controller.
    """
    scenario = load(RIG / "step.yaml", Scenario)
    (step,) = scenario.steps
    scenario = msgspec.structs.replace(
        scenario, steps=(msgspec.structs.replace(step, duration_s=seconds),)
    )
    log = simulate_closed_loop(
        model(name), controller(name), scenario, HERE, request=SimulationRequest(number=number)
    )
    return np.asarray(log.streams[0].signals["position_true"])


def table(logs: dict[str, Vector]) -> tuple[list[str], bool]:
    """Return the lines of the table, and True if all published values are met.

    For each loop, a line of computed values is followed by the published values.
    """
    lines = [
        f"{'loop':<24}{'overshoot %':>14}{'response s':>14}{'static m':>14}{'cycle +- m':>14}"
        f"{'period s':>14}"
    ]
    met = True
    for name, positions in logs.items():
        found, printed = figures(positions), LOOPS[name].printed
        wrong = missed(found, printed)
        met = met and not wrong
        lines.append(f"{name:<24}" + "".join(f"{_shown(found[figure]):>14}" for figure in FIGURES))
        lines.append(
            f"{'  known':<24}"
            + "".join(f"{_known(one):>14}" for one in printed)
            + (f"  MISSED: {', '.join(wrong)}" if wrong else "")
        )
    farthest = float(np.max(np.abs(printed_step(600.0))))
    lines.append(
        f"{'(5.41) as printed':<24}  the mass is {farthest:g} m from where it rested, after 600 "
        "s: its branches are inverted"
    )
    return lines, met and farthest == 0.0


def _shown(value: float) -> str:
    return "never" if math.isinf(value) else "none" if math.isnan(value) else f"{value:.4g}"


def _known(text: str) -> str:
    return {"inf": "never", "nan": "none"}.get(text, text)


def main(folder: Path) -> int:
    logs = {
        name: np.asarray(read_log(folder / name / "run.mcap").main.signals["position_true"])
        for name in LOOPS
    }
    lines, met = table(logs)
    print("\n".join(lines))
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
