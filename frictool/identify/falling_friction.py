"""Shift of the parameters by friction that falls with speed.

    effort of the fall = c s exp(-(v/w)^2), c > 0

v is the velocity and s its sign. w is the speed over which the friction falls, the same for all
logs. Without this effort in the model, viscous friction becomes too small, and Coulomb friction too
large, for every weighting of the samples. Two fits with different weightings can therefore agree,
as `auto` requires, although both lack the fall.

`explanation_search` tests a fall with several columns at once. Each column has a different w, a
fraction of the top speed of each record. Logs with few speeds do not determine several columns. In
this module, a fit has one column, with the same w for all records. Successive w differ by a factor
of at most 2. The slowest 5 % of the samples (SLOWEST) have speeds below the smallest w. The largest
w is WIDEST times the top speed of all logs.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from frictool.identify.effect_regression import AcceptedEffects, EffectRegression
from frictool.identify.estimators.searched_records import ROWS_PER_WINDOW
from frictool.identify.fit_result import Explanation
from frictool.identify.rows.effects import FALLS, WHAT, WIDE_SHARES, Hypothesis
from frictool.identify.rows.regression_samples import reduced
from frictool.identify.rows.shape_over_speed import friction_at_rest

WIDEST = WIDE_SHARES[-1]  # largest speed w relative to the top speed
SLOWEST = 0.05  # share of the samples whose speeds are below the smallest w


def falling_friction(regression: EffectRegression) -> list[AcceptedEffects]:
    """Return the shifts of the parameters by the most significant fall of friction with speed.

    A fall is tested for several speeds w (module docstring). The result is empty if none is
    significant, with Bonferroni's correction.
    """
    rows = regression.rows
    used = regression.used
    samples = rows.samples
    speed = np.abs(samples.velocity)
    widest = WIDEST * float(np.max(speed))
    slowest = min(float(np.quantile(speed, SLOWEST)), widest)
    if slowest <= 0.0:
        return []
    count = 1 + math.ceil(math.log2(widest / slowest))
    widths = np.geomspace(slowest, widest, count)
    falls = [
        Hypothesis(name, (name,), WHAT["stribeck"], "", positive=True)
        for name in (f"fall_{k}" for k in range(count))
    ]
    columns = {
        one.term: samples.sign * np.exp(-((speed / w) ** 2))
        for one, w in zip(falls, widths, strict=True)
    }
    more = replace(samples, loads={**samples.loads, **columns})
    sliding = len(rows.names) - len(samples.loads)
    plain = reduced(more, np.ones(speed.size), sliding, ROWS_PER_WINDOW)[0]
    rows = replace(rows, samples=more, plain=plain, names=(*rows.names, *columns))
    tried = [(rows.probability(one, used), one) for one in falls if rows.visible(one, used)]
    best = min(tried, key=lambda one: one[0], default=None)
    if best is None or count * best[0] > 1.0 - regression.confidence:
        return []
    extended = replace(regression, rows=rows)
    shifts = extended.alternative([*used, best[1]])
    return [replace(one, one_sided=True) for one in shifts]


def slow_friction(regression: EffectRegression) -> float | None:
    """Return the friction [N m | N] at speed 0 in a fit with the columns of the effect FALLS[0].

    The result is None if the regression does not determine it.
    """
    fall = next((one for one in regression.hypotheses if one.term == FALLS[0]), None)
    if fall is None:
        return None
    values = regression.values([*(one for one in regression.used if one is not fall), fall])
    if values is None or "coulomb" not in values:
        return None
    return friction_at_rest(fall.names, values, regression.rows.samples)


def explained(regression: EffectRegression, one: Explanation) -> Explanation:
    """Return an explanation, with a name and advice chosen by the shape of its fitted effort."""
    falls = {fall.term: fall for fall in regression.hypotheses if fall.term in FALLS}
    named = {
        term: regression.named(fall, [other for other in regression.used if other is not fall])
        for term, fall in falls.items()
    }
    names = {fall.what: named[term].what for term, fall in falls.items()}
    rivals = tuple(names.get(what, what) for what in one.rivals)
    if one.name not in named:
        return replace(one, rivals=rivals)
    kind = named[one.name]
    return replace(one, what=kind.what, settle=kind.settle, rivals=rivals)
