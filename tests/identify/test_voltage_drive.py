"""Inertia of a voltage-driven motor whose winding or late voltage delays the effort, and inertia of
drives whose bench states a lag."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from frictool.identify.fit_result import Interval
from frictool.identify.from_logs import IdentifiedModel, identify
from frictool.logs import log_of
from frictool.typing import Vector
from tests.support.voltage_motor import PERIOD, Motor, log_signals, steps

SAMPLES = 8_000
WINDING = Motor()  # L/R is 1 ms, half of a sample period
LATE = Motor(inductance=3e-5, late=0.5)
QUICK = Motor(inductance=3e-5)
ALONE = ("position", "voltage")
Drive = Literal["voltage", "current"]


@functools.cache
def signals(motor: Motor, seed: int) -> dict[str, Vector]:
    """Return position, voltage and current of random steps."""
    return log_signals(motor, steps(seed, SAMPLES), seed)


@functools.cache
def identified(
    motor: Motor, seed: int, channels: tuple[str, ...], drive: Drive = "voltage", lag: float = 0.0
) -> IdentifiedModel:
    """Return the model from a log with these channels, for a bench with this drive and lag."""
    logged = {name: signals(motor, seed)[name] for name in channels}
    log = log_of(np.arange(SAMPLES) * PERIOD, logged, axis="rotary")
    return identify([log], motor.bench(drive, lag))


def inertia(model: IdentifiedModel) -> Interval:
    """Return the interval of the inertia [kg m^2]."""
    return model.result.identified["inertia"]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("motor", [WINDING, LATE])
def test_a_late_voltage_and_the_winding_are_both_possible(motor: Motor, seed: int) -> None:
    """The delay is the same; the inertia differs by L/R K^2/R. Without a current, the interval
    contains the inertia in both cases, and a warning names both."""
    model = identified(motor, seed, ALONE)
    assert "delay" in model.result.fit.effects
    assert inertia(model).low <= motor.inertia <= inertia(model).high
    (warning,) = (one for one in model.result.warnings if one.startswith("inertia"))
    assert "if the voltage acts late" in warning
    assert "L/R" in warning
    assert len(warning) <= 190


@pytest.mark.parametrize("seed", range(3))
def test_a_logged_current_decides_for_the_winding(seed: int) -> None:
    """Delaying the whole effort would make the inertia too small by L K^2/R^2, which is 3 %. The
    current determines the winding, and thus this difference to a quarter."""
    model = identified(WINDING, seed, (*ALONE, "current"))
    found = inertia(model)
    error = WINDING.inductance * (WINDING.constant / WINDING.resistance) ** 2
    assert found.low <= WINDING.inertia <= found.high
    assert found.value == pytest.approx(WINDING.inertia, abs=0.25 * error)
    assert inertia(identified(WINDING, seed, ALONE)).value < WINDING.inertia - 0.5 * error
    assert any("were added, since the winding" in one for one in model.result.warnings)


def test_a_current_of_another_motor_is_not_used() -> None:
    """The voltage does not explain this current, which then changes nothing."""
    other = dict(signals(WINDING, 0), current=signals(WINDING, 1)["current"])
    log = log_of(np.arange(SAMPLES) * PERIOD, other, axis="rotary")
    model = identify([log], WINDING.bench("voltage"))
    assert inertia(model) == inertia(identified(WINDING, 0, ALONE))
    (warning,) = (one for one in model.result.warnings if one.startswith("inertia"))
    assert "the logged current does not determine" in warning
    assert "also log" not in warning
    assert len(warning) <= 190


@pytest.mark.parametrize("factor", [0.77, 1.3])
@pytest.mark.parametrize("motor", [WINDING, QUICK])
def test_a_logged_current_contradicts_a_wrong_resistance(motor: Motor, factor: float) -> None:
    """The bench's effort per volt K/R is wrong by a factor, and so is the inertia. The log states
    the true ratio, also for a winding without a visible delay; nothing advises to log more."""
    channels = (*ALONE, "current")
    logged = {name: signals(motor, 0)[name] for name in channels}
    log = log_of(np.arange(SAMPLES) * PERIOD, logged, axis="rotary")
    believed = replace(motor, resistance=motor.resistance * factor)
    model = identify([log], believed.bench("voltage"))
    (warning,) = (one for one in model.result.warnings if one.startswith("actuator.constant"))
    assert len(warning) <= 190
    low, high = (float(one) for one in warning.split("[")[2].split("]")[0].split(", "))
    ratio = motor.constant / motor.resistance
    assert low == pytest.approx(ratio, rel=0.02)
    assert high == pytest.approx(ratio, rel=0.02)
    assert not any("also log" in one for one in model.result.warnings)
    assert inertia(model).value == pytest.approx(motor.inertia / factor, rel=0.05)
    right = identified(motor, 0, channels).result.warnings
    assert not any(one.startswith("actuator.constant") for one in right)


@pytest.mark.parametrize("drive", ["voltage", "current"])
def test_the_inertia_is_continuous_in_the_lag(drive: Drive) -> None:
    """A sample period of delay would change the inertia by viscous T, a lag of T/10^6 hardly."""
    channels = ("position", drive)
    without, tiny = (identified(WINDING, 0, channels, drive, lag) for lag in (0.0, 1e-6 * PERIOD))
    viscous = WINDING.damping if drive == "voltage" else WINDING.viscous
    for end in ("value", "low", "high"):
        change = getattr(inertia(tiny), end) - getattr(inertia(without), end)
        assert abs(change) < 0.05 * viscous * PERIOD, end


def test_a_lag_of_a_voltage_drive_only_widens() -> None:
    """The logged voltage is taken as the command: the values do not depend on the lag, whose
    warning says so."""
    lagging = identified(WINDING, 0, ALONE, lag=0.5 * PERIOD)
    without = identified(WINDING, 0, ALONE)
    for name, one in lagging.result.identified.items():
        known = without.result.identified[name]
        assert one.value == known.value
        assert one.low <= known.low
        assert one.high >= known.high
    (warning,) = (one for one in lagging.result.warnings if "loop_time_constant_s" in one)
    assert "taken as the command" in warning
    assert "keep L/R of the winding" in warning
    assert len(warning) <= 190
    assert not any("loop_time_constant_s" in one for one in without.result.warnings)


def test_a_held_voltage_changes_the_current_between_its_samples() -> None:
    """A current is read before each update of a held voltage. The back-EMF lowers these readings by
    up to K a T/(2 R), so that the inertia seems too small by up to K^2 T/(2 R), which is 3 %."""
    motor = WINDING
    alone = identified(motor, 0, ("position", "current"), "current")
    assert inertia(alone).high < motor.inertia
    (warning,) = (one for one in alone.result.warnings if one.startswith("inertia"))
    assert "state actuator.winding" in warning
    assert len(warning) <= 190
    found = inertia(identified(motor, 0, (*ALONE, "current"), "current"))
    assert found.low <= motor.inertia <= found.high
    assert found.high - motor.inertia < 0.01 * motor.inertia
