"""Fits on position differences, unfiltered or through a first-order filter (thesis 4.2.2).

The acceleration is the second difference of the position, the velocity the central difference. The
effort is averaged with the triangular weights of the second difference. All signals of a row then
refer to the same time. The backward difference of thesis (4.2) would be late by half a sample.
Without the average, an effort that is held from sample to sample would be early by half a sample.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.quantisation_limit import refuse_hidden_inertia
from frictool.identify.rows.regression_samples import RegressionSamples, fit, joined, with_fixed
from frictool.identify.rows.strokes import find_strokes
from frictool.plant.weak_form import effort_weights
from frictool.typing import Vector


def differenced_fit(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    weigh: Callable[[RegressionSamples], Vector],
) -> SlidingFit:
    """Return the least-squares fit of all samples of all strokes, weighted by `weigh(samples)`.

    Samples of weight 0 are left out. The inertia is reported as not identified if the encoder is
    too coarse. Raises UnusableLogs if the axis never moves by more than one encoder count.
    """
    time_constant = settings.time_constant or 0.0
    samples, memory = differenced(records, time_constant)
    weight = weigh(samples)
    used = with_fixed(samples.rows(weight > 0.0), settings.fixed)
    result = fit(
        used, weight[weight > 0.0], memory, settings.confidence, {"time_constant": time_constant}
    )
    impulse = np.zeros(50 * memory)
    # input of the filter: second difference of a unit impulse of the position, after samples at
    # rest
    impulse[1:4] = np.array([1.0, -2.0, 1.0]) / records[0].period ** 2
    response = _low_pass(impulse, time_constant, records[0].period)
    return refuse_hidden_inertia(
        result,
        records[0],
        bench,
        response,
        used.unexplained_acceleration,
        f"with a filter of {time_constant:g} s",
    )


def differenced(records: list[MotionRecord], time_constant: float) -> tuple[RegressionSamples, int]:
    """Return the filtered samples of all strokes, and the memory of the filter in rows.

    The memory is the number of rows over which the filter correlates the noise. `time_constant` is
    in s; 0 applies no filter. Raises UnusableLogs if the axis never moves by more than one encoder
    count.
    """
    parts = [_rows(record, time_constant) for record in records]
    if sum(part.velocity.size for part in parts) == 0:
        raise UnusableLogs(
            "the axis never moves by more than one encoder count; record longer strokes"
        )
    return joined(parts), max(3, memory_of(time_constant, records[0].period))


def memory_of(time_constant: float, period: float) -> int:
    """Return the memory of the filter: the number of samples in three time constants."""
    return math.ceil(3.0 * time_constant / period)


def _rows(record: MotionRecord, time_constant: float) -> RegressionSamples:
    x, u, period = record.position, record.effort, record.period
    strokes = find_strokes(record)
    before, at, after = effort_weights(period, record.effort_lag)
    signals = [
        (x[2:] - 2.0 * x[1:-1] + x[:-2]) / period**2,
        (x[2:] - x[:-2]) / (2.0 * period),
        before * u[:-2] + at * u[1:-1] + after * u[2:],
        strokes.sign[1:-1],
    ]
    row = np.arange(record.position.size)
    since = row - np.maximum.accumulate(np.where(np.diff(strokes.number, prepend=-1) != 0, row, 0))
    # rows in which the filter's output still depends on the previous stroke, or on stick
    remembered = since[1:-1] < memory_of(time_constant, period)
    whole = (record.piece[2:] == record.piece[:-2]) & (strokes.sign[1:-1] != 0.0) & ~remembered
    acceleration, velocity, effort, sign = (
        _low_pass(signal, time_constant, period)[whole] for signal in signals
    )
    return RegressionSamples(
        acceleration,
        velocity,
        effort,
        strokes.number[1:-1][whole],
        sign,
        np.abs(velocity) * period / record.resolution,
    )


def _low_pass(signal: Vector, time_constant: float, period: float) -> Vector:
    """Return a signal (n,) filtered by 1/(time_constant s + 1), discretised by Tustin's method.

    A filter that is discretised with zero-order hold would pass a part of the encoder's noise at
    half the sampling rate. This noise would change the inertia in table 4.1 of the thesis by -13 %.
    The filter starts in steady state at the first value of the signal.
    """
    if time_constant == 0.0:
        return signal
    ratio = 2.0 * time_constant / period
    gain = 1.0 / (1.0 + ratio)
    pole = (ratio - 1.0) / (ratio + 1.0)
    return np.asarray(
        scipy.signal.lfilter([gain, gain], [1.0, -pole], signal, zi=[(1.0 - gain) * signal[0]])[0]
    )
