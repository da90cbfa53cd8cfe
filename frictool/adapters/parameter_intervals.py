"""Intervals of a model's parameters, for which `synth` designs and from which `simulate` draws."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Backward, FrictionOverPosition
from frictool.documents.model import Model
from frictool.documents.quantity import FROM_LOGS, Quantity
from frictool.friction.position_polynomial import normalise

UNCHANGED: Mapping[str, float] = MappingProxyType({})
GRID_POINTS = 1001  # number of positions at which a polynomial is evaluated over the travel


def intervals(
    model: Model, factors: Mapping[str, float] = UNCHANGED
) -> dict[str, tuple[float, float]]:
    """Return the parameter intervals for which `synth` designs a controller.

    The result equals the result of `ranges`, except that the interval of the Coulomb friction also
    contains the friction at every position of the travel.

    `factors`: as in `ranges`.
    """
    ranges_of_model = ranges(model, factors)
    if model.laws is not None and model.laws.position is not None:
        local = _over_position(model.laws.position, model.parameters.coulomb, model.laws.backward)
        factor = factors.get("coulomb", 1.0)
        ranges_of_model["coulomb"] = (
            min(ranges_of_model["coulomb"][0], factor * local[0]),
            max(ranges_of_model["coulomb"][1], factor * local[1]),
        )
    return ranges_of_model


def ranges(
    model: Model, factors: Mapping[str, float] = UNCHANGED
) -> dict[str, tuple[float, float]]:
    """Return the parameter intervals from which `simulate` and `campaign` draw.

    An interval contains the model's interval, which describes the axis during the log, and the
    range in bench.yaml, which describes the product's life. The interval covers all directions and
    regimes; friction that varies with position is replaced by its mean. A value in bench.yaml
    without a range is a single point.

    `factors`: factors > 0 of the model's parameters by name, for example at another temperature;
        the ranges in bench.yaml are not multiplied.
    """
    known = model.bench.mechanics
    today = model.parameters
    identified: dict[str, tuple[Quantity, ...]] = {
        "inertia": (today.inertia,),
        "viscous": (today.viscous,),
        "coulomb": (today.coulomb,),
    }
    if model.laws is not None:
        backward, regimes = model.laws.backward, model.laws.regimes
        slopes = [slope for regime in regimes for slope in (regime.viscous, regime.backward)]
        slopes += [backward.viscous] if backward else []
        identified["viscous"] += tuple(slope for slope in slopes if slope is not None)
        identified["coulomb"] += (backward.coulomb,) if backward and backward.coulomb else ()
    box = {}
    for name, quantities in identified.items():
        factor = factors.get(name, 1.0)
        ends = [factor * end for end in hull(*quantities)]
        lifelong = getattr(known, name).interval
        box[name] = min(ends[0], lifelong[0]), max(ends[1], lifelong[1])
    return box | {"constant": hull(model.bench.actuator.constant)}


def breakaway_interval(model: Model) -> tuple[float, float] | None:
    """Return an interval of the breakaway [N m | N] that does not depend on the Coulomb friction.

    If bench.yaml has a range of the breakaway, the result covers this range and the model's
    interval. Without this range, the result is the model's interval if the logs show the breakaway
    but not the Coulomb friction. In all other cases, the result is None; the breakaway then follows
    from the Coulomb friction by `breakaway_ratio`.
    """
    today, lifelong = model.parameters, model.bench.mechanics.breakaway
    if lifelong is not None and lifelong.interval[0] < lifelong.interval[1]:
        return hull(today.breakaway, lifelong)
    if today.breakaway.source in FROM_LOGS and today.coulomb.source not in FROM_LOGS:
        return hull(today.breakaway)
    return None


def breakaway_ratio(model: Model) -> tuple[float, float]:
    """Return the range of breakaway divided by Coulomb friction, at least 1.

    The range is the intersection of two ranges. The first is the model's interval of the breakaway,
    divided by the Coulomb friction. The second spans three quotients of breakaway and Coulomb
    friction: of the lower ends, of the values, and of the upper ends of the intervals. If the
    breakaway was assumed to be 1 to 1.5 times the Coulomb friction, the result is 1 to 1.5. The
    Coulomb friction must be above 0.
    """
    breakaway, coulomb = model.parameters.breakaway, model.parameters.coulomb
    value = breakaway.value / coulomb.value
    quotients = [
        above / below if below > 0.0 else value
        for above, below in zip(breakaway.interval, coulomb.interval, strict=True)
    ]
    low, high = (end / coulomb.value for end in breakaway.interval)
    return (
        max(1.0, low, min(value, *quotients)),
        max(1.0, min(high, max(value, *quotients))),
    )


def absolute(low: float, high: float, constant: Quantity) -> tuple[float, float]:
    """Return a parameter's interval, widened by the interval of the actuator's constant.

    The parameters of a model are proportional to the actuator's constant.

    `low`, `high`: interval of the parameter for the nominal constant.
    """
    ratios = [end / constant.value for end in constant.interval]
    products = [ratio * end for ratio in ratios for end in (low, high)]
    return min(products), max(products)


def relative(low: float, high: float, constant: Quantity) -> tuple[float, float]:
    """Return the interval of a parameter as it is identified with the nominal actuator constant.

    `low`, `high`: interval of the parameter's true value, in SI.
    `constant`: nominal constant, with the interval of the true constant.
    """
    ratios = [constant.value / end for end in constant.interval]
    products = [ratio * end for ratio in ratios for end in (low, high)]
    return min(products), max(products)


def hull(*quantities: Quantity) -> tuple[float, float]:
    """Return the smallest interval that contains the intervals of all quantities."""
    return min(one.interval[0] for one in quantities), max(one.interval[1] for one in quantities)


def _over_position(
    law: FrictionOverPosition, forward: Quantity, opposite: Backward | None
) -> tuple[float, float]:
    backward = (opposite.coulomb if opposite else None) or forward
    lows, highs = [], []
    for level, powers in (
        (forward, law.coulomb.forward),
        (backward, law.coulomb.backward or law.coulomb.forward),
    ):
        normal, _ = normalise(np.array(powers), law.over.low, law.over.high)
        factors = np.polynomial.polynomial.polyval(
            np.linspace(law.over.low, law.over.high, GRID_POINTS), normal
        )
        lows.append(max(0.0, float(factors.min())) * level.interval[0])
        highs.append(float(factors.max()) * level.interval[1])
    return min(lows), max(highs)


def bench_intervals(bench: Bench) -> dict[str, tuple[float, float]]:
    """Return the interval of each parameter over the product's life, from bench.yaml only.

    The result of `intervals` contains these intervals.
    """
    known = {name: getattr(bench.mechanics, name) for name in ("inertia", "viscous", "coulomb")}
    return {
        name: quantity.interval
        for name, quantity in (known | {"constant": bench.actuator.constant}).items()
    }
