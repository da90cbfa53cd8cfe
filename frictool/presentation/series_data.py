"""Data of one curve of a chart, as explore.js reads them.

A number is stored as 16 bits: its error is at most 1/130000 of the range of its curve.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from frictool.presentation.decimation import straightened_indices
from frictool.typing import Vector

LEVELS = 8000  # smallest visible difference of a chart, relative to the height of the panel
STEPS = 65534  # largest stored number; the next number, 65535, marks a gap


def series_data(
    kind: str, colour: str, alpha: float, names: tuple[str, str], data: tuple[Vector, Vector]
) -> dict[str, Any]:
    """Return a curve with abscissas and ordinates `data` (n,), as explore.js reads it.

    On a logarithmic axis, `data` contains decimal logarithms.

    names: (label of the curve, name of the legend entry that shows or hides the curve). A name that
        begins with an underscore is not shown.
    """
    label, group = ("" if name.startswith("_") else name for name in names)
    return {
        "label": label,
        "group": group,
        "kind": kind,
        "colour": colour,
        "alpha": alpha,
        "data": [_packed(values) for values in data],
    }


def straightened(data: tuple[Vector, Vector], height: float) -> tuple[Vector, Vector]:
    """Return a curve without the samples whose omission is invisible in a panel of this height.

    `data`: abscissas and ordinates (n,); all samples are kept if the abscissas are not increasing.
    `height`: range of ordinates that the panel shows, in the unit of the ordinates; with 0, only
    samples on exactly straight lines are omitted.
    """
    if not np.all(np.diff(data[0]) >= 0.0):
        return data
    kept = straightened_indices(*data, height / LEVELS)
    return data[0][kept], data[1][kept]


def logarithm(values: Vector) -> Vector:
    """Return the decimal logarithms of values (n,), with NaN for values that are not positive."""
    return np.log10(values, out=np.full(values.size, np.nan), where=values > 0.0)


def numbers(values: Any) -> list[float]:
    """Return the numbers rounded to nine significant digits."""
    return [float(f"{value:.9g}") for value in values]


def _packed(values: Vector) -> list[Any]:
    finite = np.isfinite(values)
    if not finite.any():
        return [
            0.0,
            0.0,
            base64.b64encode(np.full(values.size, STEPS + 1, "<u2").tobytes()).decode(),
        ]
    low, high = float(values[finite].min()), float(values[finite].max())
    span = high - low or 1.0
    steps = np.full(values.size, STEPS + 1, dtype="<u2")
    steps[finite] = np.rint((values[finite] - low) / span * STEPS)
    return [low, high, base64.b64encode(steps.tobytes()).decode()]
