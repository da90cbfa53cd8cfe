"""Least squares with the true structure of a machine, the best possible identification.

The regressors are the true velocity and acceleration, and the columns of the family's violation. A
parameter is refused if its interval is as wide as the bench's; the inertia is also refused if its
interval reaches zero.
"""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

from frictool.typing import Vector
from studies.violations.recording import Recording

PARTS = 12  # parts of the log that the jackknife leaves out in turn
NAMES = ("inertia", "viscous", "coulomb", "offset")
SLOWEST = 0.05  # least speed of a sample relative to the largest speed


def least_squares_refuses(recording: Recording, name: str) -> bool:
    """Return True if least squares with the true structure do not determine a parameter."""
    machine = recording.machine
    p = machine.physics
    x, v = recording.motion
    a = np.gradient(v, machine.instruments.period)
    moving = np.abs(v) > SLOWEST * np.max(np.abs(v))
    direction = np.sign(v)
    if not (np.any(direction[moving] > 0.0) and np.any(direction[moving] < 0.0)):
        return name in ("coulomb", "offset")
    columns = [a, v, direction, np.ones(v.size)]
    columns += [x] if p.spring else []
    columns += [np.sin(x), np.cos(x)] if p.gravity else []
    columns += [np.abs(v)] if p.viscous_direction else []
    columns += [direction * np.abs(a)] if p.transmitted else []
    if p.cogging_rate:
        angles = [k * p.cogging_rate * x for k in (1, 2, 3)]
        columns += [wave(angle) for angle in angles for wave in (np.sin, np.cos)]
    rows = np.column_stack(columns)[moving]
    effort = machine.constant * recording.current[moving]
    half = _half_widths(rows, effort)[NAMES.index(name)]
    bench = {
        "inertia": machine.bench_inertia,
        "viscous": machine.bench_viscous,
        "coulomb": machine.bench_coulomb,
        "offset": (0.0, -np.inf, np.inf),
    }[name]
    limit = 0.5 * (bench[2] - bench[1])
    return bool(half >= (min(limit, recording.truth[name]) if name == "inertia" else limit))


def _half_widths(rows: np.ndarray, effort: Vector) -> Vector:
    """Return the half widths (p,) at 95 % by the jackknife over parts of the log."""
    part = np.arange(effort.size) * PARTS // effort.size
    left = np.array(
        [np.linalg.lstsq(rows[part != k], effort[part != k], rcond=None)[0] for k in range(PARTS)]
    )
    spread = np.sum((left - left.mean(axis=0)) ** 2, axis=0) * (PARTS - 1) / PARTS
    return np.asarray(np.sqrt(spread) * stdtrit(PARTS - 1, 0.975))
