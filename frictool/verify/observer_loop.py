"""Linear system of an observer in slip, from the motion and the drive to the speed estimate.

    m[k] = -(y[k] - y[k-1])/T ──▶┐
                                 ├─▶ shown = -v^
    u[k] ───────────────────────▶┘   u ─▶ delay ─▶ lag ─▶ mean effort, as the observer
                                     models it

y is the measured position, u the drive, T the period, and v^ the estimated speed.

The observer uses only the difference of measured and estimated position. A common shift of both
positions is therefore not a state of the speed loop.

The linear system of a tracking observer is corrected by the whole difference of measured and
estimated position, without the dead zone. This is a good approximation for motion over many
counts. Within its dead zone the observer makes no correction, and the estimated speed follows the
model. A switched observer has one system per mode in slip; the loop with each system is checked.
Dry friction and offset are constant in slip; backlash and the speed dependence of the viscous
coefficient are left out.
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
from frictool.typing import Matrix
from frictool.verify.coefficient_rounding import CoefficientRounder
from frictool.verify.hinf_norm import spectral_radius

SHOWN, MOVED, DRIVEN = "shown", "motion", "u"


@dataclass(frozen=True)
class ObserverSpeed:
    """Linear observer whose output is minus the estimated speed [rad/s | m/s].

    The first input is minus the difference quotient of the position [rad/s | m/s], the second is
    the drive [A | V].

    - mode: name of the mode in messages, empty for an observer with one mode
    """

    system: Lti
    mode: str = ""


def shown_speeds(observer: Observer, hold: CoefficientRounder = float) -> tuple[ObserverSpeed, ...]:
    """Return the linear observer of each slip mode; a tracking observer has one mode.

    `hold` is a function that rounds coefficients (verify/coefficient_rounding.py).
    """
    return tuple(
        ObserverSpeed(_with_drive(observer, one.system), one.mode) for one in _alone(observer, hold)
    )


def check_observer(observer: Observer, hold: CoefficientRounder = float) -> None:
    """Raise NoSolutionError if the estimation error does not decay while the axis slips.

    An observer whose error does not decay diverges in any loop.
    """
    for one in _alone(observer, hold):
        radius = spectral_radius(one.system.a)
        if not radius < 1.0:
            raise NoSolutionError(
                f"{observer.name}: not verified: the observer's estimation error grows in slip "
                f"(spectral radius {radius:.6g}"
                f"{' in ' + one.mode if one.mode else ''}); run frictool observe design again"
            )


def _alone(observer: Observer, hold: CoefficientRounder) -> tuple[ObserverSpeed, ...]:
    """Return the linear observer of each mode, with the effort as input instead of the drive.

    The other input is m, minus the difference quotient of the position. The first state is the
    measured minus the estimated position.
    """
    if observer.tracking is not None:
        return (ObserverSpeed(_tracking(observer, hold)),)
    switched = observer.switched
    assert switched is not None
    speeds: dict[tuple[float, ...], ObserverSpeed] = {}
    for mode in switched.modes:
        if mode.direction == 0:
            continue
        coupling = mode.direction * (mode.friction if switched.wear == "multiplicative" else 1.0)
        gains = tuple(row[0] for row in mode.gains)
        if (coupling, *gains) not in speeds:
            system = _switched(
                observer, hold, hold(coupling), (hold(gains[0]), hold(gains[1]), hold(gains[2]))
            )
            speeds[(coupling, *gains)] = ObserverSpeed(system, f"mode {mode.index}")
    return tuple(speeds.values())


def _tracking(observer: Observer, hold: CoefficientRounder) -> Lti:
    """Return the system of a tracking observer from m and the effort to minus the estimated speed.

    m is minus the difference quotient of the position. The states are the measured minus the
    estimated position after a sample, and the predictions of speed and disturbance for the next
    sample.
    """
    tracking = observer.tracking
    assert tracking is not None
    period, (one, two, three) = observer.sample_period_s, (hold(gain) for gain in tracking.gains)
    rate = hold(period / observer.inertia.value)
    viscous = observer.friction.viscous
    # miss = e - T m;  v^ = v + two miss, d^ = d + three miss;  v+ = (1 - rate viscous) v^ + rate
    # (d^ + effort)
    kept = 1.0 - rate * viscous
    miss = np.array([1.0, 0.0, 0.0, -period, 0.0])  # row over (e, v, d, m, effort)
    speed = np.array([0.0, 1.0, 0.0, 0.0, 0.0]) + two * miss
    lacking = np.array([0.0, 0.0, 1.0, 0.0, 0.0]) + three * miss
    after = kept * speed + rate * (lacking + np.array([0.0, 0.0, 0.0, 0.0, 1.0]))
    left = (1.0 - one) * miss - 0.5 * period * (speed + after)
    return _lti(np.stack([left, after, lacking]), -speed, period)


def _switched(
    observer: Observer, hold: CoefficientRounder, coupling: float, gains: tuple[float, float, float]
) -> Lti:
    """Return the system of one slip mode of a switched observer.

    The output is minus the speed estimate before the correction.
    """
    period, (one, two, three) = observer.sample_period_s, gains
    rate = hold(period / observer.inertia.value)
    viscous = observer.friction.viscous
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
    period = observer.sample_period_s
    actuator = observer.bench.actuator
    blocks = {
        "delay": DiagramBlock(delay(observer.bench.delay_samples, period), (DRIVEN,), ("acting",)),
        "lag": DiagramBlock(_mean(actuator.loop_time_constant_s, period), ("acting",), ("mean",)),
        "observer": DiagramBlock(system, (MOVED, "effort"), (SHOWN,)),
    }
    return connect(blocks, {"effort": {"mean": actuator.constant.value}}, (MOVED, DRIVEN), (SHOWN,))


def _mean(lag: float, period: float) -> Lti:
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
