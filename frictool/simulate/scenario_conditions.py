"""Disturbances, drifts and sensor faults of a scenario as one row per sample.

The columns are those of engine/disturbances_and_faults.py.

Sample k begins at k T and lasts for T.

disturbance   mean effort over the sample: a pulse keeps its impulse wherever it begins and ends
drift         factor in the middle of the sample
sensor        a fault lasts from the first sample at or after `at_s` to the last before `until_s`
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from frictool.documents.conditions import Disturbance, Drifts, SensorFault
from frictool.documents.scenario import Scenario
from frictool.engine.disturbances_and_faults import (
    CONSTANT_FACTOR,
    DISTURBANCE,
    ENCODER_FAULT,
    FRICTION,
    INVALID,
    LOST,
    NO_CONDITIONS,
    SENSOR_GAIN,
    SENSOR_OFFSET,
    STUCK,
    VISCOUS_FACTOR,
    neutral,
)
from frictool.simulate.rig import Rig
from frictool.typing import Vector

SAME_INSTANT = 9  # decimals of a sample: instants that differ only by rounding


def conditions_of(scenario: Scenario, samples: int, period: float) -> Vector:
    """Return the conditions (samples, 8) of a scenario, (0, 8) if it has none."""
    if not scenario.disturbances and scenario.drifts is None and not scenario.sensor_faults:
        return NO_CONDITIONS
    rows = neutral(samples)
    for disturbance in on_axis(scenario):
        rows[:, DISTURBANCE] += _effort(disturbance, samples, period)
    if scenario.drifts is not None:
        _drift(rows, scenario.drifts, period)
    _fail(rows, scenario.sensor_faults, period)
    return rows


def loop_conditions(conditions: Vector, rig: Rig) -> Vector:
    """Return the conditions that act on the loop.

    A voltage is not fed back, so a fault of its sensor affects the log only.
    """
    if rig.drive == "current" or not conditions.size:
        return conditions
    ideal = conditions.copy()
    ideal[:, SENSOR_OFFSET], ideal[:, SENSOR_GAIN] = 0.0, 1.0
    return ideal


def on_axis(scenario: Scenario) -> list[Disturbance]:
    """Return the disturbances of the driven axis, which name no block of a mechanism."""
    return [disturbance for disturbance in scenario.disturbances if disturbance.on is None]


def _overlap(begin: float, end: float, samples: int, period: float) -> tuple[Vector, Vector]:
    """Return the begin and end (n,) of [begin, end] in each sample, as shares in [0, 1]."""
    edges = np.arange(samples, dtype=np.float64)

    def within(instant: float) -> Vector:
        return np.clip(np.round(instant / period - edges, SAME_INSTANT), 0.0, 1.0)

    return within(begin), within(end)


def _effort(disturbance: Disturbance, samples: int, period: float) -> Vector:
    """Return the mean effort over each sample (n,) [N m | N]."""
    end = math.inf if disturbance.duration_s is None else disturbance.at_s + disturbance.duration_s
    first, last = _overlap(disturbance.at_s, end, samples, period)
    mean: Vector = disturbance.effort.value * (last - first)
    if disturbance.frequency_hz is None:
        return mean
    middle = (np.arange(samples) + 0.5 * (first + last)) * period - disturbance.at_s
    # turns of the sine within the sample
    turns = disturbance.frequency_hz * period * (last - first)
    angle = 2.0 * math.pi * disturbance.frequency_hz * middle + math.radians(disturbance.phase_deg)
    effort: Vector = (
        mean * np.sin(angle) * np.sinc(turns)
    )  # the mean of a sine over a span is its value in the middle times sinc
    return effort


def _drift(rows: Vector, drifts: Drifts, period: float) -> None:
    middle = (np.arange(rows.shape[0]) + 0.5) * period
    for column, points in (
        (FRICTION, drifts.friction),
        (VISCOUS_FACTOR, drifts.viscous),
        (CONSTANT_FACTOR, drifts.constant),
    ):
        if points:
            rows[:, column] = np.interp(
                middle, [point.at_s for point in points], [point.factor for point in points]
            )


def _fail(rows: Vector, faults: Sequence[SensorFault], period: float) -> None:
    """Write the sensor faults into `rows`.

    Simultaneous faults of one kind add up; gains multiply.
    """
    instants = np.arange(rows.shape[0], dtype=np.float64)
    for fault in faults:
        until = math.inf if fault.until_s is None else fault.until_s
        begin, end = (np.round(instant / period, SAME_INSTANT) for instant in (fault.at_s, until))
        there = (instants >= begin) & (instants < end)
        if fault.counts is not None:
            rows[there, LOST] += fault.counts
        elif fault.offset is not None:
            rows[there, SENSOR_OFFSET] += fault.offset.value
        elif fault.gain_error is not None:
            rows[there, SENSOR_GAIN] *= 1.0 + fault.gain_error
        else:
            kind = INVALID if fault.kind == "encoder_invalid" else STUCK
            rows[there, ENCODER_FAULT] = np.maximum(rows[there, ENCODER_FAULT], kind)
