"""Breakaway from ramps if the load over position is not known from logs of sliding.

`onset_load` describes the two ways in which such a load is treated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.breakaway.breakaway_fit import ROUNDS, BreakawayFit, fit_breakaway
from frictool.identify.breakaway.onset_detection import FEWEST_ONSETS
from frictool.identify.breakaway.onset_friction import OnsetData, onset_data
from frictool.identify.breakaway.onset_load import (
    FURTHER_ORDERS,
    SPRING_UNIT,
    OnsetLoad,
    harmonic_units,
    independent_loads,
    load_efforts,
)
from frictool.identify.breakaway.position_law import (
    BreakawayPositions,
    PolynomialOrders,
    as_good,
    fit_polynomials,
    left_out,
)
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.plant.position_load import PositionLoad
from frictool.typing import Matrix, Vector


def inseparable(load: OnsetLoad, why: str) -> UnusableLogs:
    """Return the exception for ramps that do not separate the breakaway from a declared load."""
    return UnusableLogs(
        f"these ramps cannot separate the breakaway from the declared {load.what}: {why}; add "
        "ramps in both directions at the same positions, or a log of sliding"
    )


def without_free_load(
    records: list[MotionRecord],
    bench: Bench,
    axis: Mapping[str, Interval],
    load: OnsetLoad,
) -> tuple[list[MotionRecord], dict[str, Interval]]:
    """Return the records with the fitted load as known load, and `axis` with the fitted offset.

    The load is fitted together with the offset; the load's mean over the onsets is 0.
    """
    known = dict(axis)
    for _ in range(ROUNDS if load.free else 0):
        data = onset_data_under(records, bench, axis, load)
        fit = fit_breakaway(data, {name: one.value for name, one in known.items()})
        offset, *factors = fit.solution.value[fit.structure.orders[0] + 1 :].tolist()
        offset += data.offset
        known["offset"] = Interval(offset, offset, offset)
        units = independent_loads(load.free, data.positions.position) @ factors
        mean = float(np.mean(load_efforts(load.free, data.positions.position) @ units))
        records = [
            replace(
                one,
                load=(0.0 if one.load is None else one.load)
                + load_efforts(load.free, one.position) @ units
                - mean,
            )
            for one in records
        ]
    return records, known


def onset_data_under(
    records: list[MotionRecord], bench: Bench, axis: Mapping[str, Interval], load: OnsetLoad
) -> OnsetData:
    """Return the onsets, with the polynomial orders and the loads that `load` allows in a fit."""
    data = onset_data(records, bench, axis)
    if load.constant:
        return replace(data, positions=replace(data.positions, highest=0))
    if not load.free:
        loaded = any(record.load is not None for record in records)
        return replace(data, offset=None) if loaded else data
    if data.offset is None:
        missing = "backward" if data.positions.direction[0] > 0.0 else "forward"
        raise inseparable(load, f"fewer than {FEWEST_ONSETS} are {missing}")
    loads = _fitted_efforts(load.free, data.positions.position)
    return replace(data, positions=replace(data.positions, loads=loads))


def _fitted_efforts(units: Sequence[PositionLoad], position: Vector) -> Matrix:
    """Return the efforts (n, q) of `independent_loads` at the onsets, with the mean 0."""
    efforts = load_efforts(units, position) @ independent_loads(units, position)
    return np.asarray(efforts - np.mean(efforts, axis=0))


def with_further_orders(data: OnsetData, fit: BreakawayFit) -> BreakawayFit:
    """Return a copy of `fit` with the polynomial order raised by FURTHER_ORDERS.

    The polynomials of the copy are fitted to the same friction.
    """
    order = fit.structure.orders[0] + FURTHER_ORDERS
    structure = PolynomialOrders((order, order), True)
    return replace(
        fit,
        structure=structure,
        solution=fit_polynomials(data.positions, fit.friction, structure),
    )


def load_slope(positions: BreakawayPositions, fit: BreakawayFit, bench: Bench) -> float | None:
    """Return the slope [N m/rad | N/m] of a load that explains the onsets, or None without one.

    The load is a spring or, on a rotary axis, gravity. The load is fitted together with a friction
    that is equal in both directions. Such a fit explains the onsets if it needs at most as many
    parameters as `fit`, and if its leave-one-out errors are not significantly larger. The result is
    the slope of a line fitted to the load at the onsets.
    """
    if not (np.any(positions.direction > 0.0) and np.any(positions.direction < 0.0)):
        return None
    design = positions.design(fit.structure)
    error = left_out(design, fit.friction)
    kinds = (SPRING_UNIT, harmonic_units(1.0)) if bench.axis == "rotary" else (SPRING_UNIT,)
    for units in kinds:
        loads = _fitted_efforts(units, positions.position)
        loaded = replace(positions, loads=loads)
        for order in range(design.shape[1] - len(units) - 1):
            structure = PolynomialOrders((order, order), True)
            if as_good(left_out(loaded.design(structure), fit.friction), error):
                value = fit_polynomials(loaded, fit.friction, structure).value[order + 2 :]
                slope = np.polyfit(positions.position, loads @ value, 1)[0]
                return float(slope)
    return None
