"""Widening of intervals for two effects that resemble a parameter and are not in the model.

A spring resembles the inertia, because position and acceleration are proportional in a sinusoidal
motion. Viscous friction that differs by direction resembles the offset: with the velocity v it adds
an effort c |v|, and |v| is nearly constant in strokes of one speed. The parameters absorb most of
the two effects, so that the residual hardly shows them.

Each effect is tried alone. The prior of its coefficient is a normal distribution with mean 0. With
a coefficient of one standard deviation, the effect has the same rms effort as the lasting part of
the residual: the part that stays correlated for longer than the smoothing windows. A lasting part
shows that the machine has an unmodelled effect. The machine can then also have the tried effect, of
the same size. Without a lasting part, no interval is widened.

The mean square of the lasting part is the covariance of residuals of the same stroke at a distance
of LASTING windows. Noise of effort and encoder is correlated over one window only.
"""

from __future__ import annotations

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.identify.effect_regression import AcceptedEffects, EffectRegression
from frictool.identify.estimators.searched_records import ROWS_PER_WINDOW
from frictool.identify.rows.effects import Hypothesis
from frictool.identify.rows.load_terms import DIRECTION, GRAVITY, SPRING
from frictool.typing import IntVector, Vector

LASTING = 2  # distance of the compared residuals, in smoothing windows


def hidden_effects(regression: EffectRegression, bench: Bench) -> list[AcceptedEffects]:
    """Return the shifts of the parameters by two effects that the fit may lack, one at a time.

    The tried effects are a spring, and a viscous friction that differs between the directions. An
    effect is left out if the model includes it, or if the rows do not determine it. The spring is
    left out if the bench declares the loads. The result is empty if the residuals are not
    correlated over a distance of LASTING smoothing windows within a stroke.
    """
    rows = regression.rows
    residual = rows.residual(regression.used)
    lag = LASTING * ROWS_PER_WINDOW
    lasting = lasting_rms(residual, rows.samples.stroke, lag, regression.confidence)
    terms = (SPRING, DIRECTION) if bench.load is None else (DIRECTION,)
    tried = [one for one in regression.free if one.term in terms]
    shifts = [_shift(regression, one, lasting) for one in tried] if lasting > 0.0 else []
    return [one for one in shifts if one is not None]


def _shift(
    regression: EffectRegression, effect: Hypothesis, lasting: float
) -> AcceptedEffects | None:
    """Return the shift of the parameters by one effect; None if the rows do not determine it.

    lasting: rms effort of the effect for one standard deviation of the prior of its coefficient.
    """
    (column,) = effect.names
    fitted = regression.intervals([effect]).get(column)
    rates = regression.rates(effect)
    if fitted is None or not rates or not np.isfinite(fitted.half_width):
        return None
    samples = regression.rows.samples
    values = samples.loads[column]
    if effect.term == DIRECTION:
        # the column is v backward and 0 forward, hence (v - |v|)/2; viscous is the mean of both
        # directions
        size = 0.5 * float(np.sqrt(np.mean(samples.velocity**2)))
        centred = {"viscous": 0.5}
    else:
        size = float(np.std(values))
        # without a load in the model, the offset includes the mean load
        alone = regression.load_zero is None
        alone = alone and all(one.term != GRAVITY for one in regression.used)
        centred = {"offset": float(np.mean(values))} if alone else {}
    rates = {name: rate + centred.get(name, 0.0) for name, rate in rates.items()}
    quantile = float(scipy.special.ndtri(0.5 + 0.5 * regression.confidence))
    known = quantile * lasting / size
    half = float(np.hypot(fitted.half_width, regression.scatter([effect])[column]))
    weight = known**2 / (known**2 + half**2)
    return AcceptedEffects(
        (effect.what,),
        1.0,
        {name: weight * fitted.value * rate for name, rate in rates.items()},
        scatter={name: float(np.sqrt(weight)) * half * abs(one) for name, one in rates.items()},
    )


def lasting_rms(residual: Vector, stroke: IntVector, lag: int, confidence: float) -> float:
    """Return the rms of the part of the residual that lasts longer than `lag` rows.

    The square of the result is the mean product of two residuals of a stroke that are `lag` rows
    apart. The result is 0 unless this mean is significantly positive in Student's test over the
    strokes with the confidence `confidence`.

    - residual: residuals of the fit in the order of time, (n,)
    - stroke: number of the stroke of each row, (n,)
    """
    same = stroke[lag:] == stroke[:-lag]
    products = (residual[lag:] * residual[:-lag])[same]
    index = np.unique(stroke[lag:][same], return_inverse=True)[1]
    count = int(index.max(initial=-1)) + 1
    if count < 2:
        return 0.0
    mean = float(np.mean(products))
    deviations = np.bincount(index, products - mean)
    error = float(np.sqrt(count / (count - 1) * np.sum(deviations**2))) / products.size
    lasts = mean > float(scipy.special.stdtrit(count - 1, confidence)) * error
    return float(np.sqrt(mean)) if lasts else 0.0
