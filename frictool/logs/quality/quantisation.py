"""Quantisation of a signal, and comparison of a position's quantisation with the bench."""

from __future__ import annotations

import contextlib
import math

import numpy as np

from frictool.documents.bench import COUNT, Bench
from frictool.documents.quantity import si_unit, unit_scale
from frictool.logs.quality.time_base import ON_LATTICE, encoder_step, levels
from frictool.typing import Vector

# maximum number of distinct values collected: these suffice to show any relevant step
MOST = 1 << 17
SEVERAL = 2.0 * (1.0 - ON_LATTICE)  # least ratio of two steps for a warning
CHANCE = 1e-6  # largest probability that coarse steps occur by chance, for a warning
# least number of rest positions between the bench's counts, and their least share of all rest
# positions
FEWEST_BETWEEN, SHARE_BETWEEN = 3, 0.25
# largest step that single precision causes, relative to the largest position
SINGLE_PRECISION = 2.0**-22
POWER = 1e-4  # largest deviation from a whole exponent of a step that is a power of 2 or 10


class DistinctValues:
    """Collector of the distinct values of one signal, up to MOST values."""

    def __init__(self) -> None:
        self._values: Vector = np.empty(0)

    def take(self, values: Vector) -> None:
        """Add values (n,), all finite."""
        if self._values.size < MOST:
            self._values = np.union1d(self._values, values)

    @property
    def count(self) -> int:
        """Return the number of distinct values collected."""
        return levels(self._values) if self._values.size else 0

    @property
    def step(self) -> float | None:
        """Return the step that divides all distances of the values; None without such a step."""
        return encoder_step(self._values) if self._values.size else None


def step_doubt(position: Vector, bench: Bench) -> str | None:
    """Return a warning if the position's steps differ from the bench's encoder step, else None.

    position: samples (n,) in rad or m.

    A filtered position has no steps, and causes no warning. Finer steps than the encoder's cause no
    warning if they come from the format of the numbers, or from interpolation between counts. An
    interpolated position is never constant between two counts.
    """
    step, count = encoder_step(position), bench.encoder.resolution
    if step is None or 1.0 / SEVERAL < step / count < SEVERAL:
        return None
    ratio = max(step / count, count / step)
    steps = np.rint((position - position[0]) / step)
    if step > count:
        # at a constant speed, all samples may be multiples of several counts
        if np.count_nonzero(np.diff(steps, 2)) * math.log(ratio) < -math.log(CHANCE):
            return None
    elif _from_format(position, step, bench) or not _stands_between(steps, round(ratio)):
        return None
    key = "step" if bench.encoder.step is not None else "counts_per_revolution"
    unit = si_unit("position", bench.axis)
    whole = abs(ratio - round(ratio)) < ON_LATTICE
    reason = " (a gear ratio?)" if whole else " (a rounded log?)" if step > count else ""
    return (
        f"the position has steps of {step:.4g} {unit}, but one count of the encoder is {count:.4g} "
        f"{unit}; their ratio is {ratio:.4g}{reason}: correct encoder.{key} or columns.position"
    )


def _from_format(position: Vector, step: float, bench: Bench) -> bool:
    """Return True if the format of the file's numbers explains `step`, without an encoder."""
    column = bench.columns.get("position")
    if column is not None and column.unit == COUNT:
        return True
    raw = step
    if column is not None:
        with contextlib.suppress(ValueError):  # the log may come from another bench
            scale = unit_scale(column.unit, "position", bench.axis).factor * abs(column.scale)
            raw = step / scale
    exponents = np.log(raw) / np.log((2.0, 10.0))
    return bool(
        step <= SINGLE_PRECISION * np.abs(position).max()
        or np.any(np.abs(exponents - np.rint(exponents)) < POWER)
    )


def _stands_between(steps: Vector, parts: int) -> bool:
    """Return True if the axis often rests between the bench's counts.

    steps: positions (n,) in steps of the log.
    parts: number of these steps in one count.
    """
    places, times = np.unique(steps[1:][np.diff(steps) == 0.0], return_counts=True)
    if not places.size:
        return False
    between = np.count_nonzero((places - places[np.argmax(times)]) % parts)
    return bool(between >= max(FEWEST_BETWEEN, SHARE_BETWEEN * places.size))
