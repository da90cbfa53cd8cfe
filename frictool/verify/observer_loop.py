"""The speed that an observer shows, as the linear system that it is in slip: from the motion that
is seen and the drive that is asked for.

    m[k]  = -(y[k] - y[k-1])/T ──▶┐
                                  ├─▶ shown = -v^          drive u ─▶ delay ─▶ lag ─▶ mean effort,
                                                           as the observer models it
    u[k] ────────────────────────▶┘

Its position enters by what the measured position misses it by, so that a common shift of both is no
state: the loop of a speed leaves the position free. Of a tracking observer the miss is taken whole,
as where the axis moves by counts: within the cell nothing enters, and the speed is the model's. Of
a switched observer there is one system for each mode in slip, and each one's loop is looked at by
itself. Dry friction and offset are constant in slip; backlash and knees are left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.documents.observer import Observer
from frictool.errors import NoSolutionError
from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.lti import Lti, delay
from frictool.verify.coefficient_rounding import Held
from frictool.verify.hinf_norm import spectral_radius

Matrix = NDArray[np.float64]
SHOWN, MOVED, DRIVEN = "shown", "motion", "u"


@dataclass(frozen=True)
class ObserverSpeed:
    """Inputs m [rad/s | m/s] and u [A | V], output minus the speed. mode: for people, empty where
    there is one."""

    system: Lti
    mode: str = ""


def shown_speeds(observer: Observer, hold: Held = float) -> tuple[ObserverSpeed, ...]:
    """One of a tracking observer, one for each mode in slip of a switched one; hold:
    verify/coefficient_rounding.py."""
    return tuple(
        ObserverSpeed(_with_drive(observer, one.system), one.mode) for one in _alone(observer, hold)
    )


def check_observer(observer: Observer, hold: Held = float) -> None:
    """Raises NoSolutionError where the observer's own error does not die out in slip: whatever loop
    is around it, it would run away."""
    for one in _alone(observer, hold):
        radius = spectral_radius(one.system.a)
        if not radius < 1.0:
            raise NoSolutionError(
                f"{observer.name}: not verified: the observer's own error grows in slip (spectral radius {radius:.6g}"
                f"{' in ' + one.mode if one.mode else ''}); design it anew (observe design)"
            )


def _alone(observer: Observer, hold: Held) -> tuple[ObserverSpeed, ...]:
    """The observers without their drive, inputs m and the effort; its states are its errors."""
    if observer.tracking is not None:
        return (ObserverSpeed(_tracking(observer, hold)),)
    switched = observer.switched
    assert switched is not None
    found: dict[tuple[float, ...], ObserverSpeed] = {}
    for mode in switched.modes:
        if mode.direction == 0:
            continue
        coupling = mode.direction * (mode.friction if switched.wear == "multiplicative" else 1.0)
        gains = tuple(row[0] for row in mode.gains)
        if (coupling, *gains) not in found:
            system = _switched(
                observer, hold, hold(coupling), (hold(gains[0]), hold(gains[1]), hold(gains[2]))
            )
            found[(coupling, *gains)] = ObserverSpeed(system, f"mode {mode.index}")
    return tuple(found.values())


def _tracking(observer: Observer, hold: Held) -> Lti:
    """From m and the effort to minus v^; states: miss after the correction and the model's way, v,
    d."""
    own = observer.tracking
    assert own is not None
    period, (one, two, three) = observer.sample_period_s, (hold(gain) for gain in own.gains)
    rate, viscous = hold(period / observer.inertia.value), observer.friction.viscous
    # miss = e - T m;  v^ = v + two miss, d^ = d + three miss;  v+ = (1 - rate viscous) v^ + rate
    # (d^ + effort)
    kept = 1.0 - rate * viscous
    miss = np.array([1.0, 0.0, 0.0, -period, 0.0])  # of (e, v, d, m, effort)
    speed = np.array([0.0, 1.0, 0.0, 0.0, 0.0]) + two * miss
    lacking = np.array([0.0, 0.0, 1.0, 0.0, 0.0]) + three * miss
    after = kept * speed + rate * (lacking + np.array([0.0, 0.0, 0.0, 0.0, 1.0]))
    left = (1.0 - one) * miss - 0.5 * period * (speed + after)
    return _lti(np.stack([left, after, lacking]), -speed, period)


def _switched(
    observer: Observer, hold: Held, coupling: float, gains: tuple[float, float, float]
) -> Lti:
    """The same of one mode: its speed is that before this sample's position was seen."""
    period, (one, two, three) = observer.sample_period_s, gains
    rate, viscous = hold(period / observer.inertia.value), observer.friction.viscous
    miss = np.array([1.0, 0.0, 0.0, -period, 0.0])
    speed = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
    wear = np.array([0.0, 0.0, 1.0, 0.0, 0.0])
    after = (
        (1.0 - rate * viscous) * speed
        + rate * (np.array([0.0, 0.0, 0.0, 0.0, 1.0]) - coupling * wear)
        + two * miss
    )
    left = (1.0 - one) * miss - period * speed
    return _lti(np.stack([left, after, wear + three * miss]), -speed, period)


def _lti(rows: Matrix, shown: NDArray[np.float64], period: float) -> Lti:
    return Lti(rows[:, :3], rows[:, 3:], shown[None, :3], shown[None, 3:], period)


def _with_drive(observer: Observer, system: Lti) -> Lti:
    """From m and the drive: the effort as control/drive_model.py has it."""
    period, actuator = observer.sample_period_s, observer.bench.actuator
    blocks = {
        "delay": DiagramBlock(delay(observer.bench.delay_samples, period), (DRIVEN,), ("acting",)),
        "lag": DiagramBlock(_mean(actuator.loop_time_constant_s, period), ("acting",), ("mean",)),
        "observer": DiagramBlock(system, (MOVED, "effort"), (SHOWN,)),
    }
    return connect(blocks, {"effort": {"mean": actuator.constant.value}}, (MOVED, DRIVEN), (SHOWN,))


def _mean(lag: float, period: float) -> Lti:
    """From the drive that acts to its mean over the sample, behind the drive's own loop."""
    if lag == 0.0:
        return Lti(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1)), period)
    left = math.exp(-period / lag)
    part = (1.0 - left) * lag / period
    return Lti(
        np.array([[left]]),
        np.array([[1.0 - left]]),
        np.array([[part]]),
        np.array([[1.0 - part]]),
        period,
    )
