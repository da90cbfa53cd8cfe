"""Factors of viscous and dry friction at measured temperatures (`laws.temperature`)."""

from __future__ import annotations

import numpy as np

from frictool.documents.laws import FrictionOverTemperature, TemperatureChange
from frictool.typing import Vector

STEEPEST = 50.0  # largest exponent; a log with wrong temperatures must not overflow


def temperature_factors(law: FrictionOverTemperature, temperature: Vector) -> tuple[Vector, Vector]:
    """Return the factors of viscous and of dry friction at temperatures (n,) [degC], (n,) each."""
    excess = temperature - law.reference.value
    return _factor(law.viscous, excess), _factor(law.coulomb, excess)


def _factor(change: TemperatureChange | None, excess: Vector) -> Vector:
    if change is None:
        return np.ones(excess.size)
    curvature = 0.0 if change.curvature is None else change.curvature.value
    exponent = (change.slope.value + curvature * excess) * excess
    return np.asarray(np.exp(np.clip(exponent, -STEEPEST, STEEPEST)))
