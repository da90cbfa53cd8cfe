"""Factors of viscous and dry friction at a temperature (`laws.temperature`)."""

from __future__ import annotations

import numpy as np

from frictool.documents.laws import FrictionOverTemperature, TemperatureChange
from frictool.typing import Vector

KEY = "temperature"  # key of `temperature_text` in the record `log` of a simulated log
POINTS = 101  # temperatures at which the range of friction is computed
STEEPEST = 50.0  # largest exponent; a log with wrong temperatures must not overflow


def temperature_factors(law: FrictionOverTemperature, temperature: Vector) -> tuple[Vector, Vector]:
    """Return (factors of viscous friction, factors of dry friction), for temperatures [degC]."""
    excess = temperature - law.reference.value
    return _factor(law.viscous, excess), _factor(law.coulomb, excess)


def factors_at(law: FrictionOverTemperature, temperature: float) -> dict[str, float]:
    """Return the factors of the parameters `viscous` and `coulomb` at a temperature [degC].

    The factor of `coulomb` applies to all dry friction: Coulomb friction, breakaway, and the
    friction inside the backlash.
    """
    viscous, dry = temperature_factors(law, np.array([temperature]))
    return {"viscous": float(viscous[0]), "coulomb": float(dry[0])}


def is_extrapolated(law: FrictionOverTemperature, temperature: float) -> bool:
    """Return True if a temperature [degC] is outside the temperatures of the model's logs."""
    return not law.over.low <= temperature <= law.over.high


def temperature_text(law: FrictionOverTemperature, temperature: float) -> str:
    """Return a text on a temperature [degC] and the factors of friction at this temperature."""
    over = f" (extrapolated beyond {law.over.low:.4g} to {law.over.high:.4g} degC)"
    factors = factors_at(law, temperature)
    return (
        f"{temperature:.4g} degC{over if is_extrapolated(law, temperature) else ''}: viscous "
        f"friction {factors['viscous']:.4g} and dry friction {factors['coulomb']:.4g} times that "
        f"at {law.reference.value:.4g} degC"
    )


def temperature_words(owner: str, text: str) -> str:
    """Return a remark on the temperature at which a model is simulated.

    `owner`: name of the model or of its file.
    `text`: temperature and factors of friction as text (`temperature_text`).
    """
    return f"{owner} is simulated at {text}"


def reference_words(law: FrictionOverTemperature, vertices: bool = False) -> str:
    """Return a text on the reference temperature and the range of friction at other temperatures.

    `vertices`: True to add that the model's vertices apply to the reference temperature only. The
    text is empty if the friction changes nowhere within the range of temperature.
    """
    low, high = law.over.low, law.over.high
    factors = temperature_factors(law, np.linspace(low, high, POINTS))
    viscous, dry = (f"{one.min():.3g} to {one.max():.3g}" for one in factors)
    if viscous == dry == "1 to 1":
        return ""
    only = ", and the vertices hold at this temperature only" if vertices else ""
    return (
        f"the friction at {law.reference.value:.4g} degC is used{only}; from {low:.4g} to "
        f"{high:.4g} degC viscous friction is {viscous} and dry friction {dry} times this value"
    )


def _factor(change: TemperatureChange | None, excess: Vector) -> Vector:
    if change is None:
        return np.ones(excess.size)
    curvature = 0.0 if change.curvature is None else change.curvature.value
    exponent = (change.slope.value + curvature * excess) * excess
    return np.asarray(np.exp(np.clip(exponent, -STEEPEST, STEEPEST)))
