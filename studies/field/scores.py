"""Scores of an identification on the records of one machine, equally defined for every method.

- held out: force error (`frictool/identify/force_error.py`) of the fit of one record on another
  record, rms over all pairs
- across: share of the parameter intervals that overlap the interval of another record's fit
- published: number of published values inside an interval of any record, and number of published
  values that were fitted
- refused: number of records without a fit
- refused rightly: number of refused records among those that must be refused
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Gravity, Laws, Load
from frictool.documents.quantity import Estimate
from frictool.identify.fit_result import Interval
from frictool.identify.force_error import force_error, motion_rows
from frictool.identify.motion_record import MotionRecord

PLAYED = ("inertia", "viscous", "coulomb", "offset")
GRAVITY = ("sine", "cosine")  # efforts of gravity, if the bench declares it


@dataclass(frozen=True)
class FieldFit:
    """Values of the sliding parameters, intervals of identified parameters, and other laws."""

    values: dict[str, float]
    intervals: dict[str, Interval]
    laws: Laws | None = None


def has_gravity(bench: Bench) -> bool:
    """Return True if the bench declares gravity."""
    return bench.load is not None and "gravity" in bench.load.terms


def fit_of(intervals: dict[str, Interval]) -> FieldFit:
    """Return the fit of the parameters in `intervals`, by name; it includes gravity if present."""
    values = {name: one.value for name, one in intervals.items()}
    shown = {name: one for name, one in intervals.items() if name in PLAYED}
    if GRAVITY[0] not in intervals:
        return FieldFit(values, shown)
    parts = (
        Estimate(value=one.value, low=one.low, high=one.high, unit="N m", source="identified")
        for one in map(intervals.get, GRAVITY)
        if one is not None
    )
    return FieldFit(values, shown, Laws(load=Load(gravity=Gravity(*parts))))


Method = Callable[[Sequence[MotionRecord], Bench], "FieldFit | str"]


@dataclass(frozen=True)
class MethodScore:
    """Scores of one method on one machine.

    - held_out: relative force error; None without two records
    - across: share of overlapping intervals; None without a pair
    - published: (number inside an interval, number of fitted values)
    - refused: (records without a fit, records)
    - refused_rightly: (refused, records to be refused)
    - reasons: reason of each refusal
    """

    method: str
    held_out: float | None
    across: float | None
    published: tuple[int, int]
    refused: tuple[int, int]
    refused_rightly: tuple[int, int]
    reasons: tuple[str, ...]


def scored(
    name: str,
    method: Method,
    units: Sequence[Sequence[MotionRecord]],
    wrong: Sequence[Sequence[MotionRecord]],
    bench: Bench,
    published: dict[str, float],
) -> MethodScore:
    """Return the scores of a method; `wrong` are the records that it must refuse."""
    outcomes = [method(unit, bench) for unit in units]
    fits = [(index, one) for index, one in enumerate(outcomes) if isinstance(one, FieldFit)]
    rows = [motion_rows(list(unit), bench) for unit in units]
    errors = [
        error
        for index, fit in fits
        for other in range(len(units))
        if other != index and (error := force_error(rows[other], fit.values, fit.laws)) is not None
    ]
    pairs = [
        one.intervals[key].low <= other.intervals[key].high
        and other.intervals[key].low <= one.intervals[key].high
        for (_, one), (_, other) in itertools.combinations(fits, 2)
        for key in one.intervals.keys() & other.intervals.keys()
    ]
    inside = [
        fit.intervals[key].low <= value <= fit.intervals[key].high
        for _, fit in fits
        for key, value in published.items()
        if key in fit.intervals
    ]
    judged = [method(unit, bench) for unit in wrong]
    return MethodScore(
        name,
        float(np.sqrt(np.mean(np.square(errors)))) if errors else None,
        float(np.mean(pairs)) if pairs else None,
        (sum(inside), len(inside)),
        (len(units) - len(fits), len(units)),
        (sum(isinstance(one, str) for one in judged), len(judged)),
        tuple(one for one in outcomes if isinstance(one, str)),
    )
