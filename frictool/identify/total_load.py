"""Interval of the total load: the sum of the offset and of all loads over the position.

On a short travel, offset and loads over the position are nearly collinear. Their separate intervals
are then much wider than the interval of their sum. The total load is a sum of d functions of the
position, each times a coefficient. The values of the total at d positions, the nodes, therefore
determine the total at every position:

    total(x) = sum over nodes l_j(x) total(x_j)

l_j is the combination of the d functions that is 1 at node j and 0 at the other nodes. For each
node, the columns of the loads are shifted so that they are 0 at the node. The offset of this fit is
the total load at the node. Its interval is widened for effects that the model lacks
(`unmodelled_effects.py`), and for the intervals of the fixed parameters. At a position x, the
interval of the total is the sum of the nodes' intervals, each times l_j(x).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import msgspec
import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.documents.laws import Load, TotalLoad
from frictool.documents.quantity import Estimate, Quantity, Span, si_unit
from frictool.identify.breakaway.onset_load import CONSTANT, load_efforts
from frictool.identify.effect_regression import effect_regression, load_units
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.load_terms import TERMS, load_values
from frictool.identify.unmodelled_effects import widened
from frictool.typing import Matrix, Vector

PER_PERIOD = 32  # number of positions in the shortest period of a load
FEWEST_POSITIONS, MOST_POSITIONS = 65, 4097
WHOLE = 1e-6  # largest deviation of a ratio of wave numbers from a whole number
DEPENDENT = 1e-9  # least ratio of the smallest to the largest pivot of independent loads


def total_load(
    fit: SlidingFit,
    offset: Interval,
    records: Sequence[MotionRecord],
    bench: Bench,
    confidence: float,
) -> TotalLoad | None:
    """Return the total load over the travel, or over the common period of the loads.

    The common period (of all ripples and gravity) is used if bench.yaml states no travel.

    - fit: fit with a load over the position
    - offset: offset of the model

    Return None in these cases:

    - The fit has no load.
    - The logs do not determine a load that the bench declares, or the interval of the total.
    - bench.yaml states no travel, and the loads have no common period.
    """
    load = None if fit.laws is None else fit.laws.load
    hidden = {name for names in TERMS.values() for name in names} & fit.refused.keys()
    if load is None or "offset" not in fit.parameters or hidden:
        return None
    positions = _positions(load, bench)
    if positions is None:
        return None
    known = load_values(fit.laws)
    waves = tuple(2.0 * np.pi * one.cycles / one.per.value for one in load.ripples)
    units = [CONSTANT]
    factors = [offset.value]
    for term, parts in load_units(waves).items():
        for name, unit in zip(TERMS[term], parts, strict=True):
            if name in known:
                units.append(unit)
                factors.append(known[name])
    efforts = load_efforts(units, positions)
    nodes = _nodes(efforts)
    if nodes is None:
        return None
    mechanics = msgspec.structs.replace(bench.mechanics, offset=None)
    free = msgspec.structs.replace(bench, mechanics=mechanics)
    value = efforts @ np.array(factors)
    ends = []
    for node in nodes:
        zero = float(positions[node])
        interval = _at(fit, zero, float(value[node]), records, free, confidence)
        if interval is None:
            return None
        ends.append((interval.low - value[node], interval.high - value[node]))
    weights = efforts @ np.linalg.inv(efforts[nodes])
    below, above = np.array(ends).T
    low = value + np.sum(np.minimum(weights * below, weights * above), axis=1)
    high = value + np.sum(np.maximum(weights * below, weights * above), axis=1)
    return _document(positions, value, low, high, bench)


def _positions(load: Load, bench: Bench) -> Vector | None:
    """Return positions (n,) [rad | m] over the travel, or over the common period of the loads."""
    waves = [2.0 * np.pi * one.cycles / one.per.value for one in load.ripples]
    waves += [] if load.gravity is None else [1.0]
    travel = bench.mechanics.travel
    if travel is not None:
        low, high = travel.low, travel.high
    elif load.stiffness is not None or not waves:
        return None
    else:
        ratios = np.array(waves) / min(waves)
        if np.any(np.abs(ratios - np.round(ratios)) > WHOLE):
            return None
        low, high = 0.0, 2.0 * np.pi / min(waves)
    periods = (high - low) * max(waves, default=0.0) / (2.0 * np.pi)
    count = int(min(max(PER_PERIOD * periods, FEWEST_POSITIONS), MOST_POSITIONS))
    return np.linspace(low, high, count)


def _nodes(efforts: Matrix) -> list[int] | None:
    """Return the position index of each node for the efforts (n, d) of d loads.

    The module docstring defines the nodes. Return None if the loads are linearly dependent.
    """
    scaled = efforts / np.max(np.abs(efforts), axis=0)
    _, triangle, order = scipy.linalg.qr(scaled.T, pivoting=True, mode="economic")
    size = np.abs(np.diag(triangle))
    if size.size < efforts.shape[1] or size[-1] <= DEPENDENT * size[0]:
        return None
    return [int(k) for k in order[: efforts.shape[1]]]


def _at(
    fit: SlidingFit,
    zero: float,
    value: float,
    records: Sequence[MotionRecord],
    bench: Bench,
    confidence: float,
) -> Interval | None:
    """Return the interval of the total load around `value` at the position `zero` [rad | m]."""
    centred = replace(fit, load_zero=zero)
    regression = effect_regression(centred, records, bench, confidence)
    fitted = None if regression is None else regression.intervals().get("offset")
    if regression is None or fitted is None or not np.isfinite(fitted.half_width):
        return None
    rows = regression.rows
    names = [rows.names[k] for k in rows.columns(regression.used)]
    table = rows.table(regression.used)
    columns: Mapping[str, Vector] = dict(zip(SLIDING, rows.samples.columns, strict=True))
    half = fitted.half_width + abs(fitted.value - value)
    for name, one in rows.samples.fixed.items():
        slope = np.linalg.lstsq(table, columns[name], rcond=None)[0][names.index("offset")]
        half = float(np.hypot(half, slope * max(one.high - one.value, one.value - one.low)))
    parameters = {**fit.parameters, "offset": Interval.around(value, half)}
    wide = widened(replace(centred, parameters=parameters), records, bench, confidence)
    return wide.fit.parameters["offset"]


def _document(
    positions: Vector, value: Vector, low: Vector, high: Vector, bench: Bench
) -> TotalLoad:
    unit, length = si_unit("effort", bench.axis), si_unit("position", bench.axis)
    least, largest = (
        Estimate(float(pick(value)), float(pick(low)), float(pick(high)), unit, source="identified")
        for pick in (np.min, np.max)
    )
    return TotalLoad(
        least,
        largest,
        Quantity(float(np.max(np.maximum(high - value, value - low))), unit=unit),
        None
        if bench.mechanics.travel is None
        else Span(float(positions[0]), float(positions[-1]), length),
    )
