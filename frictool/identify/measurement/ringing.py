"""Resonance that the position shows after the axis has stopped.

The first windows after each stop, with the lengths WINDOWS, are searched for a free oscillation
(`free_oscillation.py`). A single oscillation may be chance, or an impact. The axis rings if

- at least LEAST_STOPS stops, and at least half of all stops with an oscillation, agree in the
  frequency within the relative difference AGREE
- the oscillations decay: none grows significantly, and their mean decay rate differs from 0 by
  CERTAIN standard errors (the amplitude of a self-excited oscillation would also increase at times)
- effort and load do not cause the oscillations: the mean `share` of the acceleration that effort
  and load explain (`free_oscillation.py`) is significantly below DRIVEN
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import scipy

from frictool.adapters.axis_model import load_law
from frictool.documents.model import Model
from frictool.documents.resonances import Ringing
from frictool.identify.measurement.free_oscillation import (
    DRIVEN,
    FreeOscillation,
    Rigidity,
    StopWindow,
    coarse_fits,
    free_oscillation,
)
from frictool.identify.motion_record import MotionRecord
from frictool.typing import Vector

WINDOWS = (0.1, 0.2, 0.4, 0.8, 1.6)  # lengths of the windows, s
SAMPLES = 120  # largest number of samples in a window; if the log has more, they are averaged
LEAST_SAMPLES = 18  # least number of the log's samples in a window
PER_CYCLE = 6.0  # least number of the log's samples in a cycle
# number of windows after a stop; successive windows start a sixteenth of a window apart
STARTS = 12
# at rest, largest difference between the means of a window's halves, relative to its range
DRIFT = 0.25
LEAST_RANGE = 3.0  # least range of the position in a window, counts
# least number of changes of direction in a window; two visible cycles have four
LEAST_REVERSALS = 3
APART = 4.0  # least range of the position between two stops, in amplitudes
LEAST_STOPS = 2
AGREE = 0.1  # largest relative difference of frequencies that agree
CERTAIN = 4.0  # least mean decay, in standard errors
SCATTER = 2.0  # least significant difference, in standard errors
LEAST_ERROR = 1e-9  # the share of an effort that is always 0 has no error


class _WindowOscillation(NamedTuple):
    """Free oscillation, and the index of the first sample of the window in which it was found."""

    start: int
    oscillation: FreeOscillation


def ringing(records: Sequence[MotionRecord], model: Model) -> Ringing | None:
    """Return the oscillation of the axis after it stops, or None if the records show none.

    The interval of the frequency is a prediction interval: it contains the frequency after one
    further stop, with the confidence of the model. Records with a measured velocity are not
    searched.
    """
    actuator = model.bench.actuator
    late = (model.bench.delay_samples + 1) * model.bench.sample_period_s
    known = (model.parameters.inertia, model.bench.mechanics.inertia)
    load = None if model.laws is None or model.laws.load is None else load_law(model.laws.load).at
    axis = Rigidity(
        min(one.interval[0] for one in known), late + actuator.loop_time_constant_s, load
    )
    found = [
        one for record in records if record.velocity is None for one in _of_record(record, axis)
    ]
    return _agreed(found, model.confidence)


def _agreed(found: Sequence[FreeOscillation], confidence: float) -> Ringing | None:
    rates = np.array([one.rate for one in found])
    if rates.size < LEAST_STOPS:
        return None
    near = np.abs(np.log(rates[:, None] / rates)) <= AGREE
    best = near[int(np.argmax(near.sum(axis=1)))]
    count = int(best.sum())
    if count < LEAST_STOPS or 2 * count < rates.size:
        return None
    members = [one for one, agrees in zip(found, best, strict=True) if agrees]
    decay, decay_error = _mean([(one.decay, one.decay_error) for one in members])
    share, share_error = _mean([(one.share, one.share_error) for one in members])
    if (
        any(one.decay < -SCATTER * one.decay_error for one in members)
        or decay < CERTAIN * decay_error
        or share + SCATTER * share_error > DRIVEN
    ):
        return None
    undamped = np.hypot(rates[best], decay)
    mean = float(np.mean(undamped))
    half = scipy.stats.t.ppf(0.5 + confidence / 2.0, count - 1) * np.std(undamped, ddof=1)
    half = float(half) * math.sqrt(1.0 + 1.0 / count)
    return Ringing(mean, decay / mean, (max(mean - half, mean / 2.0), mean + half))


def _mean(values: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return the weighted mean of pairs (value, standard error), and its standard error.

    If the values scatter more than their errors allow, the standard error is multiplied by the
    ratio of observed to expected scatter (Birge 1932).
    """
    value, error = np.array(values).T
    weights = np.maximum(error, LEAST_ERROR) ** -2.0
    mean = float(np.sum(weights * value) / np.sum(weights))
    scatter = float(np.sum(weights * (value - mean) ** 2)) / (len(values) - 1)
    return mean, math.sqrt(max(scatter, 1.0) / float(np.sum(weights)))


