"""Comparison of control with an observer's velocity and with the encoder's difference quotient.

    python -m studies.clutch.observed_velocity SPEC BUILD LAW...

The laws of one rig run with both velocities on the same plants. The command reads
BUILD/LAW/{controller,observed}.yaml and BUILD/LAW/{run,observed}.mcap (make -C configs/clutch
velocity). The columns are

- response, overshoot, error: worst value over the steps, on the nominal plant
- meeting: number of plants that meet the specification
- cycling: number of plants with a limit cycle in the last hold
- speed: rms error of the controller's velocity, on the nominal and the worst plant
- jitter: rms change of the command from sample to sample, averaged over the plants
- margin: modulus margin of the linear loops at the worst vertex
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.logs.log import Log
from frictool.logs.log_reader import read_log
from frictool.report.hold_metrics import stream_metrics
from frictool.report.verdict import judge
from studies.clutch.law_comparison import law

HEADS = (
    "response ms",
    "overshoot %",
    "error counts",
    "meeting",
    "cycling",
    "speed",
    "worst speed",
    "jitter",
    "margin",
)
RUNS = {"(5.70)": ("controller.yaml", "run.mcap"), "observer": ("observed.yaml", "observed.mcap")}


def figures(spec: Spec, controller: Controller, log: Log) -> list[str]:
    """Return the table cells of one law with one velocity, in the order of HEADS."""
    own, verdict = law("", spec, controller, log), judge(spec, [log], controller)
    errors = [
        stream_metrics(spec, evidence)[0].get("velocity_error_rms", math.nan)
        for evidence, _ in verdict.evidence
    ]
    jitter = np.mean(
        [np.sqrt(np.mean(np.diff(stream.signals["command"]) ** 2)) for stream in log.streams]
    )
    return [
        "never" if math.isinf(own.response) else f"{1e3 * own.response:.0f}",
        f"{own.overshoot:.1f}",
        f"{own.error:.3g}",
        f"{sum(verdict.meets)} of {own.plants}",
        f"{own.cycling} of {own.plants}" + (f", {own.untold} ?" if own.untold else ""),
        f"{errors[0]:.2f}",
        f"{max(errors):.2f}",
        f"{jitter:.2f}",
        f"{min(vertex.modulus_margin for vertex in controller.verified.vertices):.3f}",
    ]


def main(arguments: list[str]) -> int:
    if len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    spec, folder = load(Path(arguments[0]), Spec), Path(arguments[1])
    print(f"{'law':<24}{'speed from':<12}" + "".join(f"{head:>15}" for head in HEADS))
    for name in arguments[2:]:
        for source, (document, run) in RUNS.items():
            controller = load(folder / name / document, Controller)
            found = figures(spec, controller, read_log(folder / name / run))
            print(f"{name:<24}{source:<12}" + "".join(f"{figure:>15}" for figure in found))
    drive = si_unit(spec.drive, spec.axis)
    print(f"speed in {si_unit('velocity', spec.axis)}, jitter in {drive}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
