"""Force error of a model along a measured motion, with the same definition for every method.

    force error = rms(g * u - model) / rms(g * u)
    model = inertia (g * ddx) + friction(g * dx, g * x) + offset + g * load(x)

Here u is the effort, x the position, dx the velocity and ddx the acceleration; g * denotes the
convolution with a zero-phase smoothing kernel g (`rows/smoothing.py`). The kernel is the same for
all signals, so that errors outside the frequency band of the motion have no influence. The rms is
taken over the samples at which the axis certainly slips (`rows/slip_mask.py`).

The length of the smoothing window is chosen such that the encoder's noise in the acceleration is
0.75 % of the acceleration; the length is at most a sixth of a stroke. If the axis never slips
during a whole window, the window is shortened. The window depends on the log only, so that methods
can be compared.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.adapters.axis_model import load_law
from frictool.adapters.temperature_factors import temperature_factors
from frictool.documents.bench import Bench
from frictool.documents.laws import Laws, Polynomial
from frictool.documents.quantity import Quantity
from frictool.friction.position_polynomial import normalised_coefficients
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.term_selection import halved
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, full_backlash, stroke_samples
from frictool.identify.rows.slip_mask import slip_mask
from frictool.identify.rows.smoothing import SHORTEST, choose_window, smoothed, smoothing_kernel
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Vector

# largest number of samples evaluated; number of evenly spaced parts that represent longer logs
MOST_SAMPLES, PARTS = 500_000, 20
BINS = 48  # parts of the travel in each of which `predicted_by_position` fits one load

# sliding parameters in SI units, with breakaway and stribeck_velocity if the law has them
Values = Mapping[str, float]


@dataclass(frozen=True)
class SlipRows:
    """Smoothed signals (m,) at the samples of a record at which the axis certainly slips, SI units.

    - window: length of the smoothing window in samples
    - measured: measured position of all samples of the record, (n,)
    - period: sample period, s
    - index: indices (m,) in the record of the samples at which the axis slips
    """

    window: int
    measured: Vector
    period: float
    index: NDArray[np.int64]
    time: Vector
    position: Vector
    velocity: Vector
    acceleration: Vector
    effort: Vector
    temperature: Vector | None = None

    @property
    def rms_effort(self) -> float:
        """Return the rms effort, N m | N."""
        return float(np.sqrt(np.mean(self.effort**2)))

    def modelled_effort(self, values: Values, laws: Laws | None) -> Vector:
        """Return the effort (m,) that a model predicts for the measured motion, N m | N."""
        effort = (
            values["inertia"] * self.acceleration
            + values["offset"]
            + friction_in_slip(values, laws, self.position, self.velocity, self.temperature)
        )
        if laws is not None and laws.load is not None:
            # a ripple may be shorter than the window
            load = load_law(laws.load).at(self.measured)
            effort = effort + np.convolve(load, self._smoothing, mode="same")[self.index]
        return np.asarray(effort)

    @property
    def _smoothing(self) -> Vector:
        return smoothing_kernel(self.window, self.period)


def slip_rows(record: MotionRecord, bench: Bench) -> SlipRows | None:
    """Return the samples of a record at which the axis slips; None if there is no such sample."""
    length = stroke_samples(record)
    if length == 0.0:
        return None
    strokes = find_strokes(record)
    window = choose_window(record, length, SMALLEST_SHARE)
    while True:
        acceleration, velocity, effort = smoothed(record, window)
        index = np.flatnonzero(slip_mask(record, strokes, velocity, window, full_backlash(bench)))
        if index.size or window == SHORTEST:
            break
        window = max(SHORTEST, window // 4 * 2 + 1)
    if index.size == 0:
        return None
    position = np.convolve(record.position, smoothing_kernel(window, record.period), mode="same")
    return SlipRows(
        window,
        record.position,
        record.period,
        index,
        record.time[index],
        position[index],
        velocity[index],
        acceleration[index],
        effort[index],
        None if record.temperature is None else record.temperature.values[index],
    )


def motion_rows(records: Sequence[MotionRecord], bench: Bench) -> list[SlipRows]:
    """Return the samples of all records at which the axis slips.

    If the records together have more than MOST_SAMPLES samples, evenly spaced parts of each record
    are used.
    """
    share = MOST_SAMPLES / sum(record.position.size for record in records) if records else 1.0
    parts = (part for record in records for part in _parts(record, share))
    selected = (slip_rows(part, bench) for part in parts)
    return [rows for rows in selected if rows is not None]


def _parts(record: MotionRecord, share: float) -> list[MotionRecord]:
    if share >= 1.0:
        return [record]
    size = record.position.size
    length = max(int(share * size / PARTS), 1)
    return [
        record.part(slice(first, first + length))
        for first in np.linspace(0, size - length, PARTS).astype(int).tolist()
    ]


def force_error(rows: Sequence[SlipRows], values: Values, laws: Laws | None) -> float | None:
    """Return the relative force error of a model over all rows; None without rows."""
    left = sum(float(np.sum((one.effort - one.modelled_effort(values, laws)) ** 2)) for one in rows)
    size = sum(float(np.sum(one.effort**2)) for one in rows)
    return float(np.sqrt(left / size)) if size > 0.0 else None


def predicted_by_position(rows: Sequence[SlipRows]) -> float | None:
    """Return the relative force error of a model with any load over the position, or None.

    The load is constant in each of BINS parts of the travel, and is fitted together with inertia,
    viscous and Coulomb friction. Each half of the strokes predicts the other half. Positions that
    only one half reaches are left out; the result is None if no position is left.
    """
    if not rows:
        return None
    position = np.concatenate([one.position for one in rows])
    velocity = np.concatenate([one.velocity for one in rows])
    effort = np.concatenate([one.effort for one in rows])
    acceleration = np.concatenate([one.acceleration for one in rows])
    stroke = np.cumsum(np.diff(np.sign(velocity), prepend=0.0) != 0.0)
    half = halved(stroke)
    edges = np.linspace(position.min(), position.max(), BINS + 1)
    part = np.searchsorted(edges[1:-1], position)
    motion = np.column_stack((acceleration, velocity, np.sign(velocity)))
    columns = np.column_stack((motion, part[:, None] == np.arange(BINS)))
    left = size = 0.0
    for side in (0, 1):
        train = half == side
        known = ~train & np.isin(part, part[train])
        value = np.linalg.lstsq(columns[train], effort[train], rcond=None)[0]
        left += float(np.sum((effort[known] - columns[known] @ value) ** 2))
        size += float(np.sum(effort[known] ** 2))
    return float(np.sqrt(left / size)) if size > 0.0 else None


def nearest_values(
    rows: Sequence[SlipRows],
    values: Values,
    laws: Laws | None,
    ranges: Mapping[str, tuple[float, float]],
) -> dict[str, float]:
    """Return `values` with the parameters in `ranges` at the values that minimise the force error.

    The effort is linear in these parameters. Each of them stays within its range (low, high). For
    each parameter, the search tries the lower limit, the upper limit, and a fit without limit, in
    all combinations.
    """
    if not rows or not ranges:
        return dict(values)
    start = {**values, **dict.fromkeys(ranges, 0.0)}

    def effort(some: Values) -> Vector:
        return np.concatenate([one.modelled_effort(some, laws) for one in rows])

    base = effort(start)
    right = np.concatenate([one.effort for one in rows]) - base
    columns = np.column_stack([effort({**start, name: 1.0}) - base for name in ranges])
    gram, moment = columns.T @ columns, columns.T @ right
    best, least = values, np.inf
    for ends in itertools.product(*((None, *ends) for ends in ranges.values())):
        found = np.array([np.nan if end is None else end for end in ends])
        free = np.isnan(found)
        known = moment[free] - gram[np.ix_(free, ~free)] @ found[~free]
        found[free] = np.linalg.pinv(gram[np.ix_(free, free)]) @ known
        inside = all(
            low <= value <= high
            for value, (low, high) in zip(found.tolist(), ranges.values(), strict=True)
        )
        cost = float(found @ gram @ found - 2.0 * moment @ found)
        if inside and cost < least:
            best, least = {**values, **dict(zip(ranges, found.tolist(), strict=True))}, cost
    return dict(best)


def friction_in_slip(
    values: Values,
    laws: Laws | None,
    position: Vector,
    velocity: Vector,
    temperature: Vector | None = None,
) -> Vector:
    """Return the friction force (n,) [N m | N] of an axis that slips.

    The force has the sign of the velocity. `position`, `velocity` and `temperature` [degC] are
    (n,). If `temperature` is None, the reference temperature of the laws is used.
    """
    warm = np.ones((2, velocity.size))
    if temperature is not None and laws is not None and laws.temperature is not None:
        warm[:] = temperature_factors(laws.temperature, temperature)
    out = np.empty(velocity.size)
    for side, chosen in ((1.0, velocity >= 0.0), (-1.0, velocity < 0.0)):
        parts = _one_way(values, laws, side, position[chosen], np.abs(velocity[chosen]))
        out[chosen] = side * np.sum(warm[:, chosen] * parts, axis=0)
    return out


def _one_way(
    values: Values, laws: Laws | None, side: float, position: Vector, speed: Vector
) -> tuple[Vector, Vector]:
    """Return viscous and dry friction (n,) [N m | N] at speeds (n,) >= 0 in direction `side`."""
    backward = laws.backward if laws is not None and side < 0.0 else None

    def level(name: str) -> float:
        estimate: Quantity | None = getattr(backward, name, None)
        return values[name] if estimate is None else estimate.value

    coulomb, slope = level("coulomb"), level("viscous")
    dry = np.full(speed.size, coulomb)
    viscous = slope * speed
    for regime in () if laws is None else laws.regimes:
        above = ((regime.backward if side < 0.0 else None) or regime.viscous).value
        viscous = viscous + (above - slope) * np.maximum(speed - regime.above.value, 0.0)
        slope = above
    fall = np.full(
        speed.size,
        max(level("breakaway") - coulomb, 0.0) if values.get("stribeck_velocity") else 0.0,
    )
    if laws is not None and laws.position is not None:
        over, slip = laws.position.over, laws.position.coulomb
        dry = dry * _factor(slip, side, over.low, over.high, position)
        fall = fall * _factor(laws.position.breakaway or slip, side, over.low, over.high, position)
    if values.get("stribeck_velocity"):
        exponent = 2.0 if laws is None else laws.stribeck_exponent
        dry = dry + fall * np.exp(-((speed / values["stribeck_velocity"]) ** exponent))
    return np.asarray(viscous), np.asarray(dry)


def _factor(
    polynomial: Polynomial, side: float, low: float, high: float, position: Vector
) -> Vector:
    terms = polynomial.forward if side > 0.0 else polynomial.backward or polynomial.forward
    curve = np.polynomial.polynomial.polyval(
        np.clip(position, low, high), normalised_coefficients(tuple(terms), low, high)
    )
    return np.asarray(np.maximum(curve, 0.0))
