"""Exported C in an independent plant, called through ctypes, compared with frictool's prediction.

    python -m studies.own_plant

The carriage of configs/emps is simulated here in 30 lines of Python with small time steps. The
controller is the C code of `export`. The table compares the metrics at every corner of the ranges
of inertia, friction and offset with frictool's predictions. The exit code is 1 if a verdict
differs.
"""

from __future__ import annotations

import ctypes
import itertools
import math
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictool.campaign import ControllerJudge
from frictool.documents import load
from frictool.export import export
from frictool.synth import synthesise
from frictool.typing import Vector
from studies.actuators.native import Controller, load_exported

RIG = Path(__file__).parents[1] / "configs/emps"
VARIED = ("inertia", "viscous", "coulomb", "offset")
PERIOD, CONSTANT, LIMIT, COUNT = 1e-3, 35.15065, 10.0, 5e-8  # s, N/V, V, m: configs/emps/bench.yaml
LEVELS, HOLD = (0.10, 0.05), 2000  # m, samples: configs/emps/scenarios/steps.yaml
STEPS = 10  # integration steps per sample
# requirement -> unit of its figure in the table, and the factor from SI
SHOWN = {
    "response_time_95": ("s", 1.0),
    "overshoot": ("%", 1.0),
    "static_error": ("mm", 1e3),
    "drive_peak": ("V", 1.0),
}


class Corner(NamedTuple):
    """Carriage at a corner of the ranges, in SI."""

    inertia: float
    viscous: float
    coulomb: float
    offset: float


def play(corner: Corner, breakaway: float, controller: Controller) -> tuple[Vector, Vector]:
    """Return the position at each sample, (n,) m, and the command, (n,) V."""
    state = np.frombuffer(bytearray(controller.state), dtype=np.uint8)
    position, speed, drive, h = LEVELS[-1], 0.0, 0.0, PERIOD / STEPS
    step = controller.step
    step.restype, step.argtypes = ctypes.c_double, [ctypes.c_void_p, *[ctypes.c_double] * 2]
    controller.init(state.ctypes.data, math.floor(position / COUNT) * COUNT)
    reference = np.repeat(LEVELS, HOLD)
    positions, commands = np.empty(reference.size), np.empty(reference.size)
    for sample, target in enumerate(reference):
        positions[sample] = math.floor(position / COUNT) * COUNT
        commands[sample] = step(state.ctypes.data, target, positions[sample])
        effort = CONSTANT * drive - corner.offset
        for _ in range(STEPS):
            if speed == 0.0 and abs(effort) <= breakaway:
                break
            way = math.copysign(1.0, speed if speed != 0.0 else effort)
            push = effort - way * corner.coulomb - corner.viscous * speed
            after = speed + h * push / corner.inertia
            if (
                way * after <= 0.0
            ):  # the carriage stops in this step; the next step decides if it sticks
                after = 0.0
            position += 0.5 * h * (speed + after)
            speed = after
        drive = max(-LIMIT, min(LIMIT, commands[sample]))  # acts one sample later
    return positions, commands


def figures(positions: Vector, commands: Vector) -> dict[str, float]:
    """Return the worst value of each requirement over both steps, in SI and %."""
    worst = dict.fromkeys(SHOWN, 0.0)
    start = positions[0]
    for hold, target in enumerate(LEVELS):
        seen = positions[hold * HOLD : (hold + 1) * HOLD]
        size, final = target - start, float(np.mean(seen[-HOLD // 10 :]))
        outside = np.flatnonzero(np.abs(seen - final) > 0.05 * abs(size))
        one = {
            "response_time_95": PERIOD * (int(outside[-1]) + 1),
            "overshoot": max(0.0, 100.0 * float(np.max((seen - target) / size))),
            "static_error": abs(target - final),
        }
        worst |= {name: max(worst[name], value) for name, value in one.items()}
        start = target
    return worst | {"drive_peak": float(np.abs(commands).max())}


def main() -> int:
    """Print the table; return 1 if a verdict differs."""
    model, spec = load(RIG / "published.yaml"), load(RIG / "spec.yaml")
    controller = synthesise(
        model, spec, load(RIG / "designs/speed.yaml"), vertices_only=True
    ).controller
    mechanics = model.bench.mechanics
    ratio = model.parameters.breakaway.value / model.parameters.coulomb.value
    ranges = [getattr(mechanics, name).interval for name in VARIED]
    corners = [Corner(*values) for values in itertools.product(*ranges)]
    scenario = load(RIG / "scenarios/steps.yaml")
    predicted = ControllerJudge(model, scenario, spec, [one._asdict() for one in corners])(
        controller
    )
    with tempfile.TemporaryDirectory() as place:
        for name, text in export(controller, "c", "double").files.items():
            Path(place, name).write_bytes(text if isinstance(text, bytes) else text.encode())
        compiled = load_exported(Path(place))
        played = [figures(*play(one, ratio * one.coulomb, compiled)) for one in corners]
    columns = {metric.name: index for index, metric in enumerate(predicted.metrics)}
    agreeing = 0
    print(f"{'requirement':<18}{'limit':>9}{'frictool':>11}{'independent':>13}")
    for name, (unit, factor) in SHOWN.items():
        metric = predicted.metrics[columns[name]]
        here = np.array([one[name] for one in played])
        there = predicted.values[:, columns[name]]
        agreeing += int(np.sum((here <= metric.limit) == (there <= metric.limit)))
        cells = [
            f"{factor * value:.3g} {unit}" for value in (metric.limit, there.max(), here.max())
        ]
        print(f"{name:<18}{cells[0]:>9}{cells[1]:>11}{cells[2]:>13}")
    count = len(corners) * len(SHOWN)
    print(
        f"equal verdicts: {agreeing} of {count} ({len(SHOWN)} requirements at "
        f"{len(corners)} corners)"
    )
    return int(agreeing != count)


if __name__ == "__main__":
    sys.exit(main())
