"""Load over position in the effort of ramps, from the bench and from the logs of sliding."""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.name_list import listed
from frictool.identify.axis_logs import AxisLogs
from frictool.identify.breakaway.onset_load import (
    SPRING_UNIT,
    OnsetLoad,
    harmonic_units,
    load_efforts,
    load_errors,
    load_sum,
    ripple_phases,
)
from frictool.identify.outcome import Outcome
from frictool.identify.ripple_search import missing_ripples
from frictool.identify.rows.load_terms import (
    DECLARED,
    DIRECTION,
    SPRING,
    declared_terms,
    terms_of,
    wave_number,
)
from frictool.identify.rows.omitted_parameters import unit_loads
from frictool.plant.position_load import PositionLoad
from frictool.typing import Vector

GRID_POINTS = 400  # positions over the travel at which the largest effort of a load is computed
LONGEST_NAMES = 40  # most characters that a message uses for the names of loads


def ramp_load(logs: AxisLogs, sliding: Outcome) -> OnsetLoad:
    """Return the unknown part of the load in the ramps; the field `load` of a record is known."""
    bench = logs.bench
    load = None if sliding.laws is None else sliding.laws.load
    known = terms_of(sliding.laws)
    unknown = [one for one in declared_terms(bench) if one != DIRECTION and one not in known]
    most = None if bench.load is None or bench.load.most is None else max(bench.load.most.interval)
    ripples = (
        missing_ripples(sliding.fit, logs.sliding, bench, logs.settings)
        if sliding.fit is not None and not logs.drive_off
        else ()
    )
    return OnsetLoad(
        tuple(unit for term in unknown for unit in _units(term, bench)),
        () if most is None else tuple(_largest(term, most, logs) for term in unknown),
        load_errors(load),
        tuple(ripple_phases(*ripple) for ripple in ripples),
        what=listed(list(dict.fromkeys(DECLARED[term] for term in unknown)), LONGEST_NAMES),
    )


def _units(term: str, bench: Bench) -> tuple[PositionLoad, ...]:
    return SPRING_UNIT if term == SPRING else harmonic_units(wave_number(term, bench))


def _largest(term: str, most: float, logs: AxisLogs) -> tuple[PositionLoad, ...]:
    """Return possible loads of a term, one for each phase, each with the largest effort `most`."""
    units = _units(term, logs.bench)
    efforts = load_efforts(units, _travel(term, logs))
    factors = most * unit_loads(list(efforts.T))
    return tuple(load_sum(units, sign * one) for sign in (1.0, -1.0) for one in factors)


def _travel(term: str, logs: AxisLogs) -> Vector:
    """Return positions [rad | m] over the bench's travel.

    If bench.yaml states no travel, the positions cover one period of a harmonic; for a spring, they
    are the positions of the ramps.
    """
    travel = logs.bench.mechanics.travel
    if travel is not None:
        return np.linspace(travel.low, travel.high, GRID_POINTS)
    if term == SPRING:
        return np.concatenate([record.position for record in logs.ramps])
    return np.linspace(0.0, 2.0 * np.pi / wave_number(term, logs.bench), GRID_POINTS)
