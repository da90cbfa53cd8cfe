"""Resonance in the response of the acceleration to the effort, while the axis moves.

The acceleration a and the effort u are second differences of the position and means over the same
samples (`rows/smoothing.py`). For a rigid axis that slips, a/u is therefore 1/inertia at all
frequencies at which friction changes slowly. The records are divided into segments of several
lengths that overlap by half. With the spectra A and U of the segments,

    H = sum conj(U) A / sum |U|^2,    coherence = |sum conj(U) A|^2 / (sum |U|^2 sum |A|^2)

The motion shows a resonance at a frequency if

- |H| is the largest within the factor NEAR of the frequency
- of the coherence at the frequency and its median within the factor NEAR, one is at least COHERENT
  and the other at least LEAST_COHERENCE
- |H| is at least ABOVE times 1/inertia
- |H| is at least ABOVE times its median over each of two bands: from NEAR to FAR times the
  frequency, and from 1/FAR to 1/NEAR of it; two standard errors are added to |H| in the bands
- the phase of H decreases across the frequency, as at a pair of poles with little damping
- both halves of the segments, or segments of another length, show the same frequency

All records are searched together, and each record alone: records that do not excite the resonance
decrease the coherence of all records.

A controller that follows the noise of the encoder also correlates A and U. Then |H| increases with
the square of the frequency, and its phase increases or does not change.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.documents.resonances import Ringing
from frictool.identify.motion_record import MotionRecord
from frictool.plant.weak_form import effort_weights
from frictool.typing import Vector

Spectra = NDArray[np.complex128]  # spectra (s, f) of s segments

LENGTHS = (256, 512, 1024, 2048, 4096)  # segments, samples
LEAST_SEGMENTS, MOST_SEGMENTS = 16, 2000  # of a record
LEAST_MOVE = 3.0  # least range of the position in a segment, counts
LEAST_CYCLES = 12  # in a segment; with fewer, NEAR and FAR are too few frequencies apart
COHERENT, LEAST_COHERENCE = 0.8, 0.4
ABOVE = 2.0
NEAR, FAR = 1.2, 1.4
ACROSS = 0.08  # distance of the frequencies at which the phase is compared, relative
LEAST_DROP, MOST_DROP = 60.0, 240.0  # decrease of the phase, degrees
SAME = 0.06  # largest relative difference of two frequencies of the same resonance
BLOCK = 4  # successive segments in the same half, since neighbours share samples
LARGEST_DAMPING = 0.3


class _Response(NamedTuple):
    """Frequency response H (f,) from effort to acceleration, with coherence and standard error."""

    value: Spectra
    coherence: Vector
    error: Vector


class _Peak(NamedTuple):
    """Peak of a response.

    - length: length of the segments, samples
    - place: index of the peak's frequency in the spectrum
    - repeated: True if both halves of the segments show the peak
    - period: sample period of the segments, s
    """

    length: int
    place: int
    repeated: bool
    response: _Response
    period: float


def resonance_in_motion(records: Sequence[MotionRecord], inertia: float) -> Ringing | None:
    """Return the most distinct resonance that all records together or one record show, or None.

    `inertia` [kg m^2 | kg] is the inertia of the rigid axis. Records with the sample period of the
    first record are searched together. The interval of the frequency is +- twice the frequency step
    of the spectrum.
    """
    usable = [one for one in records if one.velocity is None]
    alike = [one for one in usable if one.period == usable[0].period]
    groups = [alike, *([one] for one in usable if len(usable) > 1)]
    shown = [peak for group in groups for peak in _shown(group, inertia)]
    if not shown:
        return None
    return _oscillation(max(shown, key=lambda one: (one.response.coherence[one.place], one.length)))


def _shown(records: Sequence[MotionRecord], inertia: float) -> list[_Peak]:
    """Return the peaks that both halves of the segments, or segments of two lengths, show."""
    peaks = [peak for length in LENGTHS for peak in _peaks(records, inertia, length)]
    return [one for one in peaks if one.repeated or _elsewhere(one, peaks)]


def _elsewhere(one: _Peak, peaks: Sequence[_Peak]) -> bool:
    return any(
        other.length != one.length
        and abs(other.place / other.length - one.place / one.length)
        <= SAME * one.place / one.length
        for other in peaks
    )


def _peaks(records: Sequence[MotionRecord], inertia: float, length: int) -> Iterator[_Peak]:
    """Yield the peaks of the response in segments of `length` samples."""
    parts = [_segments(record, length) for record in records]
    count = sum(part[0].shape[0] for part in parts)
    if count < LEAST_SEGMENTS:
        return
    acceleration, effort = (np.concatenate(one) for one in zip(*parts, strict=True))
    whole = _response(acceleration, effort)
    half = np.arange(count) // BLOCK % 2 == 0
    halves = [_response(acceleration[one], effort[one]) for one in (half, ~half)]
    size = np.abs(whole.value)
    last = size.size - 1
    upper = size * (1.0 + 2.0 * np.minimum(whole.error, 1.0))
    for k in np.flatnonzero(
        (whole.coherence >= LEAST_COHERENCE) & (size * inertia >= ABOVE)
    ).tolist():
        low, high = round(k / FAR), round(k * FAR)
        near = slice(round(k / NEAR), round(k * NEAR) + 1)
        if k < LEAST_CYCLES or high > last or size[k] < np.max(size[near]):
            continue
        if not _coherent(whole, k, near):
            continue
        sides = (upper[low : near.start + 1], upper[near.stop - 1 : high + 1])
        step = max(round(ACROSS * k), 2)
        drop = np.degrees(np.angle(whole.value[k - step] / whole.value[k + step])) % 360.0
        if LEAST_DROP <= drop <= MOST_DROP and all(
            size[k] >= ABOVE * float(np.median(side)) for side in sides
        ):
            repeated = all(_repeats(one, k, near) for one in halves)
            yield _Peak(length, k, repeated, whole, records[0].period)


def _repeats(response: _Response, k: int, near: slice) -> bool:
    at = near.start + int(np.argmax(np.abs(response.value[near])))
    return _coherent(response, at, near) and abs(at - k) <= max(1.0, SAME * k)


def _coherent(response: _Response, k: int, near: slice) -> bool:
    """Return whether acceleration and effort are coherent at the frequency index `k` and near it.

    A controller may make the effort at a resonance so small that the coherence decreases there. A
    lower coherence at `k` is therefore sufficient if most of the indices `near` are coherent. A
    single tone is coherent at `k` only. Encoder counts at constant speed are such a tone: the
    controller follows them.
    """
    least, most = sorted((response.coherence[k], np.median(response.coherence[near])))
    return bool(least >= LEAST_COHERENCE and most >= COHERENT)


def _segments(record: MotionRecord, length: int) -> tuple[Spectra, Spectra]:
    """Return the spectra of acceleration and effort in the moving segments, (s, length/2 + 1)."""
    x, u, period = record.position, record.effort, record.period
    before, at, after = effort_weights(period, record.effort_lag)
    acceleration = (x[2:] - 2.0 * x[1:-1] + x[:-2]) / period**2
    effort = before * u[:-2] + at * u[1:-1] + after * u[2:]
    window = np.hanning(length + 1)[:-1]
    starts = [
        start
        for start in range(0, acceleration.size - length + 1, length // 2)
        if record.piece[start] == record.piece[start + length + 1]
        and np.ptp(x[start : start + length]) >= LEAST_MOVE * record.resolution
    ]
    starts = starts[:: -(-len(starts) // MOST_SEGMENTS) or 1]
    index = np.array(starts, dtype=np.int64)[:, None] + np.arange(length)
    rows = [signal[index] for signal in (acceleration, effort)]
    first, second = (
        np.fft.rfft(window * (one - one.mean(axis=1, keepdims=True)), axis=1) for one in rows
    )
    return first, second


def _response(acceleration: Spectra, effort: Spectra) -> _Response:
    power = np.sum(np.abs(effort) ** 2, axis=0)
    shared = np.sum(np.conj(effort) * acceleration, axis=0)
    own = np.sum(np.abs(acceleration) ** 2, axis=0)
    tiny = np.finfo(np.float64).tiny
    coherence = np.abs(shared) ** 2 / np.maximum(power * own, tiny)
    # neighbouring segments share samples: about 0.6 of the segments are independent (Welch 1967)
    counted = 0.6 * acceleration.shape[0]
    error = np.sqrt(
        np.maximum(1.0 - coherence, 0.0) / (2.0 * counted * np.maximum(coherence, tiny))
    )
    return _Response(shared / np.maximum(power, tiny), coherence, error)


def _oscillation(peak: _Peak) -> Ringing:
    """Return frequency and damping of a pair of poles that is fitted to the response near the peak.

    The pair belongs to a quotient of second order, fitted by least squares with the weights
    coherence and 1/|H| (Levy 1959). If the poles are not near the peak, or not damped, frequency
    and width of the peak are used.
    """
    k, value = peak.place, peak.response.value
    bins = np.arange(round(k / FAR), round(k * FAR) + 1)
    s = 1j * bins / k
    h = value[bins] / np.abs(value[k])
    weight = np.sqrt(peak.response.coherence[bins]) / np.abs(h)
    columns = np.stack([np.ones_like(s), s, s**2, -h * s, -h * s**2], axis=1) * weight[:, None]
    right = h * weight
    found = np.linalg.lstsq(
        np.concatenate([columns.real, columns.imag]),
        np.concatenate([right.real, right.imag]),
        rcond=None,
    )[0]
    first, second = float(found[3]), float(found[4])
    unit = 2.0 * np.pi / (peak.length * peak.period)
    place = second**-0.5 if second > 0.0 else 0.0
    damping = 0.5 * first * place
    if not (1.0 / NEAR < place < NEAR and 0.0 < damping < LARGEST_DAMPING):
        wide = np.count_nonzero(np.abs(h) >= 0.5**0.5)
        place, damping = 1.0, min(0.5 * float(wide) / k, LARGEST_DAMPING)
    rate = k * unit * place
    return Ringing(rate, damping, (rate - 2.0 * unit, rate + 2.0 * unit), True)
