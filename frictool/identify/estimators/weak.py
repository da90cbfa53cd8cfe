"""Weak (integral) form: the equation of motion times test functions (1 - s^2)^3, integrated.

    inertia int(phi'' x) + viscous int(phi x') + coulomb int(phi sign v) + offset int(phi)
        = int(phi u)

x is the position, v the velocity, u the effort, phi the test function, and s the time in a window,
scaled to [-1, 1]. Only phi is differentiated, by its exact second difference. Successive windows
start a sixth of their length apart.

Columns for friction that depends on the position, and for knees (speeds at which the viscous
friction changes), are added if they improve the prediction of strokes that the fit did not use
(`weak_structure`). Coulomb friction and offset are then means over the range of positions, and the
viscous friction is the coefficient below the first knee.

The expected precision (assess/weak_form_precision.py) determines the length of the window, and
whether the inertia is identifiable. The encoder's noise makes the fitted inertia too small. The
error of the inertia is largest if the noise is white. Half of this largest error is added to the
inertia, and its interval is widened by the same half on either side. If strokes repeat each other,
nothing is added, and the interval is widened by the whole largest error on either side.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.identify.assess.identifiability import QUANTILE, percent
from frictool.identify.assess.recorded_motion import recorded_facts
from frictool.identify.assess.weak_form_precision import weak_deviation
from frictool.identify.estimators.sines import not_negative, regime
from frictool.identify.estimators.weak_structure import (
    FrictionStructure,
    choose_structure,
    with_structure,
)
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.rows.friction_columns import (
    FrictionRows,
    knee_column,
    position_columns,
    rows_of,
)
from frictool.identify.rows.quantisation_limit import hidden_by_noise
from frictool.identify.rows.regression_samples import (
    RegressionSamples,
    fit,
    joined,
    parameters_of,
    with_fixed,
)
from frictool.identify.rows.slip_fit import slipping_mask, slipping_rows
from frictool.identify.rows.smoothing import smoothed_by
from frictool.identify.rows.strokes import find_strokes
from frictool.plant.weak_form import sampled_test_function

OVERLAP = 6  # windows per window length; each starts a sixth of its length after the previous one
# least ratio of clusters to strokes; below this ratio, most strokes repeat each other
REPEATED = 0.5


def weak(records: list[MotionRecord], bench: Bench, settings: IdentificationSettings) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset by the weak form.

    Raises UnusableLogs if the axis does not slip during any whole window.
    """
    facts = recorded_facts(records, bench)
    axis = facts.axis
    sensing = facts.sensing
    strokes = list(facts.strokes)
    deviation, window = weak_deviation(strokes, axis, sensing, settings.window)
    samples, parts = _windows(records, bench, window)
    if samples.velocity.size == 0:
        raise UnusableLogs(
            "the axis never slips throughout a window of the weak form; record longer strokes"
        )
    structure = FrictionStructure()
    if parameters_of(samples) == (SLIDING, {}):
        structure = choose_structure(samples, parts, OVERLAP, settings.confidence)
    samples = _chosen(samples, parts, structure)
    # the columns of position and knees explain a part of the acceleration; a longer window is then
    # better
    if structure != FrictionStructure():
        share = samples.unexplained_acceleration**2 / float(np.mean(samples.acceleration**2))
        deviation, window = weak_deviation(strokes, axis, sensing, settings.window, share)
        samples = _chosen(*_windows(records, bench, window), structure)
    details: dict[str, float | int] = {
        "window": window,
        "position_order": structure.order,
        "knees": len(structure.knees),
    }
    samples = with_fixed(samples, settings.fixed)
    result = fit(samples, np.ones(samples.velocity.size), OVERLAP, settings.confidence, details)
    result = _identified(result, structure, bench, settings.fixed)
    if "inertia" in settings.fixed:
        return result
    precision = QUANTILE * float(deviation[0]) / axis.inertia
    known = facts.known.get("inertia", 1.0)
    if precision >= known:
        kept = {name: interval for name, interval in result.parameters.items() if name != "inertia"}
        reason = (
            f"the weak form over {window} samples would give the inertia to {percent(precision)}; "
            f"needed: below {percent(known)}, the precision in the bench"
        )
        return replace(result, parameters=kept, refused={**result.refused, "inertia": reason})
    second = np.convolve(sampled_test_function(window), [1.0, -2.0, 1.0]) / sensing.period**2
    noise = sensing.step / math.sqrt(12.0) * float(np.linalg.norm(second))
    unexplained = samples.unexplained_acceleration
    if hidden_by_noise(noise, unexplained, bench):
        kept = {name: interval for name, interval in result.parameters.items() if name != "inertia"}
        shown = f"{100.0 * min(noise / unexplained, 1.0) ** 2:.3g} %"
        reason = (
            f"noise of the encoder may be {shown} of the mean square of the acceleration that "
            "friction does not explain; record a test with changing speed (excite --kind sines)"
        )
        return replace(result, parameters=kept, refused={**result.refused, "inertia": reason})
    inertia = _widened(result, (noise / unexplained) ** 2, settings.confidence)
    return replace(result, parameters={**result.parameters, "inertia": inertia})


