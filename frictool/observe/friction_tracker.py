"""Friction along a log with its interval: the model's friction times the wear factor."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import TypeVar

import msgspec
import numpy as np

from frictool.adapters.axis_model import axis_of, extended_axis, load_of
from frictool.adapters.temperature_factors import temperature_factors
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.observe.kernels.friction_interval import (
    GAPS,
    KNOWN,
    STATE_SIZE,
    ZONE_SIZE,
    friction_along,
)
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear_estimate import EstimateRange, UnmodelledFall, WearEstimate
from frictool.plant.axis_friction_laws import STRIBECK_EXPONENT
from frictool.typing import Matrix, Vector

S = TypeVar("S", bound=msgspec.Struct)
NONE = EstimateRange(0.0, 0.0, 0.0)
# relative standard deviation of the friction at one position around a model's friction
ROUGH = 0.01
UNBOUNDED = 1e6  # upper bound of the wear if none is known; a log contains finite numbers only
# half widths of the backlash and of the friction inside it, relative to the value, if the bench has
# no range
WIDTH, LOOSE = 0.2, 0.4


class FrictionTracker:
    """Estimator of friction along a log, block by block.

    `confidence` is the confidence of the intervals, 0 to 1.
    """

    def __init__(self, model: Model, confidence: float = 0.95) -> None:
        self._axes = np.stack(
            [
                extended_axis(one)
                for one in (model, _with_viscous(model, 0), _with_viscous(model, 1))
            ]
        )
        self._load = load_of(model).as_array()
        mechanics = model.bench.mechanics
        inertia = model.parameters.inertia.interval[1]
        loose = Quantity(axis_of(model).backlash_coulomb, *_ends(mechanics.backlash_coulomb))
        self._gap = np.stack(
            [_unsure(mechanics.backlash or Quantity(0.0), WIDTH), _unsure(loose, LOOSE)]
        )
        self._swing = inertia / (2.0 * model.bench.encoder.resolution)
        self._quantile = NormalDist().inv_cdf(0.5 + 0.5 * confidence)
        self._temperature = model.laws.temperature if model.laws is not None else None
        self._state = np.zeros(STATE_SIZE)

    def take(
        self, piece: MotionBlock, velocity: Matrix, known: Sequence[tuple[int, WearEstimate]]
    ) -> Matrix:
        """Process a block; return value, lower and upper bound of the friction (3, n) [N m | N].

        Friction is positive if it opposes a positive velocity.

        - velocity: value, lower and upper bound, (3, n), rad/s | m/s
        - known: pairs (index of a sample, wear estimate that applies from this sample); the first
          pair has index 0
        """
        if not piece.follows:
            self._state[KNOWN], self._state[GAPS:] = 0.0, 0.0
        out = np.empty((3, piece.time.size))
        warm = np.ones((2, piece.time.size))
        if self._temperature is not None and piece.temperature is not None:
            warm[:] = temperature_factors(self._temperature, piece.temperature)
        ends = [*(start for start, _ in known[1:]), piece.time.size]
        for (low, estimate), high in zip(known, ends, strict=True):
            factors, zones = _worn(estimate, self._quantile * ROUGH)
            part = slice(low, high)
            falls = self._falls(estimate.fall, velocity[0, part])
            friction_along(
                self._axes,
                self._load,
                self._gap,
                self._swing,
                factors,
                zones,
                falls,
                self._quantile,
                piece.position[part],
                velocity[:, part],
                piece.effort[part],
                warm[:, part],
                self._state,
                out[:, part],
            )
        return out

    def _falls(self, fall: UnmodelledFall | None, velocity: Vector) -> Matrix:
        """Return the friction of `fall` at each velocity, and its half width, (n, 2) [N m | N]."""
        out = np.zeros((velocity.size, 2))
        if fall is not None:
            exponent = self._axes[0, STRIBECK_EXPONENT]
            parts = np.exp(-((np.abs(velocity)[:, None] / np.array(fall.speeds)) ** exponent))
            variances = np.einsum("ni,ij,nj->n", parts, np.array(fall.covariance), parts)
            out[:, 0] = parts @ np.array(fall.values)
            out[:, 1] = self._quantile * np.sqrt(np.maximum(variances, 0.0))
        return out


def _ends(quantity: Quantity | None) -> tuple[float | None, float | None]:
    return (None, None) if quantity is None else (quantity.low, quantity.high)


def _unsure(quantity: Quantity, part: float) -> Vector:
    """Return value, lower and upper end (3,) of a quantity.

    If the quantity has no range, the ends are (1 - `part`) and (1 + `part`) times the value.
    """
    low, high = quantity.interval
    if low == high:
        low = (1.0 - part) * quantity.value
        high = (1.0 + part) * quantity.value
    return np.array([quantity.value, low, high])


def _worn(estimate: WearEstimate, rough: float) -> tuple[Matrix, Matrix]:
    """Return the wear as the arrays `factors` (3, 3) and `zones` (k, 5).

    kernels/friction_interval.py describes the arrays. The relative half width of a factor is
    sqrt(rough^2 + w^2), where w is the relative half width of the wear.

    - rough: relative half width of the friction at one position
    """
    is_added = estimate.kind == "additive" and estimate.added is not None
    both = EstimateRange(1.0, 1.0, 1.0) if is_added else estimate.wear
    sides = (both, both)
    if estimate.kind == "directional":
        sides = (estimate.forward or both, estimate.backward or both)
    added = estimate.added if is_added and estimate.added is not None else NONE
    factors = np.array(
        [*(_ends_of(one, rough) for one in sides), [added.value, added.low, added.high]]
    )
    zones = [[zone.low, zone.high, *_ends_of(zone.wear, rough)] for zone in estimate.zones]
    return factors, np.array(zones if estimate.kind == "zones" else []).reshape(-1, ZONE_SIZE)


def _ends_of(wear: EstimateRange, rough: float) -> list[float]:
    deviation = rough * wear.value
    low = math.hypot(wear.value - wear.low, deviation)
    high = math.hypot(min(wear.high, UNBOUNDED) - wear.value, deviation)
    return [max(0.0, one) for one in (wear.value, wear.value - low, wear.value + high)]


def _with_viscous(model: Model, end: int) -> Model:
    """Return the model with each viscous friction at one end of its interval.

    `end`: 0 for the lower, 1 for the upper end.
    """

    def at_end(quantity: Quantity | None) -> Quantity | None:
        return (
            None
            if quantity is None
            else msgspec.structs.replace(quantity, value=max(0.0, quantity.interval[end]))
        )

    def replaced(part: S, *names: str) -> S:
        return msgspec.structs.replace(
            part, **{name: at_end(getattr(part, name)) for name in names}
        )

    laws = model.laws
    if laws is not None:
        backward = None if laws.backward is None else replaced(laws.backward, "viscous")
        regimes = tuple(replaced(regime, "viscous", "backward") for regime in laws.regimes)
        laws = msgspec.structs.replace(laws, backward=backward, regimes=regimes)
    return msgspec.structs.replace(
        model, parameters=replaced(model.parameters, "viscous"), laws=laws
    )


def estimate_starts(
    piece: MotionBlock, before: WearEstimate, estimates: Sequence[WearEstimate]
) -> list[tuple[int, WearEstimate]]:
    """Return pairs (index of a sample in the block, wear estimate that applies from this sample).

    An estimate applies from the sample after the last sample that it uses. If several estimates
    start at the same sample, only the last estimate is kept.
    """
    starts = [0, *(int(np.searchsorted(piece.time, one.time, side="right")) for one in estimates)]
    pairs = [
        (start, one)
        for start, one in zip(starts, (before, *estimates), strict=True)
        if start < piece.time.size
    ]
    return [
        one
        for one, after in itertools.zip_longest(pairs, pairs[1:])
        if after is None or after[0] > one[0]
    ]
