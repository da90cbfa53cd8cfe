"""Modulus margin of a controller on a plant, by a sweep over the frequency.

The loop is opened at the drive. The input of a controller C(z) is eta (position reference, or
integral of the speed reference, minus position), or a speed error. The speed is the difference
quotient of the position, filtered by F(z). A proportional position law adds a second loop:

    C, and C (1 + gain T z/(z - 1))         on eta
    C F (1 - 1/z)/T, and C (F (1 - 1/z)/T + gain)         on the speed error

The plant is the axis in slip with lag and delay, sampled exactly. A square-root law is not linear
and belongs to no loop. The margin is the least |1 + L| on the unit circle, or 0 for an unstable
loop.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag, expm

from frictool.typing import ComplexVector, Matrix, Vector
from studies.actuators.drawing import Actuator, Plant

FREQUENCIES = 600  # frequencies of the sweep, over five decades below half the sampling frequency
ZOOMS, ZOOMED = 6, 21  # refinements of the least distance, and frequencies in each
POSITION, MOTION = 0, 1  # outputs of the sampled axis
SCHEDULED = ("inertia", "viscous", "coulomb", "constant")


class Sampled(NamedTuple):
    """Sampled system x+ = a x + b u, y = c x + d u."""

    a: Matrix
    b: Matrix
    c: Matrix
    d: Matrix


def margin(actuator: Actuator, plant: Plant, document: Mapping[str, Any]) -> float:
    """Return the least margin of the loops of a controller document with the plant."""
    period = actuator.period
    linear = _linear(document, plant)
    law = document.get("position_law") or {}
    gain = law["gain"] if law.get("kind") == "proportional" else 0.0
    if linear_input(document) == "speed_error":
        speed = _speed_filter(document.get("velocity") or {}, period)
        loops = [_series(_seen(speed, 0.0, period), linear)]
        loops += [_series(_seen(speed, gain, period), linear)] if gain else []
    else:
        loops = [_series(_static(1.0, 0.0), linear)]
        if gain:
            integral = Sampled(*(np.array([[v]]) for v in (1.0, 1.0, gain * period, gain * period)))
            around = Sampled(integral.a, integral.b, integral.c, integral.d + 1.0)
            loops.append(_series(_series(_static(1.0, 0.0), around), linear))
    return min(loop_margin(sampled_axis(actuator, plant), loop) for loop in loops)


def linear_input(document: Mapping[str, Any]) -> str:
    """Return the input of the linear controller: `eta` or `speed_error`."""
    source = (document.get("velocity") or {}).get("source", "position")
    if source != "position":
        raise NotImplementedError(f"the judge knows no loop with a speed from {source!r}")
    return str(document["linear"].get("input", "eta"))


def cascade_margin(actuator: Actuator, plant: Plant, parameters: Vector) -> float:
    """Return the least margin of the two loops of cascade.c with a linear position law."""
    _, _, _, _, gain, _, proportional, integral_gain, low_pass, *_ = parameters
    one = np.ones((1, 1))
    pi = Sampled(one, one * actuator.period * integral_gain, one, one * proportional)
    keep = 1.0 - low_pass
    speed = Sampled(one * keep, one * 0.5 * low_pass * (1.0 + keep), one, one * 0.5 * low_pass)
    axis = sampled_axis(actuator, plant)
    return min(
        loop_margin(axis, _series(_seen(speed, law, actuator.period), pi)) for law in (0.0, gain)
    )


def sampled_axis(actuator: Actuator, plant: Plant) -> Sampled:
    """Return the slipping axis: input command, outputs position and its change over a sample."""
    continuous = np.zeros((4, 4))  # position, speed, drive, command
    continuous[0, 1] = 1.0
    continuous[1, 1] = -plant.viscous / plant.inertia
    push = plant.constant / plant.inertia
    if actuator.lag > 0.0:
        continuous[1, 2] = push
        continuous[2, 2:] = -1.0 / actuator.lag, 1.0 / actuator.lag
    else:
        continuous[1, 3] = push
    sampled = expm(continuous * actuator.period)
    if actuator.lag == 0.0:
        sampled[2, 2] = 0.0  # without lag, the drive is not a state
    a, b = sampled[:3, :3], sampled[:3, 3:]
    order, delay = 4, actuator.delay
    a = block_diag(a, np.zeros((1, 1)))
    b = np.vstack([b, [[0.0]]])
    a[3, 1:3], b[3] = a[0, 1:3], b[0]  # the motion over the last sample
    c = np.zeros((2, order + delay))
    c[POSITION, 0] = c[MOTION, 3] = 1.0
    for k in range(delay):  # each delay holds the command of the sample before
        a = block_diag(a, np.zeros((1, 1)))
        a[: order + k, order + k] = b[:, 0]
        b = np.zeros((order + k + 1, 1))
        b[-1] = 1.0
    return Sampled(a, b, c, np.zeros((2, 1)))


def loop_margin(axis: Sampled, controller: Sampled) -> float:
    """Return the least |1 + L| of the loop; 0 if it is unstable.

    The inputs of the controller are the outputs of the axis. Without feedback of the position, the
    position is not a state of the loop.
    """
    if not np.any(controller.b[:, POSITION]) and not np.any(controller.d[:, POSITION]):
        kept = slice(1, None)
        axis = Sampled(axis.a[kept, kept], axis.b[kept], axis.c[MOTION:, kept], axis.d[MOTION:])
        controller = Sampled(
            controller.a, controller.b[:, MOTION:], controller.c, controller.d[:, MOTION:]
        )
    loop = _series(axis, controller)
    closed = loop.a - loop.b @ loop.c / (1.0 + loop.d)
    if np.abs(np.linalg.eigvals(closed)).max() >= 1.0:
        return 0.0
    angles = np.geomspace(1e-5 * np.pi, np.pi, FREQUENCIES)
    distances = _distances(loop, angles)
    for _ in range(ZOOMS):
        least = int(np.argmin(distances))
        low, high = angles[max(least - 1, 0)], angles[min(least + 1, angles.size - 1)]
        angles = np.linspace(low, high, ZOOMED)
        distances = _distances(loop, angles)
    return float(distances.min())


def responses(system: Sampled, angles: Vector) -> ComplexVector:
    """Return the frequency response (outputs, n) of a system with one input.

    angles: (n,), rad per sample.
    """
    circle = np.exp(1j * angles)[:, None, None]
    resolvent = np.eye(system.a.shape[0]) * circle - system.a
    states = np.linalg.solve(resolvent, np.broadcast_to(system.b, (angles.size, *system.b.shape)))
    return np.asarray((system.c @ states + system.d)[:, :, 0].T)


def _distances(loop: Sampled, angles: Vector) -> Vector:
    """Return |1 + L| at the angles [rad per sample]."""
    return np.asarray(np.abs(1.0 + responses(loop, angles)[0]))


def _linear(document: Mapping[str, Any], plant: Plant) -> Sampled:
    """Return the linear controller, which may be interpolated for the plant's parameters."""
    linear, schedule = document["linear"], document.get("schedule")
    if schedule is not None:
        return _scheduled(schedule, plant)
    if linear.get("form", "state_space") == "sos":
        whole = _static(1.0)
        for b0, b1, b2, _, a1, a2 in linear["sos"]:
            section = Sampled(
                np.array([[-a1, 1.0], [-a2, 0.0]]),
                np.array([[b1 - a1 * b0], [b2 - a2 * b0]]),
                np.array([[1.0, 0.0]]),
                np.array([[b0]]),
            )
            whole = _series(whole, section)
        return whole
    return _matrices(linear["discrete"])


