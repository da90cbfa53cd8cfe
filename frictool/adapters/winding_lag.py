"""Lag of a voltage drive by the inductance of the motor's winding (`measurement` of a model)."""

from __future__ import annotations

from frictool.documents.model import Model

DIGITS = 3  # significant digits of the entry that the text suggests


def missing_winding_lag(model: Model) -> str | None:
    """Return a text if the model's voltage drive lacks the measured lag L/R of the winding.

    The result is None if the drive's lag includes L/R, or if L and R were not measured. It is also
    None for a smart servo, whose firmware has its own delay.
    """
    actuator, measured = model.bench.actuator, model.measurement
    if actuator.drive != "voltage" or actuator.servo is not None or measured is None:
        return None
    inductance, resistance = measured.inductance, measured.resistance
    if inductance is None or resistance is None:
        return None
    least = inductance.interval[0] / resistance.interval[1]
    lag = actuator.loop_time_constant_s
    if lag >= float(f"{least:.{DIGITS}g}"):
        return None
    value = f"{inductance.value / resistance.value:.{DIGITS}g}"
    return (
        f"actuator.loop_time_constant_s is {lag:.{DIGITS}g}: the lag of the winding, L/R = {value} "
        f"s, is not in the model; write loop_time_constant_s: {value} into the bench"
    )
