"""Fits of the smoothed samples at which the axis certainly slips, with any weights.

An inertia that cannot be identified remains a parameter of the regression. Over whole strokes, the
acceleration is nearly orthogonal to the velocity and to the sign of the velocity, so that the
inertia hardly widens the other intervals.

Noise makes the fitted inertia too small. If all strokes have the same speed, only the samples near
reversals separate viscous from Coulomb friction. The error of the inertia then shifts viscous and
Coulomb friction. If rounding errors with the worst signs would hide the inertia, the intervals of
the other parameters therefore include the values fitted with the inertia without this error
(`_unattenuated`), and the decrease of the inertia is computed by rounding the smoothed motion again
(`repeated_rounding`). If noise may hide the inertia completely (`hidden_by_noise`), the other
parameters are fitted with the inertia in bench.yaml, and their intervals include the range of this
inertia.

The smoothing window is chosen twice. The first window is so long that noise hardly changes the
fitted inertia. The second is the shortest window with which noise decreases the fitted inertia by
less than a fifth of the standard deviation of the inertia. A short window loses fewer samples near
reversals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, once_per_record
from frictool.identify.rows.effects import SmoothedMotion
from frictool.identify.rows.load_columns import load_columns
from frictool.identify.rows.load_terms import HARMONICS, SPRING, TERMS, with_laws
from frictool.identify.rows.position_orders import orders_above, weak_orders
from frictool.identify.rows.quantisation_limit import hidden_by_noise, refuse_hidden_inertia
from frictool.identify.rows.regression_samples import (
    RegressionSamples,
    fit,
    joined,
    with_fixed,
    without_loads,
)
from frictool.identify.rows.repeated_rounding import UsedRows, inertia_change
from frictool.identify.rows.slip_mask import keep_rows, slip_mask
from frictool.identify.rows.smoothing import (
    acceleration_response,
    choose_window,
    measurement_noise,
    smoothed,
)
from frictool.identify.rows.strokes import Strokes, find_strokes
from frictool.identify.rows.temperature_law import with_temperature_law
from frictool.typing import Vector

# smallest and largest share of noise in the acceleration (`smoothing`); this noise decreases the
# inertia by 0.006 % and 1 %
SMALLEST_SHARE, LARGEST_SHARE = (0.0075, 0.1)
WITH_BENCH_INERTIA = (
    "the loads over the position are fitted with the bench's inertia; their intervals include "
    "its range"
)
BIAS_SHARE = 0.2  # largest decrease of the inertia by noise, relative to its standard deviation

# function that takes samples and their smoothing window, and returns a fit
Fitting = Callable[[RegressionSamples, int], SlidingFit]


def weighted_fit(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    weigh: Callable[[RegressionSamples], Vector],
    droppable: tuple[str, ...] = (),
) -> SlidingFit:
    """Return the least-squares fit of slipping samples, weighted by `weigh(samples)` (n,).

    Parameters in `droppable` that do not improve the prediction are set to 0. Raises UnusableLogs
    if no slip is as long as a smoothing window.
    """

    def fitting(rows: RegressionSamples, used: int) -> SlidingFit:
        def fitted(some: RegressionSamples) -> SlidingFit:
            return fit(some, weigh(some), used, settings.confidence, {"window": used}, droppable)

        left_out = orders_above(settings.position_order) & rows.loads.keys()
        result = fitted(without_loads(rows, left_out))
        weak = weak_orders(result.parameters, settings.confidence)
        if weak:
            left_out = left_out.union(weak)
            result = fitted(without_loads(rows, left_out))
        return replace(result, dropped=(*result.dropped, *sorted(left_out)))

    return slipping_fit(records, bench, settings, fitting)


def slipping_fit(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings, fitting: Fitting
) -> SlidingFit:
    """Fit the samples at which the axis certainly slips by the function `fitting`.

    If the encoder is too coarse for the inertia, the inertia is reported as not identified. Raises
    UnusableLogs if no slip is as long as a smoothing window.
    """
    share = SMALLEST_SHARE
    samples, used = slipping(records, bench, share, settings.window)
    result = fitting(with_fixed(samples, settings.fixed), used)
    bearable = _bearable_share(result, settings.confidence) * _unexplained_share(samples)
    if settings.window is None and bearable > share and shortest_window(records, bearable) < used:
        share = bearable
        del samples  # frees the memory of a long log before the next samples are computed
        samples, used = slipping(records, bench, share, None)
        result = fitting(with_fixed(samples, settings.fixed), used)
    attenuation = _attenuation(result, with_fixed(samples, settings.fixed))
    if attenuation > _bearable_share(result, settings.confidence) ** 2:
        result = replace(result, attenuation=attenuation)
    response = acceleration_response(records[0], used)
    unexplained = samples.unexplained_acceleration
    checked = refuse_hidden_inertia(
        result, records[0], bench, response, unexplained, f"over {used} samples"
    )
    inertia = result.parameters.get("inertia")
    if inertia is not None and "inertia" not in checked.parameters:
        noise = measurement_noise(records[0]) * float(np.linalg.norm(response))
        measured = records[0].velocity is not None
        if measured or inertia.value <= 0.0 or hidden_by_noise(noise, unexplained, bench):
            fixed = {**settings.fixed, "inertia": known_inertia(bench)}
            loaded = _unexplained_share(samples) < 1.0
            known = fitting(with_fixed(samples, fixed), used)
            reason = checked.refused["inertia"] + (f"; {WITH_BENCH_INERTIA}" if loaded else "")
            checked = replace(known, refused={**known.refused, "inertia": reason})
        else:
            fixed = {**settings.fixed, "inertia": _unattenuated(result, unexplained, noise, bench)}
            wider = _widened_to(result, fitting(with_fixed(samples, fixed), used))
            parts = _used_rows(records, bench, share, settings.window)
            rounding = inertia_change(result, samples, parts) / inertia.value
            lost = max(result.attenuation, (noise / unexplained) ** 2) + rounding
            checked = replace(wider, attenuation=lost)
    return with_temperature_law(with_laws(checked, bench), records)


def _attenuation(result: SlidingFit, samples: RegressionSamples) -> float:
    """Return the relative decrease of the fitted inertia by noise of the acceleration; at most 1.

    The noise is the white noise of the position, filtered like the acceleration, but at most the
    residual divided by the inertia. This limit matters in slow motion: rounding errors then last
    several samples, and the filter removes them better than white noise.
    """
    inertia = result.parameters.get("inertia")
    unexplained = samples.unexplained_acceleration
    if inertia is None or inertia.value <= 0.0 or unexplained == 0.0:
        return 0.0
    left = result.residual * float(np.sqrt(np.mean(samples.effort**2))) / inertia.value
    return min((min(samples.noise, left) / unexplained) ** 2, 1.0)


def _unattenuated(result: SlidingFit, unexplained: float, noise: float, bench: Bench) -> Interval:
    """Return the fitted inertia with an interval that includes the inertia without noise.

    Noise of the acceleration with the rms `noise` multiplies the inertia by 1 -
    (noise/unexplained)^2, where `unexplained` is the rms of the acceleration that the other
    regressors do not explain. The upper end of the result is at most the upper end in bench.yaml
    or, if larger, the upper end of the fitted interval.
    """
    fitted = result.parameters["inertia"]
    left = max(1.0 - noise**2 / unexplained**2, 0.0)
    most = max(known_inertia(bench).high, fitted.high)
    full = min(fitted.value / left, most) if left > 0.0 else most
    return Interval(fitted.value, fitted.low, max(fitted.high, full))


def _widened_to(fit: SlidingFit, other: SlidingFit) -> SlidingFit:
    wider = {
        name: Interval.around(one.value, other.parameters[name].half_width)
        for name, one in fit.parameters.items()
        if name in other.parameters and other.parameters[name].half_width > one.half_width
    }
    return replace(fit, parameters={**fit.parameters, **wider})


def _unexplained_share(samples: RegressionSamples) -> float:
    """Return the fraction of the rms acceleration that the other regressors do not explain.

    The fraction is 1 if no declared load depends on the position. A load that depends on the
    position may explain a part of the inertial effort, because the position has less noise than the
    acceleration.
    """
    if not any(name in samples.loads for term in (SPRING, *HARMONICS) for name in TERMS[term]):
        return 1.0
    return samples.unexplained_acceleration / float(np.sqrt(np.mean(samples.acceleration**2)))


def known_inertia(bench: Bench) -> Interval:
    """Return the inertia in bench.yaml.

    If bench.yaml states no interval, 0 to twice the value is assumed.
    """
    known = bench.mechanics.inertia
    return Interval(
        known.value, *(known.interval if known.low is not None else (0.0, 2.0 * known.value))
    )


def _bearable_share(result: SlidingFit, confidence: float) -> float:
    """Return the largest allowed ratio of rms noise to rms acceleration, at most LARGEST_SHARE.

    With this ratio, noise decreases the inertia by BIAS_SHARE times the inertia's standard
    deviation.
    """
    inertia = result.parameters.get("inertia")
    if inertia is None or inertia.value <= 0.0:
        return LARGEST_SHARE
    deviation = (
        inertia.half_width / float(scipy.special.ndtri(0.5 + 0.5 * confidence)) / inertia.value
    )
    return min(float(np.sqrt(BIAS_SHARE * deviation)), LARGEST_SHARE)


@once_per_record
def stroke_samples(record: MotionRecord) -> float:
    """Return the median length of the record's strokes in samples; 0 without motion."""
    strokes = find_strokes(record)
    lengths = np.bincount(strokes.number[strokes.sign != 0.0], minlength=1)
    return float(np.median(lengths[lengths > 0])) if lengths.any() else 0.0


