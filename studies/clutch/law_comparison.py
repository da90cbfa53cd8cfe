"""Table of control laws of one rig, with compensation (5.1) and with use of friction (5.2).

    python -m studies.clutch.law_comparison SPEC BUILD [LAW...]

The logs are BUILD/LAW/run.mcap (make -C configs/clutch compare_laws; also in configs/emps); they
end with a hold of 15 s or more. The columns are

- response, overshoot, error: worst value over the steps, on the nominal plant
- limit cycle: largest limit cycle of the last hold on any plant
- cycling: number of plants with a limit cycle; with ?, number of plants that move during the hold
  without a certain limit cycle
- drive at rest: rms command over the last third of the hold, averaged over the plants
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from statistics import mean

import numpy as np

from frictool.documents.controller import Controller
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.logs.log import MAIN_TOPIC, Log
from frictool.logs.log_reader import read_log
from frictool.report.verdict import judge

HEADS = (
    "response ms",
    "overshoot %",
    "error counts",
    "cycle counts",
    "its period s",
    "cycling",
    "drive at rest",
)


@dataclass(frozen=True)
class Law:
    """Results of one law over all plants; positions in encoder counts, drive in A or V."""

    name: str
    response: float
    overshoot: float
    error: float
    amplitude: float  # of the largest limit cycle on any plant; 0 if no plant cycles
    period: float
    cycling: int
    untold: int  # plants that move during the hold without a certain limit cycle
    plants: int
    drive: float


def law(name: str, spec: Spec, controller: Controller, log: Log) -> Law:
    """Return the results of a law from its log."""
    step = controller.bench.encoder.resolution
    cycles, drives, own, untold = [(0.0, 0.0)], [], [], 0
    for item, holds in judge(spec, [log], controller).evidence:
        last = holds[-1].values
        if "limit_cycle_amplitude" in last:
            cycles.append((last["limit_cycle_amplitude"], last.get("limit_cycle_period", 0.0)))
        else:
            untold += 1
        drive = item.stream.signals["command"]
        drives.append(float(np.sqrt(np.mean(drive[-holds[-1].hold.of(drive).size // 3 :] ** 2))))
        if item.stream.topic == MAIN_TOPIC:
            own = [hold.values for hold in holds]
    worst = max(cycles)
    response, overshoot, error = (
        max(values.get(key, 0.0) for values in own)
        for key in ("response_time_95", "overshoot", "static_error")
    )
    count = sum(amplitude > 0.0 for amplitude, _ in cycles)
    return Law(
        name,
        response,
        overshoot,
        error / step,
        worst[0] / step,
        worst[1],
        count,
        untold,
        len(drives),
        mean(drives),
    )


def table(laws: list[Law], unit: str) -> list[str]:
    """Return the table with one line per law."""
    lines = [
        f"{'law':<26}"
        + "".join(f"{head:>15}" for head in HEADS[:-1])
        + f"{HEADS[-1] + ' ' + unit:>18}"
    ]
    for one in laws:
        response = "never" if math.isinf(one.response) else f"{1e3 * one.response:.0f}"
        cycle = (f"{one.amplitude:.4g}", f"{one.period:.3g}") if one.cycling else ("none", "-")
        figures = (
            response,
            f"{one.overshoot:.1f}",
            f"{one.error:.3g}",
            *cycle,
            f"{one.cycling} of {one.plants}" + (f", {one.untold} ?" if one.untold else ""),
        )
        lines.append(
            f"{one.name:<26}"
            + "".join(f"{figure:>15}" for figure in figures)
            + f"{one.drive:>18.3f}"
        )
    return lines


def main(arguments: list[str]) -> int:
    if len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    spec, build, found = load(Path(arguments[0]), Spec), Path(arguments[1]), []
    for name in arguments[2:]:
        controller = load(build / name / "controller.yaml", Controller)
        found.append(law(name, spec, controller, read_log(build / name / "run.mcap")))
    print("\n".join(table(found, "A" if spec.drive == "current" else "V")))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
