"""Reference of a scenario, computed from its steps at each sample k of the controller's period T.

reference  r                               constant
ramp_to    r0 + (r1 - r0)(j + 1)/n         reaches r1 at the last sample, j = n - 1
sine       centre + A sin(2 pi f j T + phase)
hold_s     r0

Sample j of a step is counted from the step's start. A step of duration d has n = round(d/T)
samples. r0 is the last reference of the previous step; in the first step, r0 is the scenario's
`start`. A is the amplitude and f the frequency of the sine; its centre is r0 unless the step states
another.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.scenario import Scenario, Sine, Step
from frictool.typing import Vector


def samples_of(seconds: float, period: float) -> int:
    """Return the number of samples in `seconds` [s]."""
    return round(seconds / period)


def parts_of(scenario: Scenario, period: float) -> list[Vector]:
    """Return the reference [rad | m], one array of samples for each step of the scenario."""
    assert scenario.start is not None
    last = scenario.start.value
    parts = []
    for step in scenario.steps:
        part = _part(step, last, samples_of(step.seconds, period), period)
        parts.append(part)
        last = float(part[-1]) if part.size else last
    return parts


def _part(step: Step, last: float, samples: int, period: float) -> Vector:
    if step.ramp_to is not None:
        along = np.arange(1, samples + 1) / max(samples, 1)
        return last * (1.0 - along) + step.ramp_to.value * along
    if step.sine is not None:
        return _sine(step.sine, last, samples, period)
    return np.full(samples, last if step.reference is None else step.reference.value)


def _sine(sine: Sine, last: float, samples: int, period: float) -> Vector:
    centre = last if sine.centre is None else sine.centre.value
    angle = 2.0 * math.pi * sine.frequency_hz * period * np.arange(samples) + math.radians(
        sine.phase_deg
    )
    values: Vector = centre + sine.amplitude.value * np.sin(angle)
    return values