def shortest_window(records: list[MotionRecord], share: float) -> int:
    """Return the shortest smoothing window [samples] that bounds the noise in every record.

    In each record, the ratio of the rms noise of the acceleration to the rms acceleration is at
    most `share`.
    """
    return max(choose_window(record, stroke_samples(record), share) for record in records)


def slipping_window(records: list[MotionRecord], window: int | None) -> int:
    """Return `window` or, if it is None, a smoothing window [samples] that suits all records.

    Raises UnusableLogs if the axis never moves by more than one encoder count.
    """
    if all(stroke_samples(record) == 0.0 for record in records):
        raise UnusableLogs(
            "the axis never moves by more than one encoder count; record longer strokes"
        )
    return window or shortest_window(records, SMALLEST_SHARE)


def slipping(
    records: list[MotionRecord], bench: Bench, share: float, window: int | None
) -> tuple[RegressionSamples, int]:
    """Return the samples at which the axis certainly slips, and the longest smoothing window.

    - share: allowed ratio of noise to acceleration, from which the window of each record follows
    - window: smoothing window for all records, samples; None for windows that follow from `share`

    Raises UnusableLogs if no slip is as long as a smoothing window.
    """
    parts, windows = [], []
    for record in records:
        length = stroke_samples(record)
        if length == 0.0:
            continue
        used = window or choose_window(record, length, share)
        rows = slipping_rows(record, bench, used, smoothed(record, used))
        response = acceleration_response(record, used)
        noise = measurement_noise(record) * float(np.linalg.norm(response))
        parts.append(replace(rows, noise=noise))
        windows.append(used)
    if sum(part.velocity.size for part in parts) == 0:
        backlash = " outside the backlash" if full_backlash(bench) else ""
        raise UnusableLogs(
            f"the axis never slips{backlash} throughout a smoothing window; record longer strokes"
        )
    return joined(parts), max(windows)


