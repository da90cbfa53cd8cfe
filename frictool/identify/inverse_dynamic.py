"""The inverse dynamic model with decimation, as published for EMPS (Janot, Gautier and Brunot 2019).

    position   Butterworth low-pass, forward and backward, padded by 12 samples
    velocity   central differences of it; acceleration: central differences of the velocity
    cut        the first samples, in which the filters settle, are left out
    decimate   effort and each regressor alike: Chebyshev I low-pass, forward and backward, one sample in ten
    solve      ordinary least squares on [acceleration, velocity, sign(velocity), 1]

The effort is not put through the Butterworth filter: the decimation filter, well below it, is what the signals have in common.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, cheby1, filtfilt

from frictool.documents.bench import Bench
from frictool.identify.outcome import Fit, NothingUsable
from frictool.identify.record import Record, Vector
from frictool.identify.samples import Samples, fit, joined
from frictool.identify.strokes import find_strokes


@dataclass(frozen=True)
class Pipeline:
    """The filters; the values are the published ones."""

    cutoff_hz: float = 100.0
    filter_order: int = 4
    padding: int = 12  # samples
    skip: int = 49  # samples
    decimate: int = 10
    decimate_order: int = 8
    decimate_ripple_db: float = 0.05
    decimate_band: float = 0.8  # of the new Nyquist frequency


PUBLISHED = Pipeline()


def inverse_dynamic(records: list[Record], bench: Bench, confidence: float, pipeline: Pipeline = PUBLISHED) -> Fit:
    """Inertia, viscous, Coulomb and offset by the published pipeline. Raises NothingUsable where a record is too short for its filters.

    `bench` is not used: the pipeline knows of no backlash and no encoder; all samples count, those at rest included.
    """
    samples = joined([_decimated(record, pipeline) for record in records])
    details: dict[str, float | int] = {
        "cutoff_hz": pipeline.cutoff_hz,
        "filter_order": pipeline.filter_order,
        "decimate": pipeline.decimate,
    }
    window = max(1, round(1.0 / (pipeline.cutoff_hz * records[0].period * pipeline.decimate)))
    return fit(samples, np.ones(samples.velocity.size), window, confidence, details)


def _decimated(record: Record, pipeline: Pipeline) -> Samples:
    rate = 1.0 / record.period
    if record.piece[-1] > 0:
        raise NothingUsable(f"{record.name} has gaps, over which this pipeline cannot filter; use least-squares")
    if not 0.0 < pipeline.cutoff_hz < 0.5 * rate:
        raise NothingUsable(f"a cut-off of {pipeline.cutoff_hz:g} Hz is not below half of the log's {rate:g} Hz")
    if record.position.size < pipeline.skip + max(pipeline.padding, 30 * pipeline.decimate) + 4:
        raise NothingUsable(f"{record.name} has {record.position.size} samples, too few for the filters")
    b, a = butter(pipeline.filter_order, 2.0 * pipeline.cutoff_hz * record.period)
    position = filtfilt(b, a, record.position, padlen=pipeline.padding)
    velocity = _central(position, record.period)
    acceleration = _central(velocity, record.period)
    stroke = find_strokes(record).number
    kept = slice(pipeline.skip, None)
    rows = np.column_stack((acceleration, velocity, np.sign(velocity), record.effort))[kept]
    rows, every = _decimate(rows, pipeline), pipeline.decimate
    counts = np.abs(rows[:, 1]) * every * record.period / record.resolution
    return Samples(rows[:, 0], rows[:, 1], rows[:, 3], stroke[kept][::every], rows[:, 2], counts)


def _central(values: Vector, period: float) -> Vector:
    """Central differences (n,) per second; the two ends repeat their neighbours."""
    out = np.empty_like(values)
    out[1:-1] = (values[2:] - values[:-2]) / (2.0 * period)
    out[0], out[-1] = out[1], out[-2]
    return out


def _decimate(rows: NDArray[np.float64], pipeline: Pipeline) -> NDArray[np.float64]:
    """Every `decimate`-th row (m, p) after the Chebyshev filter, forward and backward along the rows.

    A filter of even order passes a constant at the bottom of its ripple: divided by that, so that the offset's column stays 1.
    """
    if pipeline.decimate == 1:
        return rows
    b, a = cheby1(pipeline.decimate_order, pipeline.decimate_ripple_db, pipeline.decimate_band / pipeline.decimate)
    constant = (np.sum(b) / np.sum(a)) ** 2
    return np.asarray(filtfilt(b, a, rows, axis=0)[:: pipeline.decimate] / constant)
