"""Inverse dynamic model with decimation, as published for EMPS (Janot, Gautier, Brunot 2019).

    position   Butterworth low-pass, forward and backward, padded by 12 samples
    velocity   central differences of the position
    accel.     central differences of the velocity
    cut        the first samples, in which the filters settle, are dropped
    decimate   effort and each regressor alike: Chebyshev I low-pass, forward and backward,
               one sample in ten
    solve      ordinary least squares on [acceleration, velocity, sign(velocity), 1]

EMPS is the benchmark "electro-mechanical positioning system". Two systematic errors of the
published pipeline do not appear in the residuals. The effort is treated as the effort at the
instant of its sample, even if the drive holds it until the next sample. Samples at rest and at
reversals are treated as slip. Each interval therefore contains two intervals: the interval of the
pipeline, and the interval of the power balance (`power_balance`), which has neither error.

A log with much motion inside the backlash is unusable. If the encoder's noise changes the sign of
the velocity without a reversal, viscous and Coulomb friction are reported as not identified.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.identify.estimators.power_balance import power_balance
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings, PublishedFilters
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.quantisation_limit import unresolved_inertia
from frictool.identify.rows.regression_samples import RegressionSamples, fit, joined, with_fixed
from frictool.identify.rows.smoothing import position_noise
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Vector

LARGEST_BACKLASH_SHARE = 0.01  # largest share of samples within the backlash
LARGEST_NOISE = 0.01  # largest rms noise of the velocity relative to its rms


def inverse_dynamic(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset by the pipeline for EMPS.

    The intervals include the systematic errors of the pipeline. Raises UnusableLogs if a record is
    too short for the filters, if much of the motion is inside the backlash, or if the axis never
    slips.
    """
    pipeline = settings.pipeline or PublishedFilters()
    confidence = settings.confidence
    _refuse_backlash(records, bench)
    samples = with_fixed(
        joined([_decimated(record, pipeline) for record in records]), settings.fixed
    )
    details: dict[str, float | int] = {
        "cutoff_hz": pipeline.cutoff_hz,
        "filter_order": pipeline.filter_order,
        "decimate": pipeline.decimate,
    }
    window = max(1, round(1.0 / (pipeline.cutoff_hz * records[0].period * pipeline.decimate)))
    result = fit(samples, np.ones(samples.velocity.size), window, confidence, details)
    balance = power_balance(
        records, bench, IdentificationSettings(confidence, fixed=settings.fixed)
    )
    refused = {
        **result.refused,
        **balance.refused,
        **_unresolved(records[0], bench, samples, pipeline),
    }
    spanned = {
        name: _span(interval, balance.parameters[name])
        for name, interval in result.parameters.items()
        if name not in refused
    }
    return replace(result, parameters=spanned, refused=refused)


def _span(pipeline: Interval, other: Interval) -> Interval:
    return Interval(pipeline.value, min(pipeline.low, other.low), max(pipeline.high, other.high))


def _refuse_backlash(records: list[MotionRecord], bench: Bench) -> None:
    width = bench.mechanics.backlash
    if width is None:
        return
    strokes = [find_strokes(record) for record in records]
    inside = sum(int(np.sum((s.sign != 0.0) & (s.advance < max(width.interval)))) for s in strokes)
    share = inside / sum(record.position.size for record in records)
    if share > LARGEST_BACKLASH_SHARE:
        raise UnusableLogs(
            f"{100 * share:.2g} % of the samples may lie within the bench's backlash, which "
            f"inverse-dynamic neglects (allowed: at most {100 * LARGEST_BACKLASH_SHARE:g} %); "
            "use least-squares"
        )


