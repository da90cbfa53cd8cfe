"""Simulation of servo logs along their goals, and fit of the axis and the servo's constants.

The firmware (engine/firmware_servo.py) drives the axis from goal and simulated position, from the
first sample to the last without a restart. The residual is the position error. Fitted are the axis,
the zero angle of a known pendulum, and those constants of the servo to which the bench gives a
range. A known pendulum determines the drive constant. Without one, the drive constant is the
bench's, and gravity is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from frictool.adapters.servo_firmware import PendulumLoad, firmware_law, pendulum_load
from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.engine.firmware_servo import FirmwareLaw, ServoDrive, follow_goal
from frictool.engine.status_codes import OK
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.rows.load_terms import GRAVITY, TERMS, axis_and_load
from frictool.identify.rows.segments import RecordSegment
from frictool.typing import Matrix, Vector

SINE, COSINE = TERMS[GRAVITY]
ZERO = "zero_angle"  # angle of the pendulum at position 0, rad
LOOSE = "loose_viscous"  # viscous friction with the torque disabled
SERVO = ("constant", "goal_speed", "delay", "back_emf")
STEP = 1e-4  # step of the differences, in units of a parameter's scale
SMALLEST = 1e-3  # least value of a positive parameter in the search, relative to the bench's
LARGEST_ZERO = 0.5  # rad, largest zero angle of a pendulum
MOST_RUNS = 60  # largest number of evaluations in the trust region
FAILED = 10.0  # rad, residual of a failed simulation; it makes the search turn back


def servo_quantities(bench: Bench) -> dict[str, Quantity]:
    """Return the constants of the bench's servo, by name."""
    servo = bench.actuator.servo
    assert servo is not None
    return {
        "constant": bench.actuator.constant,
        "goal_speed": servo.goal_speed,
        "delay": servo.delay,
        "back_emf": servo.back_emf,
    }


def driven_viscous(values: Mapping[str, float]) -> float:
    """Return the viscous friction with the torque enabled, which includes the back-EMF."""
    if LOOSE not in values:
        return values["viscous"]
    return values[LOOSE] + values["constant"] * values["back_emf"]


@dataclass(frozen=True)
class ServoSimulation:
    """Simulation of segments of servo logs.

    - names: free parameters
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
    """Return the status and the position (n,) [rad] of the axis along the goal of a segment.

    `values`: parameters of `axis_and_load` and, for a known pendulum, its zero angle. The pendulum
    of the segment's record replaces that of the bench.
    """
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


@dataclass(frozen=True)
class ServoFit:
    """Values of all parameters, residual (n,) [rad], and Jacobian (n, p) of the free parameters."""

    values: dict[str, float]
    residual: Vector
    jacobian: Matrix


def fitted(simulated: ServoSimulation, start: Mapping[str, float]) -> ServoFit:
    """Return the values that minimise the squared residual; the search starts at `start` [SI].

    Raises UnusableLogs if the search does not converge.
    """
    names = simulated.names
    known = servo_quantities(simulated.bench)
    scale = np.array([_scale(name, simulated.bench, start) for name in names])
    low = np.array([_end(name, known, start, -1) for name in names]) / scale
    high = np.array([_end(name, known, start, 1) for name in names]) / scale

    def residual(z: Vector) -> Vector:
        return simulated.residual(
            {**simulated.fixed, **dict(zip(names, (z * scale).tolist(), strict=True))}
        )

    first = np.array([start[name] for name in names]) / scale
    solution = scipy.optimize.least_squares(
        residual,
        np.clip(first, low + STEP, high - STEP),
        bounds=(low, high),
        diff_step=STEP,
        x_scale="jac",
        max_nfev=MOST_RUNS,
        xtol=1e-5,
        ftol=1e-6,
        gtol=1e-9,
    )
    if not solution.success and solution.status != 0:
        raise UnusableLogs(f"the search along the goal does not converge: {solution.message}")
    values = dict(zip(names, (solution.x * scale).tolist(), strict=True))
    return ServoFit({**simulated.fixed, **values}, solution.fun, solution.jac / scale)


def _scale(name: str, bench: Bench, start: Mapping[str, float]) -> float:
    """Return a typical size of a parameter, SI."""
    if name == ZERO:
        return 0.1
    if name in (SINE, COSINE):
        return start["constant"] * bench.actuator.limit.value
    if name in SERVO:
        return max(servo_quantities(bench)[name].interval[1], 1e-9)
    return max(start[name], 1e-9)


def _end(
    name: str, known: Mapping[str, Quantity], start: Mapping[str, float], side: int
) -> float:
    """Return the lower (side -1) or upper (side 1) end of a parameter in the search, SI."""
    if name in known:
        return known[name].interval[(side + 1) // 2]
    if name == ZERO:
        return side * LARGEST_ZERO
    if name == LOOSE:
        return math.inf if side > 0 else 0.0
    if name in (SINE, COSINE):
        return side * math.inf
    return math.inf if side > 0 else SMALLEST * start[name]