def _widened(fit: SlidingFit, noise: float, confidence: float) -> Interval:
    inertia = fit.parameters["inertia"]
    if not np.isfinite(inertia.half_width):
        return inertia
    share = abs(inertia.value) * noise
    repeated = fit.details["clusters"] < REPEATED * fit.details["strokes"]
    put_back, unsure = (0.0, share) if repeated else (0.5 * share, 0.5 * share)
    half = half_width(
        confidence,
        inertia.half_width / float(scipy.special.ndtri(0.5 + 0.5 * confidence)),
        [unsure],
    )
    value = inertia.value + put_back
    return Interval.around(value, half)


def _windows(
    records: list[MotionRecord], bench: Bench, window: int
) -> tuple[RegressionSamples, list[FrictionRows]]:
    """Return the regression rows of all windows, and signals of each record.

    The regression rows have the columns of all position polynomials. The columns of knees (speeds
    at which the viscous friction changes) are computed later from the signals.
    """
    every = max(1, window // OVERLAP)
    low, high = (
        float(end([end(record.position) for record in records])) for end in (np.min, np.max)
    )
    samples, parts = [], []
    for record in records:
        strokes = find_strokes(record)
        signals = smoothed_by(record, sampled_test_function(window))
        rows = rows_of(
            record,
            strokes.sign,
            slipping_mask(record, strokes, bench, signals[1], window, every),
            window,
        )
        window_rows = slipping_rows(record, bench, window, signals, every)
        samples.append(
            replace(
                window_rows,
                loads={**window_rows.loads, **position_columns(record, rows, low, high)},
            )
        )
        parts.append(rows)
    return joined(samples), parts


def _chosen(
    samples: RegressionSamples, parts: list[FrictionRows], structure: FrictionStructure
) -> RegressionSamples:
    """Return the samples with the columns of the friction over position and speed in `structure`.

    For knee j, the column `bend_j` belongs to the viscous friction up to the next knee. The column
    `knee_j` is the derivative of the friction with respect to the speed of the knee.
    """
    chosen = with_structure(samples, parts, structure)
    pieces = [samples.velocity]
    for j in range(1, len(structure.knees) + 1):
        pieces[-1] = pieces[-1] - chosen.loads[f"bend_{j}"]
        pieces.append(chosen.loads[f"bend_{j}"])
    loads = {**chosen.loads, **{f"bend_{j}": piece for j, piece in enumerate(pieces[1:], start=1)}}
    loads |= {
        f"knee_{j}": knee_column(parts, knee) for j, knee in enumerate(structure.knees, start=1)
    }
    return replace(chosen, velocity=pieces[0], loads=loads)


def _identified(
    fitted: SlidingFit, structure: FrictionStructure, bench: Bench, fixed: Mapping[str, Interval]
) -> SlidingFit:
    every = fitted.parameters
    regimes = []
    slope = {**fixed, **every}["viscous"].value
    for j, knee in enumerate(structure.knees, start=1):
        above, moved = every[f"bend_{j}"], every[f"knee_{j}"]
        reach = moved.half_width / abs(above.value - slope)
        slope = above.value
        regimes.append(
            regime(knee, reach, Interval(above.value, max(above.low, 0.0), above.high), bench)
        )
    sliding = {name: interval for name, interval in every.items() if name in SLIDING}
    if regimes and "viscous" in sliding:
        sliding["viscous"] = not_negative(sliding["viscous"])
    return replace(
        fitted,
        parameters=sliding,
        laws=Laws(regimes=tuple(regimes)) if regimes else None,
        why=_why(structure),
    )


def _why(structure: FrictionStructure) -> str | None:
    parts = (
        [f"over the position (polynomials of order {structure.order})"] if structure.order else []
    )
    parts += [f"above a speed of {knee:.4g}" for knee in structure.knees]
    return (
        f"friction has terms {' and '.join(parts)}, which improve the prediction of strokes"
        if parts
        else None
    )
