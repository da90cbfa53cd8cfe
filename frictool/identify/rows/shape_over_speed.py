"""Shape over the speed of a fitted friction: falling, or rising less than in proportion.

The columns of FALLS describe a friction that falls with speed, and a friction that rises less than
in proportion to speed. In the second case, the fitted effort is concave over the speed: a parabola
through it has a negative curvature.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from frictool.identify.rows.effects import FALLS, RISING, RISING_SETTLE, Hypothesis
from frictool.identify.rows.load_terms import TERMS
from frictool.identify.rows.regression_samples import RegressionSamples
from frictool.typing import Vector

SLOWEST = 0.1  # share of the samples that give the friction at low speed


def named_by_shape(
    one: Hypothesis,
    model: Sequence[Hypothesis],
    values: Mapping[str, float],
    samples: RegressionSamples,
) -> Hypothesis:
    """Return the hypothesis `one` with a name and advice that suit its fitted effort over speed.

    The term of `one` is in FALLS; `values` are the fitted parameters of `model`, which contains
    `one`. If a load was fitted, the advice is an entry of load.terms instead of the method
    stribeck-curve, which cannot fit loads.
    """
    names = [name for fall in model if fall.term in FALLS for name in fall.names]
    friction = _friction(names, values, samples)
    if np.polynomial.Polynomial.fit(np.abs(samples.velocity), friction, 2).coef[2] < 0.0:
        return replace(one, what=RISING, settle=RISING_SETTLE)
    loaded = any(name in values for parts in TERMS.values() for name in parts)
    return replace(one, settle=f"add {one.term} to load.terms") if loaded else one


def friction_at_rest(
    names: Sequence[str], values: Mapping[str, float], samples: RegressionSamples
) -> float:
    """Return the friction [N m | N] at speed 0 of a line through the slowest samples (SLOWEST).

    The friction is the Coulomb friction in `values` plus the effort of the columns `names`.
    """
    speed = np.abs(samples.velocity)
    slow = speed <= np.quantile(speed, SLOWEST)
    friction = _friction(names, values, samples)[slow]
    line = np.polynomial.Polynomial.fit(speed[slow], friction, 1)
    return values["coulomb"] + float(line(0.0))


def _friction(
    names: Sequence[str], values: Mapping[str, float], samples: RegressionSamples
) -> Vector:
    """Return the effort (n,) of columns along the motion, N m | N."""
    return np.asarray(samples.sign * sum(values[name] * samples.loads[name] for name in names))
