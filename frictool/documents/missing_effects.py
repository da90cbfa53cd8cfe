"""Warnings about effects that a model's logs show, but that the model's equations lack."""

from __future__ import annotations

import math
from collections.abc import Iterator

from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate
from frictool.documents.resonances import Ringing
from frictool.errors import NoSolutionError

KEY = "missing_effects"  # key of the texts, one a line, in the record `log` of a simulated log
# key of the reason why the axis may fail although the simulation passes, in the record `log`
UNDECIDED = "undecided"
DIGITS = 3  # significant digits of the entry that the text suggests


def missing_effects(model: Model) -> Iterator[str]:
    """Yield a warning for each effect that the logs of `model` show, but that `model` lacks."""
    for missing in (
        missing_winding_lag,
        missing_sensor_lag,
        missing_late_position,
        missing_ringing,
        missing_side,
    ):
        if text := missing(model):
            yield text


def undeclared_ringing(model: Model) -> Ringing | None:
    """Return the oscillation in the logs if the model has no resonance, else None."""
    return model.ringing if model.resonances is None else None


def missing_ringing(model: Model) -> str | None:
    """Return a warning if the logs show a resonance, but the model has none; else None."""
    one = undeclared_ringing(model)
    if one is None:
        return None
    rates = (one.rad_s, *(one.interval_rad_s or (one.rad_s,)))
    value, *ends = (f"{rate / (2.0 * math.pi):.3g}" for rate in rates)
    when = "in motion" if one.in_motion else "after stops"
    return (
        f"{when}, the position rings at {value} Hz ({' to '.join(ends)} Hz); margins and "
        "simulations ignore this oscillation; test controllers on a mechanism with this resonance"
    )


def missing_side(model: Model) -> str | None:
    """Return a warning if the model is valid on one side of a position only, else None."""
    if model.valid_side is None:
        return None
    place = model.valid_side.place(model.axis)
    return f"the model is valid {place} only; elsewhere, the logs show another load"


def missing_sensor_lag(model: Model) -> str | None:
    """Return a warning about the commands that ignore or refuse a lag of the position sensor.

    The result is None if the sensor has no lag.
    """
    lag = model.bench.encoder.lag_s
    if lag == 0.0:
        return None
    return (
        f"encoder.time_constant_s is {lag:.{DIGITS}g}: identify and validate include this lag; "
        "exported models and observe ignore it; synth, verify, simulate and prove refuse it"
    )


def missing_late_position(model: Model) -> str | None:
    """Return a warning if the logs show a lag of the position that the bench does not state."""
    late = model.late_position
    if late is None:
        return None
    value, *ends = (f"{1e3 * one:.{DIGITS}g}" for one in (late.value, *late.interval))
    return (
        f"in the logs, the position lags {value} ms ({' to '.join(ends)} ms) more than the bench "
        "states; margins and simulations ignore this lag; set actuator.loop_time_constant_s, "
        "unless time stamps are wrong"
    )


def unstated_lag(late: Estimate) -> str:
    """Return a phrase that states the longest lag of the interval `late` [s]."""
    return f"{1e3 * late.interval[1]:.3g} ms more lag than the bench states"


def intolerable_lag(late: Estimate | None, controller: Controller) -> str:
    """Return why a loop may be unstable with the lag `late_position`; "" if there is no reason.

    late: lag [s]; None without a lag. There is a reason if the lag is longer than the delay that
    the loop tolerates. The result is also "" if controller.yaml does not state this delay.
    """
    margins = controller.verified.margins
    allowed = None if margins is None else margins.delay_s
    if late is None or allowed is None or late.interval[1] <= allowed:
        return ""
    return (
        f"the logs show {unstated_lag(late)}; the loop tolerates a delay of only "
        f"{1e3 * allowed:.3g} ms"
    )


def refuse_sensor_lag(bench: Bench, what: str) -> None:
    """Raise NoSolutionError if the position sensor has a lag.

    what: clause on the work that would ignore the lag, such as "synth designs a controller".
    """
    lag = bench.encoder.lag_s
    if lag > 0.0:
        raise NoSolutionError(
            f"{bench.name}: encoder.time_constant_s: found {lag:.{DIGITS}g} s; {what} only "
            "if the position sensor has no lag (0)"
        )


def missing_winding_lag(model: Model) -> str | None:
    """Return a warning if the model's voltage drive lacks the measured lag L/R of the winding.

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