def _unresolved(
    record: MotionRecord, bench: Bench, samples: RegressionSamples, pipeline: PublishedFilters
) -> dict[str, str]:
    velocity, acceleration = _responses(record, pipeline)
    refused: dict[str, str] = {}
    reason = unresolved_inertia(
        record,
        bench,
        acceleration,
        samples.unexplained_acceleration,
        f"below {pipeline.cutoff_hz:g} Hz and decimation",
    )
    if reason is not None:
        refused["inertia"] = reason
    noise = (
        position_noise(record)
        * float(np.linalg.norm(velocity))
        / float(np.sqrt(np.mean(samples.velocity**2)))
    )
    if noise > LARGEST_NOISE:
        shown = f"{100 * noise:.2g} % of the speed (allowed: at most {100 * LARGEST_NOISE:g} %)"
        reason = (
            f"the encoder's noise in the velocity is {shown}, so that the velocity changes its "
            "sign without a reversal; use least-squares"
        )
        refused |= {"viscous": reason, "coulomb": reason}
    return refused


def _responses(record: MotionRecord, pipeline: PublishedFilters) -> tuple[Vector, Vector]:
    """Return the impulse responses (n,) from position to velocity and to acceleration."""
    impulse = np.zeros(record.position.size)
    impulse[impulse.size // 2] = 1.0
    velocity, acceleration = _derivatives(impulse, record.period, pipeline)
    return velocity, _filtered(acceleration[:, None], pipeline)[:, 0]


def _decimated(record: MotionRecord, pipeline: PublishedFilters) -> RegressionSamples:
    rate = 1.0 / record.period
    if record.piece[-1] > 0:
        raise UnusableLogs(
            f"{record.name} has gaps, over which inverse-dynamic cannot filter; use least-squares"
        )
    if not 0.0 < pipeline.cutoff_hz < 0.5 * rate:
        raise UnusableLogs(
            f"a cut-off of {pipeline.cutoff_hz:g} Hz is too high; allowed: below half of the "
            f"sampling rate of {rate:g} Hz"
        )
    fewest = pipeline.skip + max(pipeline.padding, 30 * pipeline.decimate) + 4
    if record.position.size < fewest:
        raise UnusableLogs(
            f"{record.name} has {record.position.size} samples; the filters need at least {fewest}"
        )
    velocity, acceleration = _derivatives(record.position, record.period, pipeline)
    stroke = find_strokes(record).number
    kept = slice(pipeline.skip, None)
    rows = np.column_stack((acceleration, velocity, np.sign(velocity), record.effort))[kept]
    rows = _filtered(rows, pipeline)[:: pipeline.decimate]
    every = pipeline.decimate
    counts = np.abs(rows[:, 1]) * every * record.period / record.resolution
    return RegressionSamples(
        rows[:, 0], rows[:, 1], rows[:, 3], stroke[kept][::every], rows[:, 2], counts
    )


def _derivatives(
    position: Vector, period: float, pipeline: PublishedFilters
) -> tuple[Vector, Vector]:
    b, a = scipy.signal.butter(pipeline.filter_order, 2.0 * pipeline.cutoff_hz * period)
    velocity = _central(scipy.signal.filtfilt(b, a, position, padlen=pipeline.padding), period)
    return velocity, _central(velocity, period)


def _central(values: Vector, period: float) -> Vector:
    out = np.empty_like(values)
    out[1:-1] = (values[2:] - values[:-2]) / (2.0 * period)
    out[0], out[-1] = out[1], out[-2]
    return out


def _filtered(rows: NDArray[np.float64], pipeline: PublishedFilters) -> NDArray[np.float64]:
    """Filter rows (m, p) by the Chebyshev low-pass for decimation, forward and backward.

    The result is divided by the filter's gain for a constant; this gain differs from 1 if the order
    is even.
    """
    if pipeline.decimate == 1:
        return rows
    b, a = scipy.signal.cheby1(
        pipeline.decimate_order,
        pipeline.decimate_ripple_db,
        pipeline.decimate_band / pipeline.decimate,
    )
    constant = (np.sum(b) / np.sum(a)) ** 2
    return np.asarray(scipy.signal.filtfilt(b, a, rows, axis=0) / constant)