def _of_record(record: MotionRecord, axis: Rigidity) -> list[FreeOscillation]:
    """Return one free oscillation for each stop: the one with the most precise frequency.

    Oscillations in several windows belong to the same stop if the position hardly moves between the
    starts of these windows.
    """
    found = [one for window in WINDOWS for one in _in_windows(record, window, axis)]
    groups = list[list[_WindowOscillation]]()
    for one in sorted(found, key=lambda one: one.start):
        if groups:
            between = record.position[groups[-1][0].start : one.start + 1]
            largest = max(each.oscillation.amplitude for each in (*groups[-1], one))
            if np.ptp(between) <= APART * largest:
                groups[-1].append(one)
                continue
        groups.append([one])
    every = [[one.oscillation for one in group] for group in groups]
    return [min(group, key=lambda one: one.rate_error / one.rate) for group in every]


def _in_windows(
    record: MotionRecord, window: float, axis: Rigidity
) -> Iterator[_WindowOscillation]:
    """Yield the free oscillations in windows of `window` seconds after the stops of a record."""
    size = round(window / record.period)
    step = max(1, size // SAMPLES)
    samples = size // step
    count = record.position.size // step
    if size < LEAST_SAMPLES or count < 2 * samples:
        return
    position, effort = (
        signal[: count * step].reshape(count, step).mean(axis=1)
        for signal in (record.position, record.effort)
    )
    period = step * record.period
    span = samples * period
    highest = 2.0 * np.pi / PER_CYCLE * span / record.period
    reversals = _reversals(position)
    for stop in _stops(position, samples, record.resolution):
        starts = stop + samples * np.arange(STARTS) // 16
        starts = starts[starts + samples <= count]
        ends = (starts + samples) * step - 1
        starts = starts[record.piece[starts * step] == record.piece[ends]]
        turns = reversals[starts + samples - 1] - reversals[starts]
        starts = starts[turns >= LEAST_REVERSALS]
        if starts.size == 0:
            continue
        windows = position[starts[:, None] + np.arange(samples)]
        for best, rate, decay in coarse_fits(windows, highest):
            first = int(starts[best])
            inside = slice(first, first + samples)
            before = position[max(0, first - samples) : first + 1]
            moved = float(np.max(np.abs(before - np.mean(windows[best]))))
            rest = StopWindow(position[inside], effort[inside], period, moved, record.resolution)
            oscillation = free_oscillation(rest, rate / span, decay / span, axis)
            if oscillation is not None:
                yield _WindowOscillation(first * step, oscillation)


def _stops(position: Vector, samples: int, count: float) -> Iterator[int]:
    """Yield, for each rest, the start of the first window in which the position still moves.

    The windows of `position` (n,) have `samples` samples; `count` is the encoder count.
    """
    half = samples // 2
    size = position.size - samples + 1
    sums = np.concatenate(([0.0], np.cumsum(position - position[0])))
    first, second, third = (sums[k : k + size] for k in (0, half, 2 * half))
    drift = np.abs(third - 2.0 * second + first) / half
    reach = _ranges(position, samples)
    rests = (drift <= DRIFT * reach) & (reach >= LEAST_RANGE * count)
    latest = -samples
    for start in np.flatnonzero(rests & ~np.append(False, rests[:-1])):
        if start >= latest + samples:
            latest = int(start)
            yield latest


def _reversals(position: Vector) -> Vector:
    """Return the number of changes of direction up to each sample (n,)."""
    moves = np.diff(position, prepend=position[:1])
    moving = np.flatnonzero(moves)
    changed = np.zeros(position.size)
    changed[moving[1:]] = np.diff(np.sign(moves[moving])) != 0.0
    return np.cumsum(changed)


def _ranges(position: Vector, samples: int) -> Vector:
    """Return the largest minus the smallest position of each window, (n - samples + 1,)."""
    high = low = position
    size = 1
    while 2 * size <= samples:
        high = np.maximum(high[:-size], high[size:])
        low = np.minimum(low[:-size], low[size:])
        size *= 2
    kept = position.size - samples + 1
    rest = samples - size
    return np.asarray(
        np.maximum(high[:kept], high[rest : rest + kept])
        - np.minimum(low[:kept], low[rest : rest + kept])
    )
