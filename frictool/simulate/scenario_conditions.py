"""Disturbances, drifts and sensor faults of a scenario, as an array with one row for each sample.

engine/disturbances_and_faults.py defines the columns. Sample k begins at k T and lasts for the
sample period T.

temperature    constant factor of the friction
disturbance    mean effort over the sample, so that the impulse is exact
drift          factor in the middle of the sample
sensor fault   from the first sample at or after `at_s` to the last sample before `until_s`
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from frictool.adapters.parameter_intervals import UNCHANGED
from frictool.control.supervision import CommandName
from frictool.documents.conditions import (
    ControllerCommand,
    Disturbance,
    DriftPoint,
    Drifts,
    SensorFault,
)
from frictool.documents.scenario import Scenario
from frictool.engine.disturbances_and_faults import (
    CONSTANT_FACTOR,
    DISTURBANCE,
    ENCODER_FAULT,
    FRICTION,
    INVALID,
    LOST,
    NEUTRAL,
    NO_CONDITIONS,
    SENSOR_GAIN,
    SENSOR_OFFSET,
    STUCK,
    VISCOUS_FACTOR,
    constant,
)
from frictool.simulate.rig import Rig
from frictool.typing import Vector

SAME_INSTANT = 9  # decimals to which instants are rounded, in samples


def conditions_of(
    scenario: Scenario, samples: int, period: float, factors: Mapping[str, float] = UNCHANGED
) -> Vector:
    """Return the disturbances, drifts and faults (samples, 8) of a scenario.

    engine/disturbances_and_faults.py names the columns. If the scenario has no disturbance, drift
    or fault, and `factors` is empty, the result has the shape (0, 8). factors: factors of `viscous`
    and `coulomb` friction at the temperature of the scenario.
    """
    happening = scenario.disturbances or scenario.drifts is not None or scenario.sensor_faults
    if not happening and not factors:
        return NO_CONDITIONS
    drifts = scenario.drifts or Drifts()
    rows = constant(_constant_row(drifts, factors), samples)
    for disturbance in on_axis(scenario):
        _effort(disturbance, rows, period)
    for column, points in _points(drifts).items():
        if len(points) > 1:
            middle = (np.arange(samples) + 0.5) * period
            rows[:, column] *= np.interp(
                middle, [point.at_s for point in points], [point.factor for point in points]
            )
    _fail(rows, scenario.sensor_faults, period)
    return rows


def loop_conditions(conditions: Vector, rig: Rig) -> Vector:
    """Return the conditions that act on the control loop.

    Faults of the drive's sensor act in the loop of a current drive only, which feeds the measured
    current back. For all other drives, these faults are removed: the measured drive is only logged.
    """
    if rig.drive == "current" or not conditions.size:
        return conditions
    ideal = conditions.copy()
    ideal[:, SENSOR_OFFSET], ideal[:, SENSOR_GAIN] = 0.0, 1.0
    return ideal


def on_axis(scenario: Scenario) -> list[Disturbance]:
    """Return the disturbances that name no block and therefore act on the driven axis."""
    return [disturbance for disturbance in scenario.disturbances if disturbance.on is None]


def _effort(disturbance: Disturbance, rows: Vector, period: float) -> None:
    end = math.inf if disturbance.duration_s is None else disturbance.at_s + disturbance.duration_s
    begin = max(0, math.floor(disturbance.at_s / period) - 1)
    until = rows.shape[0] if math.isinf(end) else min(rows.shape[0], math.ceil(end / period) + 1)
    if begin >= until:
        return
    edges = np.arange(begin, until, dtype=np.float64)
    first, last = (  # begin and end of the overlap with each sample, 0 to 1 within the sample
        np.minimum(np.maximum((instant / period - edges).round(SAME_INSTANT), 0.0), 1.0)
        for instant in (disturbance.at_s, end)
    )
    mean: Vector = disturbance.effort.value * (last - first)
    if disturbance.frequency_hz is not None:
        middle = (edges + 0.5 * (first + last)) * period - disturbance.at_s
        # turns of the sine within the sample
        turns = disturbance.frequency_hz * period * (last - first)
        phase = math.radians(disturbance.phase_deg)
        angle = 2.0 * math.pi * disturbance.frequency_hz * middle + phase
        # the mean of a sine over a span is its value in the middle times sinc
        mean = mean * np.sin(angle) * np.sinc(turns)
    rows[begin:until, DISTURBANCE] += mean


def _points(drifts: Drifts) -> dict[int, tuple[DriftPoint, ...]]:
    return {
        FRICTION: drifts.friction,
        VISCOUS_FACTOR: drifts.viscous,
        CONSTANT_FACTOR: drifts.constant,
    }


def _constant_row(drifts: Drifts, factors: Mapping[str, float]) -> Vector:
    row = np.array(NEUTRAL)
    row[FRICTION] *= factors.get("coulomb", 1.0)
    row[VISCOUS_FACTOR] *= factors.get("viscous", 1.0)
    for column, points in _points(drifts).items():
        if len(points) == 1:
            row[column] *= points[0].factor
    return row


def _fail(rows: Vector, faults: Sequence[SensorFault], period: float) -> None:
    for fault in faults:
        begin = _sample(fault.at_s / period)
        end = rows.shape[0]
        if fault.until_s is not None:
            end = _sample(fault.until_s / period)
        there = slice(begin, max(begin, end))
        if fault.counts is not None:
            rows[there, LOST] += fault.counts
        elif fault.offset is not None:
            rows[there, SENSOR_OFFSET] += fault.offset.value
        elif fault.gain_error is not None:
            rows[there, SENSOR_GAIN] *= 1.0 + fault.gain_error
        else:
            kind = INVALID if fault.kind == "encoder_invalid" else STUCK
            rows[there, ENCODER_FAULT] = np.maximum(rows[there, ENCODER_FAULT], kind)


def _sample(instant: float) -> int:
    scale = 10.0**SAME_INSTANT
    return math.ceil(round(instant * scale) / scale)


def command_samples(
    commands: Sequence[ControllerCommand], period: float
) -> dict[int, list[CommandName]]:
    """Return the supervisor's commands at each sample, by the index of the sample.

    A command belongs to the first sample at or after the time `at_s` of the command.
    """
    samples: dict[int, list[CommandName]] = {}
    for one in sorted(commands, key=lambda command: command.at_s):
        index = math.ceil(round(one.at_s / period, SAME_INSTANT))
        samples.setdefault(index, []).append(one.command)
    return samples
