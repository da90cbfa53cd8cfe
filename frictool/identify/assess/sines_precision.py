"""How precise the method of sines (4.38) is, computed before anything is measured: mean effort over
mean speed of gated strokes.

A stroke counts where |sin| > 1/2. Its mean effort has the noise of its samples, its mean speed
comes from the counts at its ends:

    variance = noise^2/n + (viscous step)^2/(6 duration^2)

and the inertia, of which only the a-priori range is known, times the mean acceleration, which is 0
on a sine that is followed. What a position loop is trusted with: the speeds at the ends of the gate
differ by FOLLOWED of the top speed at most. This part no repetition averages; it is added as a
bound.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.identify.assess.assessment_inputs import AssessmentInputs
from frictool.identify.excite.cramer_rao import Vector

GATE = math.radians(30.0)  # sines count from 30 to 150 degrees
MEAN = math.cos(GATE) / (0.5 * math.pi - GATE)  # of the sine over the gate
SPREAD = 1.2  # of the fastest stroke over the slowest: as identify/estimators/sines.py asks
FOLLOWED = 0.03  # of the top speed


def sines_half_width(facts: AssessmentInputs, quantile: float) -> Vector:
    """Half widths (2,) of viscous and coulomb in SI, inf where all strokes have one speed (4.37).

    quantile: how many standard deviations an interval has either way.
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
