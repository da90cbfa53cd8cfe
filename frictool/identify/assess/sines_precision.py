"""Expected precision of the method of sines (thesis 4.38).

The effort is averaged over the middle part of a stroke, the n samples with more than half of the
top speed. The mean speed follows from the encoder counts at both ends of this part. The mean effort
minus viscous friction times mean speed therefore has the variance

    noise^2/n + (viscous step)^2/(6 duration^2)

`noise` is the standard deviation of an effort sample, `viscous` the viscous friction, `step` the
encoder step, and `duration` the duration of the middle part. A second error is the uncertainty of
the inertia times the mean acceleration of this part. This acceleration is 0 if the axis follows the
sine exactly. The speeds at the two ends of the part are assumed to differ by at most FOLLOWED times
the top speed. Repeating strokes does not reduce the second error, which is added as a bound.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.identify.assess.assessment_inputs import AssessmentInputs
from frictool.typing import Vector

GATE = math.radians(30.0)  # the middle part of a stroke is from 30 to 150 degrees
MEAN = math.cos(GATE) / (0.5 * math.pi - GATE)  # mean of the sine over the middle part
SPREAD = 1.2  # least ratio of the fastest to the slowest stroke, as in identify/estimators/sines.py
FOLLOWED = 0.03  # largest difference between the speeds at both ends, relative to the top speed


def sines_half_width(facts: AssessmentInputs, quantile: float) -> Vector:
    """Return the half widths (2,) of the intervals of viscous and Coulomb friction in SI units.

    `facts` are the inputs of the assessment. `quantile` is the number of standard deviations in a
    half width. The result is inf if all strokes have nearly the same speed.
    """
    rows = np.array([[MEAN * stroke.speed, 1.0] for stroke in facts.strokes])
    duration = np.array([stroke.duration for stroke in facts.strokes]) * (
        1.0 - 2.0 * GATE / math.pi
    )
    strokes = np.array([2.0 * stroke.times for stroke in facts.strokes])
    noise = facts.sensing.noise**2 * facts.sensing.period / duration
    counts = (facts.axis.viscous * facts.sensing.step / duration) ** 2 / 6.0
    weight = strokes / (noise + counts)
    normal = rows.T @ (rows * weight[:, None])
    if float(rows[:, 0].max()) < SPREAD * float(rows[:, 0].min()):
        return np.full(2, np.inf)
    covariance = np.linalg.inv(normal)
    low, _, high = facts.inertia
    inertial = (
        0.5
        * (high - low)
        * FOLLOWED
        * np.array([stroke.speed for stroke in facts.strokes])
        / duration
    )
    common = covariance @ (rows.T @ (weight * inertial))
    return np.asarray(np.hypot(quantile * np.sqrt(np.diag(covariance)), common))
