"""Decimation of a signal for a plot: fewer points, but every visible peak."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.typing import Vector

DRAWN_LEVELS = 1500  # smallest visible difference, relative to the height of a curve
COLUMNS = 500  # columns of a plot, about one per printed point of its width


def finite_or_nan(values: Vector) -> Vector:
    """Return a signal (n,) in which NaN replaces infinite values, so that a plot shows a gap."""
    return np.where(np.isfinite(values), values, np.nan)


def decimated_indices(*signals: Vector, columns: int = COLUMNS) -> NDArray[np.intp]:
    """Return increasing indices of the samples to plot, for signals (n,) of equal length.

    The samples are divided into `columns` groups of about equal size. In each group, the first and
    last samples and the smallest and largest samples of each signal are kept. Signals with at most
    2 `columns` samples are kept completely.
    """
    count = signals[0].size
    if count <= 2 * columns:
        return np.arange(count, dtype=np.intp)
    edges = np.linspace(0, count, columns + 1).astype(np.intp)
    kept = [edges[:-1], edges[1:] - 1]
    lengths = np.diff(edges)
    for length in np.unique(lengths):
        starts = edges[:-1][lengths == length]
        column = starts[:, None] + np.arange(length)
        for signal in signals:
            values = signal[column]
            kept += [starts + np.argmin(values, axis=1), starts + np.argmax(values, axis=1)]
    return np.unique(np.concatenate(kept))


def straightened_indices(abscissa: Vector, ordinate: Vector, tolerance: float) -> NDArray[np.intp]:
    """Return increasing indices of the stored samples of a curve (n,) with increasing abscissa.

    Straight lines between the stored samples differ from the curve by at most `tolerance` (cone
    intersection). Samples that are not finite, and their neighbours, are kept.
    """
    from frictool.presentation.curve_simplification import cone_indices  # loads numba

    count = abscissa.size
    if count < 3:
        return np.arange(count, dtype=np.intp)
    times, values = (np.ascontiguousarray(one, dtype=np.float64) for one in (abscissa, ordinate))
    return np.unique(cone_indices(times, values, tolerance))


def drawn_indices(abscissa: Vector, ordinate: Vector) -> NDArray[np.intp]:
    """Return increasing indices of the samples of a curve (n,) that are drawn in a static figure.

    `abscissa` must increase. Peaks are kept (`decimated_indices`); samples on straight parts are
    left out.
    """
    kept = decimated_indices(ordinate)
    finite = ordinate[np.isfinite(ordinate)]
    tolerance = float(np.ptp(finite)) / DRAWN_LEVELS if finite.size else 0.0
    return kept[straightened_indices(abscissa[kept], ordinate[kept], tolerance)]


def decimated_path_indices(abscissa: Vector, ordinate: Vector) -> NDArray[np.intp]:
    """Return increasing indices of the plotted samples of a path, ordinate over abscissa (n,).

    Abscissa and ordinate are divided by their ranges; the path is divided into pieces of a fixed
    length. The first sample of each piece and the last sample of the path are kept.
    """
    width, height = float(np.ptp(abscissa)) or 1.0, float(np.ptp(ordinate)) or 1.0
    length = np.concatenate(
        ([0.0], np.cumsum(np.hypot(np.diff(abscissa) / width, np.diff(ordinate) / height)))
    )
    stride = np.floor(length * COLUMNS)
    kept = np.flatnonzero(np.diff(stride, prepend=-1.0) > 0)
    return np.union1d(kept, [length.size - 1]).astype(np.intp)
