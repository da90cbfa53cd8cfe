"""Decimation of a signal for a plot: fewer points, but every visible peak."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from frictool.typing import Vector

DRAWN_LEVELS = 1500  # smallest visible difference, relative to the height of a curve
COLUMNS = 500  # columns of a plot, about one per printed point of its width


def finite_or_nan(values: Vector) -> Vector:
    """Return a signal (n,) with NaN, a gap in the curve, in place of each infinite value."""
    return np.where(np.isfinite(values), values, np.nan)


def decimated_indices(*signals: Vector, columns: int = COLUMNS) -> NDArray[np.intp]:
    """Return increasing indices at which signals (n,) of equal length are plotted.

    In each of `columns` columns, the first and last samples and the smallest and largest samples of
    each signal are kept. Signals with at most 2 `columns` samples are kept completely.
    """
    count = signals[0].size
    if count <= 2 * columns:
        return np.arange(count, dtype=np.intp)
    edges = np.linspace(0, count, columns + 1).astype(np.intp)
    kept = [edges[:-1], edges[1:] - 1]
    for signal in signals:
        pieces = [
            (start + int(np.argmin(signal[start:stop])), start + int(np.argmax(signal[start:stop])))
            for start, stop in _pairs(edges)
        ]
        kept.append(np.array(pieces, dtype=np.intp).ravel())
    return np.unique(np.concatenate(kept))


def straightened_indices(abscissa: Vector, ordinate: Vector, tolerance: float) -> NDArray[np.intp]:
    """Return increasing indices at which a curve (n,) with a rising abscissa is stored.

    Straight lines between the stored samples differ from the curve by at most `tolerance` (cone
    intersection). Samples that are not finite, and their neighbours, are kept.
    """
    count = abscissa.size
    if count < 3:
        return np.arange(count, dtype=np.intp)
    times, values = abscissa.tolist(), ordinate.tolist()
    kept = [0]
    low, high = -math.inf, math.inf
    for k in range(1, count):
        start = kept[-1]
        step = times[k] - times[start]
        rise = values[k] - values[start]
        if not (math.isfinite(rise) and step > 0.0):
            kept += [k - 1] * (k - 1 > start) + [k]
            low, high = -math.inf, math.inf
            continue
        if not low <= rise / step <= high:
            kept.append(k - 1)
            step = times[k] - times[k - 1]
            rise = values[k] - values[k - 1]
            low, high = -math.inf, math.inf
            if not (math.isfinite(rise) and step > 0.0):
                kept.append(k)
                continue
        low = max(low, (rise - tolerance) / step)
        high = min(high, (rise + tolerance) / step)
    return np.unique(np.array([*kept, count - 1], dtype=np.intp))


def drawn_indices(abscissa: Vector, ordinate: Vector) -> NDArray[np.intp]:
    """Return increasing indices at which a static figure draws a curve (n,).

    `abscissa` must increase. Peaks are kept (`decimated_indices`); samples on straight parts are
    left out.
    """
    kept = decimated_indices(ordinate)
    finite = ordinate[np.isfinite(ordinate)]
    tolerance = float(np.ptp(finite)) / DRAWN_LEVELS if finite.size else 0.0
    return kept[straightened_indices(abscissa[kept], ordinate[kept], tolerance)]


def decimated_path_indices(abscissa: Vector, ordinate: Vector) -> NDArray[np.intp]:
    """Return increasing indices at which the path of two signals (n,) is plotted.

    Each signal is divided by its range, and the path is cut into pieces of the length 1/500. The
    first sample in each piece is kept, and the last sample of the signals.
    """
    width, height = float(np.ptp(abscissa)) or 1.0, float(np.ptp(ordinate)) or 1.0
    length = np.concatenate(
        ([0.0], np.cumsum(np.hypot(np.diff(abscissa) / width, np.diff(ordinate) / height)))
    )
    stride = np.floor(length * COLUMNS)
    kept = np.flatnonzero(np.diff(stride, prepend=-1.0) > 0)
    return np.union1d(kept, [length.size - 1]).astype(np.intp)


def _pairs(edges: NDArray[np.intp]) -> list[tuple[int, int]]:
    return [(int(a), int(b)) for a, b in itertools.pairwise(edges)]
