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
from frictool.identify.resolution import unresolved_inertia
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
    filtered = acceleration_filter(used, records[0].period)
    reason = unresolved_inertia(records[0], bench, filtered, samples.acceleration, f"over {used} samples")
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
        rows = np.flatnonzero(slip_mask(record, strokes, velocity, used, backlash))
        counts = np.abs(velocity[rows]) * record.period / record.resolution
        parts.append(Samples(acceleration[rows], velocity[rows], effort[rows], strokes.number[rows], strokes.sign[rows], counts))
        windows.append(used)
    if not parts or sum(part.velocity.size for part in parts) == 0:
        raise NothingUsable(f"no sample slips for longer than its smoothing window{' beyond the backlash' if backlash else ''}")
    return joined(parts), max(windows)
