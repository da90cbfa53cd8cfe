"""Simulation of a position servo that receives its logged goals, and fit of axis and servo.

The model of the firmware (engine/firmware_servo.py) drives the axis from the goal and the simulated
position, from the first sample to the last without a restart. The residual is the position error.
The fitted parameters are the parameters of the axis, the angle of a known pendulum at position 0,
and the constants of the servo for which the bench gives a range. A known pendulum determines the
drive constant. If no pendulum is known, the drive constant comes from bench.yaml, and gravity is
fitted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from frictool.adapters.servo_firmware import PendulumLoad, firmware_law, pendulum_load
from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.engine.status_codes import OK
from frictool.identify.estimators.segment_simulation import SimulationFit
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.rows.load_terms import GRAVITY, TERMS, axis_and_load
from frictool.identify.rows.segments import RecordSegment
from frictool.identify.rows.strokes import find_strokes
from frictool.plant.servo_firmware import FirmwareLaw, ServoDrive
from frictool.typing import IntVector, Vector

SINE, COSINE = TERMS[GRAVITY]
ZERO = "zero"  # angle of the pendulum at position 0, rad
LOOSE = "loose_viscous"  # viscous friction with the torque disabled
SERVO = ("constant", "goal_speed", "delay", "back_emf")
DIFFERENCE = 1e-3  # relative step of the numerical derivatives; for smaller steps, residuals jump
MARGIN = 1e-4  # least distance of the start from an end of a range, relative to the typical size
SMALLEST = 1e-3  # least value of a positive parameter in the search, relative to its bench value
# zero angle of a pendulum if the bench does not state it
USUAL_ZERO = Quantity(0.0, -0.5, 0.5, "rad")
DELAY_SHARES = (0.2, 0.4, 0.6, 0.8)  # first delays of the search, as shares of the bench's range
SHORT_RUNS = 8  # evaluations of the search from each delay
MOST_RUNS = 60  # largest number of evaluations in the trust region
FIRST_STROKES = 3  # number of strokes of a free swing that are added to the search one by one
OTHER_FRICTIONS = (0.8, 1.25)  # Coulomb friction of further starts, relative to the best fit
FAILED = 10.0  # rad, residual of a failed simulation; it makes the search turn back


def servo_quantities(bench: Bench) -> dict[str, Quantity]:
    """Return the constants of the bench's servo with their ranges, by name."""
    servo = bench.actuator.servo
    assert servo is not None
    return {
        "constant": bench.actuator.constant,
        "goal_speed": servo.goal_speed,
        "delay": servo.delay,
        "back_emf": servo.back_emf,
        ZERO: servo.zero or USUAL_ZERO,
    }


def driven_viscous(values: Mapping[str, float]) -> float:
    """Return viscous friction plus damping by back-EMF with torque enabled, N m s/rad."""
    if LOOSE not in values:
        return values["viscous"]
    return values[LOOSE] + values["constant"] * values["back_emf"]


@dataclass(frozen=True)
class ServoSimulation:
    """Simulation of segments of the logs of a servo, with one model.

    - names: names of the fitted parameters
    - fixed: values of the other parameters, SI
    """

    segments: Sequence[RecordSegment]
    bench: Bench
    names: tuple[str, ...]
    fixed: Mapping[str, float]

    def positions(self, segment: RecordSegment, values: Mapping[str, float]) -> Vector:
        """Return the simulated position (n,) of a segment, rad; NaN if the simulation fails."""
        law = firmware_law(self.bench)._replace(**{name: values[name] for name in SERVO})
        driven = {"viscous": driven_viscous(values)}
        return simulated_position(segment, self.bench, {**values, **driven}, law)[1]

    def residual(self, values: Mapping[str, float]) -> Vector:
        """Return the measured minus the simulated position (n,) over all segments, rad."""
        parts = []
        for segment in self.segments:
            gap = segment.position - self.positions(segment, values)
            parts.append(gap if np.all(np.isfinite(gap)) else np.full(gap.size, FAILED))
        return np.concatenate(parts)


def simulated_position(
    segment: RecordSegment, bench: Bench, values: Mapping[str, float], law: FirmwareLaw
) -> tuple[int, Vector]:
    """Simulate a servo that follows the goal of a segment; return status and position (n,) [rad].

    - values: parameters of `axis_and_load`, SI; for a known pendulum, also the angle of the
      pendulum at position 0, `zero`, rad
    - law: control law of the servo's firmware

    A pendulum that the record states replaces the pendulum of the bench. The position is NaN if the
    simulation fails.
    """
    from frictool.engine.firmware_servo import follow_goal  # loads the engine

    servo = segment.record.servo
    assert servo is not None
    assert segment.reference is not None
    values = {"offset": 0.0, **values}
    if servo.pendulum is not None:
        nominal = pendulum_load(bench.pendulum) or PendulumLoad()
        angle = values.get(ZERO, 0.0)
        values = {
            **values,
            "inertia": values["inertia"] + servo.pendulum.inertia - nominal.inertia,
            SINE: servo.pendulum.torque * math.cos(angle),
            COSINE: servo.pendulum.torque * math.sin(angle),
        }
    p, load = axis_and_load(values, bench, segment.record)
    part = slice(segment.first, segment.last)
    drive = ServoDrive(*(signal[part] for signal in servo.drive))
    status, position, _ = follow_goal(
        p, load, segment.start(), law, drive, segment.reference, segment.record.period
    )
    return status, position if status == OK else np.full(position.size, np.nan)


