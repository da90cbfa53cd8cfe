"""Choice of load terms by cross-validation of simulated models on halves of the records.

Each record is cut into halves at the reversal nearest to its middle, where a simulation can begin
at rest. A model that is fitted to one half by output error simulates the other half. Load terms
(`load_terms`) are added to inertia, viscous friction, Coulomb friction and offset one at a time. A
term is kept if the squared errors of the predicted strokes decrease significantly (Student's test
of paired strokes), and if the rms error of the predicted strokes falls by a fifth or more.

If the bench declares its load terms, exactly these terms are used. If the logs are too short for
halves, no term is added. Long records are simulated in evenly spaced parts only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.estimators.segment_simulation import SegmentSimulation, estimate
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.term_selection import clearly_better
from frictool.identify.rows.load_terms import declared_terms, possible
from frictool.identify.rows.segments import (
    FEWEST_SAMPLES,
    RecordSegment,
    gap_free_segments,
    of_each_record,
    thinned,
)
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Vector

Sides = tuple[list[MotionRecord], list[MotionRecord]]
FEWEST_STROKES = 4  # least number of strokes in a record that is cut: two in each half
MOST_COMPARED = 300_000  # largest number of simulated samples in a half


def halves(records: Sequence[MotionRecord]) -> Sides | None:
    """Return the halves of the records, cut at the reversal nearest to the middle of each record.

    Return None if a record has too few strokes or samples.
    """
    before, after = [], []
    for record in records:
        number = find_strokes(record).number
        starts = np.flatnonzero(np.diff(number)) + 1
        if starts.size + 1 < FEWEST_STROKES:
            return None
        cut = int(starts[np.argmin(np.abs(starts - number.size // 2))])
        if not FEWEST_SAMPLES < cut < number.size - FEWEST_SAMPLES:
            return None
        before.append(record.part(slice(0, cut)))
        after.append(record.part(slice(cut, None)))
    return before, after


@dataclass(frozen=True)
class HeldOutPrediction:
    """Prediction of each half of the records by a model fitted to the other half.

    - terms: load terms of the model
    - squares: mean square of the position error in each stroke, (s,), rad^2 | m^2
    - values: parameters fitted to each half, SI
    - errors: rms prediction error [rad | m] of each compared set of load terms. A key consists of
      the names of the terms, joined by "_"; "sliding" is the key without terms.
    """

    terms: tuple[str, ...]
    squares: Vector
    values: tuple[dict[str, float], ...]
    errors: dict[str, float]


def predict_halves(
    sides: Sides, bench: Bench, terms: tuple[str, ...], known: Mapping[str, float]
) -> HeldOutPrediction:
    """Return the prediction of each half of the records by a simulation fitted to the other half.

    `known` are the start values of the parameters, SI.
    """
    squares, values = [], []
    for seen, unseen in (sides, (sides[1], sides[0])):
        estimated = estimate(
            SegmentSimulation(comparison_segments(seen), bench, terms), known
        ).values
        squares.append(
            stroke_squares(SegmentSimulation(comparison_segments(unseen), bench, terms), estimated)
        )
        values.append(estimated)
    together = np.concatenate(squares)
    return HeldOutPrediction(
        terms,
        together,
        tuple(values),
        {"_".join(terms) or "sliding": float(np.sqrt(np.mean(together)))},
    )


def comparison_segments(side: Sequence[MotionRecord]) -> list[RecordSegment]:
    """Return segments of the records `side` with at most MOST_COMPARED samples in total."""
    return thinned(gap_free_segments(side), MOST_COMPARED)


def stroke_squares(simulated: SegmentSimulation, values: Mapping[str, float]) -> Vector:
    """Return the mean square of the simulation's residual in each stroke, (s,).

    Raises UnusableLogs if the records are too short for a segment.
    """
    if not simulated.segments:
        raise UnusableLogs(
            "the records are too short to compare simulated strokes; record more strokes"
        )
    out = []
    for segment, strokes in zip(
        simulated.segments, of_each_record(simulated.segments, find_strokes), strict=True
    ):
        residual = simulated.of_segment(segment, values)
        number = strokes.number[segment.first : segment.last]
        starts = np.flatnonzero(np.diff(number, prepend=-1))
        out.append(np.add.reduceat(residual**2, starts) / np.diff(np.append(starts, number.size)))
    return np.concatenate(out)


def choose_terms(
    records: Sequence[MotionRecord], bench: Bench, known: Mapping[str, float], confidence: float
) -> tuple[tuple[str, ...], dict[str, float]]:
    """Return the best load terms, and the rms prediction error [rad | m] of each set of terms.

    `known` are the start values of the parameters, SI.
    """
    sides = halves(records)
    if sides is None:
        return declared_terms(bench), {}
    structure = choose_structure(sides, bench, known, confidence)
    return structure.terms, structure.errors


def choose_structure(
    sides: Sides, bench: Bench, known: Mapping[str, float], confidence: float
) -> HeldOutPrediction:
    """Return the prediction with the best load terms, or with the load terms of the bench.

    `known` are the start values of the parameters, SI.
    """
    best = predict_halves(sides, bench, declared_terms(bench), known)
    errors = dict(best.errors)
    for term in () if bench.load is not None else possible(bench):
        try:
            tried = predict_halves(sides, bench, (*best.terms, term), known)
        except UnusableLogs:
            continue
        errors |= tried.errors
        if clearly_better(tried.squares, best.squares, confidence):
            best = tried
    return replace(best, errors=errors)
