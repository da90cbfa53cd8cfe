"""Least squares weighted by velocity, that is the power balance (4.23), on zero-phase smoothed signals.

    v u = inertia v a + viscous v^2 + coulomb |v| + offset v

The weight keeps sticks and the Stribeck effect out (4.2.5.2); the slip mask leaves out what the weight only attenuates. Where the
inertia cannot be identified it stays in the regression as a nuisance: over whole strokes acceleration is nearly orthogonal to
velocity and its sign (4.27), so that this costs the others next to nothing, while an a-priori inertia would put its own error, in
the clutch +-16 %, into them.

The window is chosen twice: first as if the inertia could be had to any precision, then, knowing how uncertain it is, as short as leaves
the attenuation by the encoder's noise at a fifth of the standard deviation: a shorter window loses fewer samples beside reversals.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import ndtri

from frictool.documents.bench import Bench
from frictool.identify.outcome import Fit, NothingUsable
from frictool.identify.record import Record
from frictool.identify.samples import Samples, fit, joined
from frictool.identify.slip import slip_mask
from frictool.identify.smoothing import acceleration_filter, choose_window, smoothed
from frictool.identify.strokes import find_strokes

SMALLEST_SHARE, LARGEST_SHARE = 0.0075, 0.1  # of noise in the acceleration (`smoothing`): attenuation 0.006 % and 1 %
BIAS_SHARE = 0.2  # of the inertia's standard deviation that attenuation may reach


def least_squares(records: list[Record], bench: Bench, confidence: float, window: int | None = None) -> Fit:
    """Inertia, viscous, Coulomb and offset from records of sliding motion. Raises NothingUsable where nothing moves enough."""
    samples, used = _prepare(records, bench, SMALLEST_SHARE, window)
    result = _fit(samples, used, confidence)
    share = _bearable_share(result, confidence)
    if window is None and share > SMALLEST_SHARE:
        again, shorter = _prepare(records, bench, share, None)
        if shorter < used:
            samples, used = again, shorter
            result = _fit(samples, used, confidence)
    reason = unresolved_inertia(records[0], samples, used, bench)
    if reason is None:
        return result
    kept = {name: interval for name, interval in result.parameters.items() if name != "inertia"}
    return replace(result, parameters=kept, refused={**result.refused, "inertia": reason})


def _fit(samples: Samples, window: int, confidence: float) -> Fit:
    return fit(samples, np.abs(samples.velocity), window, confidence, {"window": window})


def _bearable_share(result: Fit, confidence: float) -> float:
    """The share of noise in the acceleration whose attenuation of the inertia is small beside what is uncertain of it anyway."""
    inertia = result.parameters["inertia"]
    if inertia.value <= 0.0:
        return LARGEST_SHARE
    deviation = inertia.half_width / float(ndtri(0.5 + 0.5 * confidence)) / inertia.value
    return min(float(np.sqrt(BIAS_SHARE * deviation)), LARGEST_SHARE)


def _prepare(records: list[Record], bench: Bench, share: float, window: int | None) -> tuple[Samples, int]:
    """The samples certain to slip, and the longest window that any record was smoothed over."""
    width = bench.mechanics.backlash
    backlash = 0.0 if width is None else max(width.interval)
    parts, windows = [], []
    for record in records:
        strokes = find_strokes(record)
        moving = strokes.number[strokes.sign != 0.0]
        if moving.size == 0:
            continue
        lengths = np.bincount(moving)
        used = window or choose_window(record, float(np.median(lengths[lengths > 0])), share)
        acceleration, velocity, effort = smoothed(record, used)
        mask = slip_mask(record, strokes, velocity, used, backlash)
        counts = np.abs(velocity[mask]) * record.period / record.resolution
        parts.append(Samples(acceleration[mask], velocity[mask], effort[mask], strokes.number[mask], strokes.sign[mask], counts))
        windows.append(used)
    if not parts or sum(part.velocity.size for part in parts) == 0:
        raise NothingUsable(f"no sample slips for longer than its smoothing window{' beyond the backlash' if backlash else ''}")
    return joined(parts), max(windows)


def unresolved_inertia(record: Record, samples: Samples, window: int, bench: Bench) -> str | None:
    """Why the inertia is not to be had by differentiating this encoder, or None.

    (4.3), with the gain of the filter in place of the double difference's 2/T^2: the largest error that quantisation can leave on
    the acceleration, D_a = step/2 sum|c|, moves the inertia by up to J D_a/rms(a). Identification is of use only where that is less
    than what is known without it (4.2.1), the half width of the bench's own interval.
    """
    prior = bench.mechanics.inertia
    known = 0.5 * (prior.interval[1] - prior.interval[0])
    if known == 0.0:
        known = prior.value  # the bench gives no interval: anything better than a factor of two is of use
    worst = 0.5 * record.resolution * float(np.sum(np.abs(acceleration_filter(window, record.period))))
    bound = prior.value * worst / float(np.sqrt(np.mean(samples.acceleration**2)))
    raw = prior.value**2 * 2.0 * record.resolution / (record.period**2 * bench.actuator.constant.value * bench.actuator.limit.value)
    if bound >= known:
        return (
            f"quantisation can move it by {_percent(bound, prior.value)} after smoothing over {window} samples "
            f"({_percent(raw, prior.value)} by (4.3) without), and the bench knows it to {_percent(known, prior.value)}"
        )
    return None


def _percent(part: float, whole: float) -> str:
    return f"+-{100.0 * part / whole:.2g} %"
