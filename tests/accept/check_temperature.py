"""Wear under changing temperatures, and the share of intervals of friction over temperature.

The axes of `tests/support/warm_axes.py` share no code with the product. Viscous friction halves
from 30 to 80 degC, along a line or by Reynolds' law, and Coulomb friction falls by up to 0.3 % per
kelvin; the temperature of each log begins and ends anywhere in between. The models have Reynolds'
law with random errors of the slopes, which their intervals state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.observe.wear_estimate import WearEstimate
from frictool.observe.wear_limit import judge
from tests.support.warm_axes import (
    COLD,
    HOT,
    Histories,
    WarmAxis,
    changing,
    cold_and_hot,
    warm_axes,
    warming_up,
)
from tests.support.warm_models import warm_model, wear_of

HEALTHY, WORN = 5000, 600  # runs
TOGETHER = 100  # logs simulated at a time
WEARS = (1.0, 1.2, 1.5)
DEVIATIONS = (2e-4, 1e-4)  # 1/K, of the slopes of viscous and Coulomb friction in a model
LIMIT = 1.25
MEAN_ERROR = 2.0  # %
AXES = 40  # identified for each kind of log
STATED, CHANCE = 0.95, 1e-3  # share of intervals that hold; chance of a draw in which fewer hold


def estimates(count: int, wears: tuple[float, ...]) -> Iterator[tuple[WarmAxis, WearEstimate]]:
    """Yield `count` axes with the wear estimated from a log, alternately along both laws."""
    for first in range(0, count, TOGETHER):
        seeds = range(first, min(first + TOGETHER, count))
        curved = bool(first // TOGETHER % 2)
        for seed, axis in zip(seeds, warm_axes(seeds, curved, changing, wears), strict=True):
            yield axis, wear_of(warm_model(axis, DEVIATIONS, seed), axis)


def alarms(count: int = HEALTHY) -> dict[str, Any]:
    """No alarm and no doubt at LIMIT without wear."""
    runs = [judge(wear, LIMIT) for _, wear in estimates(count, (1.0,))]
    false = sum(one.exceeded is not False for one in runs)
    return {"passed": false == 0, "runs": len(runs), "false": false}


def errors(count: int = WORN) -> dict[str, Any]:
    """The mean error of the wear."""
    found = list(estimates(count, WEARS))
    error = np.array([100.0 * (wear.wear.value / axis.truth.wear - 1.0) for axis, wear in found])
    held = [wear.wear.low <= axis.truth.wear <= wear.wear.high for axis, wear in found]
    return {
        "passed": bool(np.mean(np.abs(error)) <= MEAN_ERROR),
        "runs": error.size,
        "mean_error_percent": float(np.mean(np.abs(error))),
        "largest_percent": float(np.max(np.abs(error))),
        "held": float(np.mean(held)),
    }


def intervals(count: int = AXES) -> dict[str, Any]:
    """The intervals of friction and of its slope contain the true values."""
    kinds: tuple[tuple[str, Histories], ...] = (
        ("warming up", warming_up),
        ("cold and hot", cold_and_hot),
    )
    held: dict[str, list[bool]] = {"viscous": [], "coulomb": [], "viscous slope": []}
    for _, histories in kinds:
        for axis in warm_axes(range(count), True, histories):
            result = identify_records(
                axis.records, [], axis.bench, "auto", IdentificationSettings()
            )
            law = result.laws.temperature if result.laws is not None else None
            if law is None or law.viscous is None:
                held["viscous slope"].append(False)
                continue
            at = law.reference.value
            for name in ("viscous", "coulomb"):
                one = result.identified[name]
                held[name].append(one.low <= float(getattr(axis.truth, name)(at)) <= one.high)
            low, high = law.viscous.slope.interval
            held["viscous slope"].append(low <= np.log(0.5) / (HOT - COLD) <= high)
    shares = {name: float(np.mean(one)) for name, one in held.items()}
    return {
        "passed": all(sum(one) >= binom.ppf(CHANCE, len(one), STATED) for one in held.values()),
        "axes": count * len(kinds),
        **shares,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "temperature: alarms of runs without wear": alarms,
    "temperature: error of the wear": errors,
    "temperature: intervals of friction over temperature": intervals,
}
