"""Temperature of a scenario and its effect on the model's friction."""

from __future__ import annotations

from collections.abc import Mapping

from frictool.adapters.parameter_intervals import UNCHANGED
from frictool.adapters.temperature_factors import factors_at, is_extrapolated, temperature_text
from frictool.documents.laws import FrictionOverTemperature
from frictool.documents.scenario import Scenario


def friction_factors(
    scenario: Scenario, law: FrictionOverTemperature | None
) -> Mapping[str, float]:
    """Return the factors of the friction parameters by name; empty without a temperature."""
    if scenario.temperature is None or law is None:
        return UNCHANGED
    return factors_at(law, scenario.temperature.value)


def simulated_temperature(scenario: Scenario, law: FrictionOverTemperature | None) -> str:
    """Return the temperature and the factors of the friction as text; "" without a temperature."""
    if scenario.temperature is None or law is None:
        return ""
    return temperature_text(law, scenario.temperature.value)


def leaves_law(scenario: Scenario, law: FrictionOverTemperature | None) -> bool:
    """Return True if the temperature is outside the range of the model's logs."""
    if scenario.temperature is None or law is None:
        return False
    return is_extrapolated(law, scenario.temperature.value)
