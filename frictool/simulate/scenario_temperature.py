"""Temperature of a scenario, and how it changes the model's friction."""

from __future__ import annotations

from collections.abc import Mapping

from frictool.adapters.parameter_intervals import UNCHANGED
from frictool.adapters.temperature_factors import factors_at, is_extrapolated, temperature_text
from frictool.documents.laws import FrictionOverTemperature
from frictool.documents.scenario import Scenario


def friction_factors(
    scenario: Scenario, law: FrictionOverTemperature | None
) -> Mapping[str, float]:
    """Return factors of the friction parameters by name; empty if `scenario` has no temperature."""
    if scenario.temperature is None or law is None:
        return UNCHANGED
    return factors_at(law, scenario.temperature.value)


def simulated_temperature(scenario: Scenario, law: FrictionOverTemperature | None) -> str:
    """Return temperature and friction factors as text; "" if the scenario has no temperature."""
    if scenario.temperature is None or law is None:
        return ""
    return temperature_text(law, scenario.temperature.value)


def leaves_law(scenario: Scenario, law: FrictionOverTemperature | None) -> bool:
    """Return True if the temperature is outside the range for which the model was identified."""
    if scenario.temperature is None or law is None:
        return False
    return is_extrapolated(law, scenario.temperature.value)
