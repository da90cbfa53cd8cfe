"""Judge of a controller on the plants of an actuator, without frictool's engine and metrics.

The simulation is axis.c, the metrics are in figures.c, the margin is in `margin.py`. The scenario
is a step over most of the travel, and the step back, as in `documents.scenario`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.typing import Matrix, Vector
from studies.actuators.drawing import Actuator, Plant
from studies.actuators.native import Controller, judge_library

LOOSE_BREAKAWAY = 1.1  # breakaway divided by Coulomb friction, inside the backlash (table 4.8)
TOLERANCE = 1e-9  # relative tolerance of a figure at its limit
FIGURES = 7
REQUIREMENTS = (
    "response_time_95_s",
    "overshoot_percent",
    "static_error",
    "oscillations",
    "drive_peak",
    "rest",
    "modulus_margin",
)


class Run(NamedTuple):
    """Signals at each sample: encoder reading, command, true position."""

    seen: Vector
    commands: Vector
    positions: Vector


@dataclass(frozen=True)
class Verdict:
    """Worst value and limit of each requirement; for each plant, True if it meets all of them.

    Values are in SI. The value of rest is the motion in counts, or infinite if the drive is not 0.
    """

    worst: dict[str, float]
    limits: dict[str, float]
    met: dict[str, bool]
    plants: tuple[bool, ...]

    @property
    def all_met(self) -> bool:
        """Return True if every plant meets every requirement."""
        return all(self.met.values())


def axis_record(actuator: Actuator, plant: Plant) -> Vector:
    """Return the record `axis_t` of axis.c for one plant."""
    scale = plant.coulomb / actuator.coulomb.value
    loose = min(scale * actuator.backlash_coulomb, plant.coulomb)
    return np.array(
        [
            actuator.period,
            actuator.delay,
            actuator.lag,
            actuator.encoder_step,
            actuator.limit,
            plant.inertia,
            plant.viscous,
            plant.coulomb,
            plant.constant,
            actuator.breakaway_ratio * plant.coulomb,
            actuator.backlash,
            loose,
            LOOSE_BREAKAWAY * loose,
            actuator.start + plant.phase * actuator.encoder_step,
        ]
    )


def play(axis: Vector, reference: Vector, controller: Controller, values: Plant) -> Run:
    """Simulate a controller on the axis with the record `axis`, and return the signals.

    values: parameters of the plant, for a scheduled controller. Raises RuntimeError if the motion
    within a sample does not end.
    """
    library = judge_library()
    state = np.frombuffer(bytearray(controller.state), dtype=np.uint8)
    step, start = axis[3], axis[13]
    controller.init(state.ctypes.data, math.floor(start / step) * step)
    for name, setter in controller.setters.items():
        setter(state.ctypes.data, getattr(values, name))
    seen, commands, positions = (np.empty(reference.size) for _ in range(3))
    code = library.axis_run(
        axis.ctypes.data,
        reference.ctypes.data,
        reference.size,
        controller.step,
        state.ctypes.data,
        seen.ctypes.data,
        commands.ctypes.data,
        positions.ctypes.data,
    )
    if code != 0:
        raise RuntimeError("the motion within a sample does not end")
    return Run(seen, commands, positions)


def step_reference(actuator: Actuator) -> tuple[Vector, int]:
    """Return the reference (n,) of both steps, and the index at which the second step begins."""
    first, second = (
        round(duration / actuator.period) for duration in (actuator.short_hold, actuator.long_hold)
    )
    levels = actuator.start + actuator.amplitude, actuator.start
    return np.repeat(levels, (first, second)), first


def plant_figures(actuator: Actuator, controller: Controller, plant: Plant) -> Vector:
    """Return the worst value over both steps of each requirement except the margin (6,).

    Values are in SI. The value of rest is the motion in counts, or infinite if the drive is not 0.
    """
    reference, second = step_reference(actuator)
    run = play(axis_record(actuator, plant), reference, controller, plant)
    origin = run.seen[0]  # the first step begins at the encoder's reading
    there, back = actuator.start + actuator.amplitude, actuator.start
    rest = round(actuator.rest_after / actuator.period)
    holds = ((0, second, origin, there, -1), (second, reference.size, there, back, rest))
    figures = np.array(
        [
            hold_figures(run, slice(start, stop), origin, target, actuator.encoder_step, rest)
            for start, stop, origin, target, rest in holds
        ]
    )
    response, overshoot, error, turns, motion, drive, peak = figures.max(axis=0)
    return np.array(
        [
            response * actuator.period,
            overshoot,
            error,
            math.ceil(turns / 2.0),
            peak,
            math.inf if drive > 0.0 else motion / actuator.encoder_step,
        ]
    )


def hold_figures(
    run: Run, hold: slice, origin: float, target: float, step: float, rest: int
) -> Vector:
    """Return the record `figures_t` of one hold of a run."""
    seen, commands = run.seen[hold], run.commands[hold]
    figures = np.empty(FIGURES)
    judge_library().hold_figures(
        seen.ctypes.data,
        commands.ctypes.data,
        seen.size,
        origin,
        target,
        step,
        rest,
        figures.ctypes.data,
    )
    return figures


def limits(actuator: Actuator) -> Vector:
    """Return the limit of each requirement (7,): upper limits, and last the lower margin limit."""
    return np.array(
        [
            actuator.response,
            actuator.overshoot,
            actuator.static_error,
            actuator.oscillations,
            actuator.limit,
            1.0,
            actuator.margin,
        ]
    )


def met(actuator: Actuator, figures: Matrix) -> NDArray[np.bool_]:
    """Return a mask of the values (plants, 7) that meet their limits."""
    limit = limits(actuator)
    upper = figures[:, :-1] <= limit[:-1] * (1.0 + TOLERANCE)
    lower = figures[:, -1:] >= limit[-1] * (1.0 - TOLERANCE)
    return np.hstack([upper, lower])


def judge(
    actuator: Actuator, controller: Controller, plants: Iterable[Plant], margins: Iterable[float]
) -> Verdict:
    """Return the verdict on a controller; `margins` are the modulus margins of the plants."""
    rows = [[*plant_figures(actuator, controller, plant)] for plant in plants]
    figures = np.column_stack([np.array(rows), np.fromiter(margins, dtype=float)])
    good = met(actuator, figures)
    worst = [*figures[:, :-1].max(axis=0), figures[:, -1].min()]
    return Verdict(
        dict(zip(REQUIREMENTS, np.array(worst).tolist(), strict=True)),
        dict(zip(REQUIREMENTS, limits(actuator).tolist(), strict=True)),
        dict(zip(REQUIREMENTS, [bool(column.all()) for column in good.T], strict=True)),
        tuple(bool(row.all()) for row in good),
    )
