"""Kernels for the metrics of a simulated plant; a campaign simulates thousands of plants.

The results of the kernels equal the results of the functions in `frictool/metrics/` and
logs/quality/time_base.py bit by bit.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine.closed_loop import COMMAND, MEASURED, TRUE_DRIVE
from frictool.engine.disturbances_and_faults import SENSOR_GAIN, SENSOR_OFFSET, extremes
from frictool.logs.quality.time_base import FEWEST_LEVELS, MOST_STEPS, ON_LATTICE
from frictool.metrics.response_time import ROUNDED, ZONE
from frictool.metrics.reversals import LEAST_RETURN, LEAST_SENSOR_STEPS
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

OFF_LATTICE = -1.0
MOST_COUNTS = 100  # largest range of the positions in encoder steps, per sample


@kernel
def run_signals(
    record: Vector, conditions: Vector, noise: Vector, position: Vector, measured: Vector
) -> tuple[float, bool]:
    """Return (peak command [A | V], True if all values are finite).

    - record (n, 7): columns as in engine/closed_loop.py
    - conditions (n, 8) or (0, 8): columns as in engine/disturbances_and_faults.py
    - noise (n,): noise of the measured drive

    Two arrays are filled: position (n,) with the measured position, and measured (n,) with the
    measured drive [A | V].
    """
    n = record.shape[0]
    command_peak = 0.0
    finite = True
    for k in range(n):
        position[k] = record[k, MEASURED]
        command = abs(record[k, COMMAND])
        drive = record[k, TRUE_DRIVE]
        if conditions.shape[0] > 0:
            drive = conditions[k, SENSOR_GAIN] * drive + conditions[k, SENSOR_OFFSET]
        drive += noise[k]
        if not math.isfinite(position[k] + command + drive):
            finite = False
        measured[k] = drive
        command_peak = max(command_peak, command)
    return command_peak, finite


@kernel
def lattice_distances(position: Vector, step: float) -> tuple[Vector, float]:
    """Return (distances between neighbouring distinct positions, sum of these distances in steps).

    position (n,): multiples of `step`, as an encoder measures them.

    The sum of the distances divided by the second value is the `encoder_step` of the positions. The
    second value is 0 if the positions have too few different values or no common step. It is
    OFF_LATTICE if a position is not a multiple of `step` or if the range of the positions is too
    large.
    """
    if step <= 0.0:
        return np.empty(0), OFF_LATTICE
    low, high = extremes(position)
    # 16 times the distance of neighbouring floating-point numbers
    rounding = math.ldexp(16.0, math.frexp(max(-low, high))[1] - 53)
    lowest = np.rint(low / step)
    counts = np.rint(high / step) - lowest + 1.0
    if 4.0 * rounding > step or counts > MOST_COUNTS * position.shape[0]:
        return np.empty(0), OFF_LATTICE
    # smallest and largest position at each count, which differ by rounding
    least = np.empty(int(counts))
    largest = np.empty(int(counts))
    for index in range(int(counts)):
        least[index] = math.inf
        largest[index] = -math.inf
    for value in position:
        at = np.rint(value / step)
        if not abs(value - at * step) <= 0.5 * rounding:
            return np.empty(0), OFF_LATTICE
        index = int(at - lowest)
        least[index] = min(least[index], value)
        largest[index] = max(largest[index], value)
    distances = np.empty(least.shape[0])
    used = 0
    last = largest[0]
    for index in range(1, least.shape[0]):
        if least[index] < math.inf:
            distances[used] = least[index] - last
            last = largest[index]
            used += 1
    distances = distances[:used]
    if used < FEWEST_LEVELS - 1:
        return distances, 0.0
    smallest, _ = extremes(distances)
    for parts in range(1, MOST_STEPS + 1):
        part = smallest / parts
        off = 0.0
        steps = 0.0
        for distance in distances:
            whole = np.rint(distance / part)
            off = max(off, abs(distance / part - whole))
            steps += whole
        if off < ON_LATTICE:
            return distances, steps
    return distances, 0.0


@kernel
def step_metrics(
    position: Vector, origin: float, target: float, final: float, tail: int, resolution: float
) -> tuple[int, float, int]:
    """Return (settling sample, overshoot [%], number of reversals) after a step of the reference.

    - position (n,): samples while the reference is constant
    - origin, target: reference before and after the step
    - final: mean of the last `tail` positions

    The 95 % zone is `final` ± 5 % of the step, or ± one sensor step if this is larger. The settling
    sample is the first sample from which the position stays in the zone; -1 if the axis does not
    settle near the target.
    """
    amplitude = target - origin
    zone = max(ZONE * abs(amplitude), resolution) * ROUNDED
    direction = math.copysign(1.0, amplitude)
    n = position.shape[0]
    first = -1
    settled = 0
    excess = -math.inf
    for k in range(n):
        excess = max(excess, (position[k] - target) * direction)
        if abs(position[k] - final) > zone:
            settled = k + 1
        elif first < 0:
            first = k
    if abs(target - final) > 0.5 * abs(amplitude) or settled > n - tail:
        settled = -1
    overshoot = 100.0 * excess / abs(amplitude) if excess > resolution * ROUNDED else 0.0
    return settled, overshoot, _reversals(position, first, amplitude, resolution)


@kernel
def _reversals(position: Vector, first: int, amplitude: float, resolution: float) -> int:
    if first < 0:
        return 0
    least = max(LEAST_SENSOR_STEPS * resolution, LEAST_RETURN * abs(amplitude)) * ROUNDED
    direction = math.copysign(1.0, amplitude)
    extreme = position[first]
    count = 0
    for k in range(first + 1, position.shape[0]):
        if direction * (position[k] - extreme) > 0.0:
            extreme = position[k]
        elif direction * (extreme - position[k]) > least:
            count += 1
            direction = -direction
            extreme = position[k]
    return count