def _used_rows(
    records: list[MotionRecord], bench: Bench, share: float, window: int | None
) -> list[UsedRows]:
    """Return the rows of each record that `slipping` returns for the same arguments."""
    parts = []
    for record in records:
        length = stroke_samples(record)
        if length > 0.0:
            used = window or choose_window(record, length, share)
            velocity = smoothed(record, used)[1]
            mask = slipping_mask(record, find_strokes(record), bench, velocity, used, 1)
            parts.append(UsedRows(record, used, mask))
    return parts


def full_backlash(bench: Bench) -> float:
    """Return the largest full width of the bench's backlash, rad | m."""
    width = bench.mechanics.backlash
    return 0.0 if width is None else max(width.interval)


def slipping_mask(
    record: MotionRecord, strokes: Strokes, bench: Bench, velocity: Vector, window: int, every: int
) -> NDArray[np.bool_]:
    """Return a mask (n,) of the samples in whose smoothing window the axis certainly slips.

    Only one in `every` samples can be in the mask. `velocity` (n,) is smoothed over `window`.
    """
    mask = slip_mask(record, strokes, velocity, window, full_backlash(bench))
    if every > 1:
        mask[np.arange(mask.size) % every != 0] = False
    return mask


def slipping_rows(
    record: MotionRecord,
    bench: Bench,
    window: int,
    signals: tuple[Vector, Vector, Vector],
    every: int = 1,
) -> RegressionSamples:
    """Return a regression row for each sample in whose window the axis certainly slips.

    Only one in `every` samples is used. `signals` are the smoothed acceleration, velocity and
    effort, each (n,); the arrays are overwritten to save memory.
    """
    strokes = find_strokes(record)
    mask = slipping_mask(record, strokes, bench, signals[1], window, every)
    loads = load_columns(SmoothedMotion(record, window, *signals, strokes.sign, mask), bench)
    for values in (*signals, strokes.sign, strokes.number):
        keep_rows(mask, values)
    kept = np.count_nonzero(mask)
    acceleration, velocity, effort = (values[:kept] for values in signals)
    counts = np.abs(velocity) * (every * record.period / record.resolution)
    offset = bench.mechanics.offset
    terms = None if bench.load is None else bench.load.terms
    known = None if offset is None else Interval(offset.value, *offset.interval)
    most = None if bench.load is None or bench.load.most is None else bench.load.most.value
    return RegressionSamples(
        acceleration,
        velocity,
        effort,
        strokes.number[:kept],
        strokes.sign[:kept],
        counts,
        known,
        loads,
        terms,
        most,
    )