def fitted(simulated: ServoSimulation, start: Mapping[str, float]) -> SimulationFit:
    """Return the parameters that minimise the squared residual of a simulation.

    The search starts at the parameters `start` [SI]. In a free swing with the torque disabled, the
    effect of an error of the friction grows from stroke to stroke. The first searches therefore use
    only the first strokes of a swing. If the axis comes to rest, the squared residual has local
    minima; the search is therefore repeated from other values of Coulomb friction. Raises
    UnusableLogs if a search does not converge.
    """
    strokes = np.concatenate([free_strokes(segment) for segment in simulated.segments])
    start = _best_delay(simulated, start, (strokes == 0).astype(np.float64))
    for most in range(min(FIRST_STROKES, int(strokes.max()))):
        start = _search(simulated, start, (strokes <= most).astype(np.float64)).values
    every = np.ones(strokes.size)
    best = _search(simulated, start, every)
    for factor in OTHER_FRICTIONS:
        other = {**best.values, "coulomb": factor * best.values["coulomb"]}
        again = _search(simulated, other, every)
        if np.sum(again.residual**2) < np.sum(best.residual**2):
            best = again
    return best


def _best_delay(
    simulated: ServoSimulation, start: Mapping[str, float], weight: Vector
) -> Mapping[str, float]:
    """Return the best parameters from several short searches, each with another fixed delay.

    Without these searches, the full search may end in a local minimum, with a shorter delay and a
    larger inertia.
    """
    if "delay" not in simulated.names:
        return start
    low, high = servo_quantities(simulated.bench)["delay"].interval
    delays = [start["delay"], *(low + share * (high - low) for share in DELAY_SHARES)]
    names = tuple(name for name in simulated.names if name != "delay")
    fits = []
    for delay in delays:
        held = replace(simulated, names=names, fixed={**simulated.fixed, "delay": delay})
        fits.append(_search(held, {**start, "delay": delay}, weight, SHORT_RUNS))
    return min(fits, key=lambda one: float(np.sum((weight * one.residual) ** 2))).values


def free_strokes(segment: RecordSegment) -> IntVector:
    """Return the number (n,) of strokes completed since the torque was disabled.

    The number is 0 in the first stroke without torque, and while the torque is enabled.
    """
    servo = segment.record.servo
    assert servo is not None
    part = slice(segment.first, segment.last)
    off = servo.drive.enabled[part] <= 0.5
    number = find_strokes(segment.record).number[part]
    began = np.maximum.accumulate(np.where(np.diff(off, prepend=False) & off, number, 0))
    return np.where(off, number - began, 0)


def _search(
    simulated: ServoSimulation, start: Mapping[str, float], weight: Vector, runs: int = MOST_RUNS
) -> SimulationFit:
    names = simulated.names
    known = servo_quantities(simulated.bench)
    scale = np.array([_scale(name, simulated.bench, start) for name in names])
    low = np.array([_end(name, known, start, -1) for name in names]) / scale
    high = np.array([_end(name, known, start, 1) for name in names]) / scale

    def residual(z: Vector) -> Vector:
        return weight * simulated.residual(
            {**simulated.fixed, **dict(zip(names, (z * scale).tolist(), strict=True))}
        )

    first = np.array([start[name] for name in names]) / scale
    solution = scipy.optimize.least_squares(
        residual,
        np.clip(first, low + MARGIN, high - MARGIN),
        bounds=(low, high),
        diff_step=DIFFERENCE,
        x_scale="jac",
        max_nfev=runs,
        xtol=1e-6,
        ftol=1e-7,
        gtol=1e-9,
    )
    if not solution.success and solution.status != 0:
        raise UnusableLogs(f"the fit of the simulated servo does not converge: {solution.message}")
    values = dict(zip(names, (solution.x * scale).tolist(), strict=True))
    return SimulationFit({**simulated.fixed, **values}, solution.fun, solution.jac / scale)


def _scale(name: str, bench: Bench, start: Mapping[str, float]) -> float:
    if name in (SINE, COSINE):
        return start["constant"] * bench.actuator.limit.value
    known = servo_quantities(bench)
    if name in known:
        return max(abs(end) for end in known[name].interval)
    return max(start[name], 1e-9)


def _end(name: str, known: Mapping[str, Quantity], start: Mapping[str, float], side: int) -> float:
    if name in known:
        return known[name].interval[(side + 1) // 2]
    if name == LOOSE:
        return math.inf if side > 0 else 0.0
    if name in (SINE, COSINE):
        return side * math.inf
    return math.inf if side > 0 else SMALLEST * start[name]
