"""Warning if the requested method predicts much worse than least squares.

Both methods are fitted to each half of the logs and predict the other half (`method_comparison`).
The errors of the simulated position and of the force are compared. If the logs are too short to be
halved, or if a method refuses a half, both methods are compared on the logs to which they were
fitted. Parameters that are fixed in the model are fixed for both methods.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.estimators.method_comparison import (
    ComparedData,
    PredictionScore,
    Rows,
    regression_scores,
)
from frictool.identify.estimators.output_error import start_values
from frictool.identify.estimators.structure_selection import Sides, halves
from frictool.identify.fit_result import SlidingFit, UnusableLogs
from frictool.identify.fixed_parameter_refit import refit, with_held
from frictool.identify.force_error import SlipRows, force_error, motion_rows
from frictool.identify.methods import METHODS, REFERENCE, IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.term_selection import beyond_chance

WORSE = 2.0  # error relative to the error of least squares above which a warning is issued
# position error relative to the travel, and force error, below which no warning is issued
NEGLIGIBLE = 0.02


def method_warnings(
    records: list[MotionRecord],
    rows: Sequence[SlipRows],
    bench: Bench,
    settings: IdentificationSettings,
    fit: SlidingFit,
) -> list[str]:
    """Return a warning if least squares predict the logs much better than the method of the fit.

    `rows` contains the samples of the logs at which the axis slips (`motion_rows`).
    """
    row = METHODS[fit.method or REFERENCE]
    if (
        row.name == REFERENCE
        or row.whole_curve
        or any(record.velocity is not None for record in records)
    ):
        return []
    # output error minimises the position error itself, and its search would take long for each half
    if row.known_terms is not None:
        return _warnings(
            fit,
            "the logs",
            _force_line(fit.force_error, _reference_force(records, rows, bench, settings, fit)),
        )
    scores, how = _scores(records, rows, bench, settings, fit)
    if scores is None:
        return []
    requested, reference = scores
    lines = _force_line(requested.force, reference.force)
    least = max(
        WORSE * reference.position,
        NEGLIGIBLE * max(float(np.ptp(record.position)) for record in records),
    )
    certain = beyond_chance(reference.squares, requested.squares, settings.confidence)
    if (
        certain
        and requested.position > least
        and (fit.laws is None or not (fit.laws.regimes or fit.laws.position))
    ):
        unit = si_unit("position", bench.axis)
        lines += [
            f"the rms error of the simulated position is {requested.position:.3g} {unit} instead "
            f"of {reference.position:.3g} {unit}"
        ]
    return _warnings(fit, how, lines)


def _warnings(fit: SlidingFit, how: str, lines: list[str]) -> list[str]:
    return [
        f"{fit.method} predicts {how} worse than {REFERENCE}: {line}; use --method auto"
        for line in lines
    ]


def _force_line(requested: float | None, reference: float | None) -> list[str]:
    if requested is None or reference is None or requested <= max(WORSE * reference, NEGLIGIBLE):
        return []
    return [f"the force error is {100 * requested:.3g} % instead of {100 * reference:.3g} %"]


def _reference_force(
    records: list[MotionRecord],
    rows: Sequence[SlipRows],
    bench: Bench,
    settings: IdentificationSettings,
    fit: SlidingFit,
) -> float | None:
    try:
        reference = refit(records, bench, settings, replace(fit, method=REFERENCE), fit.fixed)
    except UnusableLogs:
        return None
    return force_error(rows, start_values(reference, bench), reference.laws)


def _scores(
    records: list[MotionRecord],
    rows: Sequence[SlipRows],
    bench: Bench,
    settings: IdentificationSettings,
    fit: SlidingFit,
) -> tuple[tuple[PredictionScore, PredictionScore] | None, str]:
    """Return the scores of the fit's method and of least squares, and the name of the scored data.

    The scores are None if one of the two methods refuses the data.
    """
    fits = [fit, replace(fit, method=REFERENCE)]
    fixed_settings = with_held(settings, fit, fit.fixed)
    sides = halves(records)
    choices: list[tuple[Sides, Rows, str]] = [((records, records), [rows, rows], "the logs")]
    if sides is not None:
        both = [motion_rows(side, bench) for side in sides]
        choices.insert(0, (sides, both, "strokes left out of the fit"))
    for compared, rows_of, how in choices:
        scores = regression_scores(
            compared, rows_of, ComparedData(records, bench, fixed_settings, fits)
        )
        if len(scores) == len(fits):
            return (scores[0], scores[1]), how
    return None, ""
