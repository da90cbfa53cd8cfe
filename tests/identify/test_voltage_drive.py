"""Inertia of a voltage-driven motor whose winding or late voltage delays the effort, and inertia of
drives whose bench states a lag."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Literal

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Encoder
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Quantity
from frictool.identify.fit_result import Interval
from frictool.identify.from_logs import IdentifiedModel, identify
from frictool.identify.held_effort import hold_of
from frictool.identify.motion_record import lagged, make_record, without_lag
from frictool.logs import log_of
from frictool.plant.weak_form import effort_weights
from frictool.typing import Vector
from tests.support.voltage_motor import COUNT, PERIOD, Motor, log_signals, steps

SAMPLES = 6_000
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


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.accept) for k in (1, 2))])
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


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.accept) for k in (1, 2))])
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


@pytest.mark.parametrize(
    ("motor", "factor"),
    [
        (WINDING, 0.77),
        (QUICK, 1.3),
        *(pytest.param(*one, marks=pytest.mark.accept) for one in ((WINDING, 1.3), (QUICK, 0.77))),
    ],
)
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


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.accept)])
def test_a_stated_lag_of_the_winding_explains_the_delay(seed: int) -> None:
    """With L/R in the bench, all intervals contain the true values. The inertia is less by
    L/R K^2/R if the whole effort were late; the interval reaches from there to the true inertia.
    Only the second order of the back-EMF's lag is left to fit."""
    lag = WINDING.inductance / WINDING.resistance
    model = identified(WINDING, seed, ALONE, lag=lag)
    left = model.result.fit.effects.get("delay", Interval(0.0, 0.0, 0.0)).value
    assert -(lag**2) * WINDING.constant**2 / WINDING.resistance < left * WINDING.inertia <= 0.0
    true = {"inertia": WINDING.inertia, "viscous": WINDING.damping, "coulomb": WINDING.coulomb}
    without = identified(WINDING, seed, ALONE).result.identified
    for name, value in true.items():
        one = model.result.identified[name]
        assert one.low <= value <= one.high, name
        assert one.half_width < without[name].half_width, name
    less = lag * WINDING.constant**2 / WINDING.resistance
    assert inertia(model).value == pytest.approx(WINDING.inertia - less, abs=0.2 * less)
    (warning,) = (one for one in model.result.warnings if one.startswith("inertia"))
    assert "up to" in warning


def test_the_lag_is_added_to_declared_loads() -> None:
    """A bench that declares its loads does not exclude the winding."""
    logged = {name: signals(WINDING, 0)[name] for name in ALONE}
    log = log_of(np.arange(SAMPLES) * PERIOD, logged, axis="rotary")
    bench = msgspec.structs.replace(WINDING.bench("voltage"), load=LoadTerms(("offset", "spring")))
    found = identify([log], bench).result
    assert found.fit.load.terms == ("offset", "spring", "delay")
    assert found.identified["inertia"].low <= WINDING.inertia <= found.identified["inertia"].high
    current = {name: signals(WINDING, 0)[name] for name in ("position", "current")}
    other = msgspec.structs.replace(WINDING.bench("current"), load=bench.load)
    driven = identify([log_of(np.arange(SAMPLES) * PERIOD, current, axis="rotary")], other)
    assert driven.result.fit.load is None


def test_a_coarse_encoder_that_hides_a_lag_causes_a_warning() -> None:
    """Noise of the acceleration hides the delay, and a lag would move friction or inertia. The
    warning ends when the bench states the lag."""
    step = 16.0 * COUNT
    counts = np.floor(signals(QUICK, 0)["position"] / step) * step

    def doubts(lag: float) -> list[str]:
        logged = {"position": counts, "voltage": signals(QUICK, 0)["voltage"]}
        bench = msgspec.structs.replace(
            QUICK.bench("voltage", lag), encoder=Encoder(step=Quantity(step, unit="rad"))
        )
        log = log_of(np.arange(SAMPLES) * PERIOD, logged, axis="rotary")
        warnings = identify([log], bench).result.warnings
        return [one for one in warnings if "per ms of the winding's time constant L/R" in one]

    (doubt,) = doubts(0.0)
    assert "actuator.loop_time_constant_s" in doubt
    assert len(doubt) <= 190
    assert not doubts(2e-5)


@pytest.mark.parametrize("lag", [0.1 * PERIOD, PERIOD, 30.0 * PERIOD])
def test_a_lag_delays_the_mean_effort_of_each_period(lag: float) -> None:
    """The effort at the rows, and its mean with a triangular window, are those of a first-order lag
    behind the held command. The command follows from the effort."""
    command = np.random.default_rng(3).normal(size=30).repeat(4)
    time = PERIOD * np.arange(command.size)
    held = make_record("log", time, np.cumsum(command), command, 1.0, 0.0)
    record = lagged(held, lag)
    inside = (np.arange(2_000) + 0.5) / 2_000
    effort, moving = command[0], []
    for k, one in enumerate(command):
        assert record.effort[k] == pytest.approx(effort, abs=1e-12)
        moving.append(one + (effort - one) * np.exp(-PERIOD * inside / lag))
        effort = one + (effort - one) * np.exp(-PERIOD / lag)
    rising, falling = (np.array(moving) @ weight / 2_000 for weight in (inside, 1.0 - inside))
    before, at, after = effort_weights(PERIOD, lag)
    mean = before * record.effort[:-2] + at * record.effort[1:-1] + after * record.effort[2:]
    assert mean == pytest.approx(rising[:-2] + falling[1:-1], abs=1e-5)
    again = without_lag(record, WINDING.bench("voltage"))
    assert again.lag == 0.0
    assert again.effort[:-1] == pytest.approx(command[:-1], abs=1e-8)
    held_for, _ = hold_of(again.effort) or (0, None)
    assert held_for == 4
    assert hold_of(record.effort) is None