def _scheduled(schedule: Mapping[str, Any], plant: Plant) -> Sampled:
    """Return the mean of the corners' matrices, weighted for the plant's parameters."""
    if not set(schedule["parameters"]) <= set(SCHEDULED):
        raise NotImplementedError(f"the judge does not schedule {schedule['parameters']}")
    corners, weights = schedule["corners"], []
    for corner in corners:
        weight = 1.0
        for name in schedule["parameters"]:
            ends = [other[name] for other in corners]
            low, high = min(ends), max(ends)
            share = min(max((getattr(plant, name) - low) / (high - low), 0.0), 1.0)
            weight *= share if corner[name] == high else 1.0 - share
        weights.append(weight)
    systems = [_matrices(corner["discrete"]) for corner in corners]
    summed = [sum(w * s[k] for w, s in zip(weights, systems, strict=True)) for k in range(4)]
    return Sampled(*map(np.asarray, summed))


def _matrices(document: Mapping[str, Any]) -> Sampled:
    d = np.array(document["d"], dtype=float).reshape(1, 1)
    order = len(document["a"])
    shapes = {"a": (order, order), "b": (order, 1), "c": (1, order)}
    a, b, c = (np.array(document[key], dtype=float).reshape(shapes[key]) for key in shapes)
    return Sampled(a, b, c, d)


def _static(*gains: float) -> Sampled:
    inputs = len(gains)
    return Sampled(np.zeros((0, 0)), np.zeros((0, inputs)), np.zeros((1, 0)), np.array([gains]))


def _speed_filter(velocity: Mapping[str, Any], period: float) -> Sampled:
    """Return the low-passes of the speed by the trapezoidal rule."""
    bandwidth = velocity.get("bandwidth_rad_s", 0.0)
    if bandwidth == 0.0:
        return _static(1.0)
    half = 0.5 * bandwidth * period
    keep, share = (1.0 - half) / (1.0 + half), half / (1.0 + half)
    one = np.ones((1, 1))
    stage = Sampled(one * keep, one * share * (1.0 + keep), one, one * share)
    return stage if velocity.get("order", 1) == 1 else _series(stage, stage)


def _seen(speed: Sampled, gain: float, period: float) -> Sampled:
    """Return the system from (position, change per sample) to gain * position + speed."""
    order = speed.a.shape[0]
    entering = np.hstack([np.zeros((order, 1)), speed.b / period])
    return Sampled(speed.a, entering, speed.c, np.array([[gain, speed.d[0, 0] / period]]))


def _series(first: Sampled, second: Sampled) -> Sampled:
    """Return the series connection; the output of `first` is the input of `second`."""
    a = block_diag(first.a, second.a)
    order = first.a.shape[0]
    a[order:, :order] = second.b @ first.c
    return Sampled(
        a,
        np.vstack([first.b, second.b @ first.d]),
        np.hstack([second.d @ first.c, second.c]),
        second.d @ first.d,
    )
