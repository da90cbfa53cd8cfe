"""Presliding from slow loops of the effort below the breakaway: z_max, stiffness, and the parameters of the laws that have it (2.4.3, 7.2).

A record in which the axis never slips is cut at its reversals. After a reversal at (x_m, F_m) every hysteresis without local memory runs

    F = F_m +- 2 f((x - x_m)/2)          f: the virgin curve, annex A rule II

so that each branch gives points of f, the longest branch the most of it. f is made concave and increasing from 0 (isotonic regression of
its slopes), and reaches F_s at z_max. From it

    stiffness         its slope at 0: sigma_0 of LuGre
    damping           sigma_1 = sqrt(4 J sigma_0): what leaves the stuck axis with a ratio of 1, as a start; slow loops do not tell it
    elastic limit     z_ba, up to where f is straight within the scatter (elasto-plastic)
    Maxwell elements  displacements and forces of a bank through f
    Preisach          Everett's table from centred cycles, where the loops are those (friction/preisach_cycles.py)

The encoder has to see at least ten counts of z_max; else the record is refused with the count that would do.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.optimize import isotonic_regression

from frictool.friction.maxwell_bank import bank_tail
from frictool.friction.preisach_cycles import everett_tail
from frictool.identify.outcome import NothingUsable
from frictool.identify.record import Record, Vector
from frictool.identify.strokes import turning_points

FEWEST_COUNTS = 10.0  # of z_max
POINTS = 12  # of the virgin curve
STRAIGHT = 0.05  # of its first slope: the curve is elastic as long as it loses no more
SAME_SIZE = 0.1  # how far a centred cycle's ends may differ from +-amplitude, relative


@dataclass(frozen=True)
class Presliding:
    """SI, rad | m and N m | N. displacement, force (POINTS,): the virgin curve, ending at (limit, breakaway)."""

    limit: float
    breakaway: float
    stiffness: float
    damping: float
    elastic_limit: float
    displacement: Vector
    force: Vector

    @property
    def maxwell(self) -> Vector:
        """The elements of friction/maxwell_bank.py through the virgin curve."""
        return bank_tail(self.displacement, self.force)


def presliding(record: Record, breakaway: float, inertia: float) -> Presliding:
    """The virgin curve of a record of slow loops that never slips, and what follows of it; `breakaway` N m | N, `inertia` SI.

    Raises NothingUsable where the encoder does not resolve it, or the effort does not come near the breakaway.
    """
    branches = find_branches(record)
    half, change = _virgin_points(branches)
    displacement, force = _concave(half, change)
    if force[-1] < 0.5 * breakaway:
        raise NothingUsable(
            f"the loops reach {100.0 * force[-1] / breakaway:.3g} % of the breakaway; at least 50 % are needed to tell z_max"
        )
    stiffness, limit = float(force[0] / displacement[0]), _limit(displacement, force, breakaway)
    if limit < FEWEST_COUNTS * record.resolution:
        seen, needed = limit / record.resolution, limit / FEWEST_COUNTS
        raise NothingUsable(
            f"z_max is about {limit:.3g}, {seen:.2g} counts of the encoder; a count of {needed:.2g} or less would resolve it"
        )
    slopes = np.diff(force, prepend=0.0) / np.diff(displacement, prepend=0.0)
    straight = displacement[slopes >= (1.0 - STRAIGHT) * stiffness]
    kept = displacement < limit
    curve = np.append(displacement[kept], limit), np.append(force[kept], breakaway)
    return Presliding(
        limit, breakaway, stiffness, float(np.sqrt(4.0 * inertia * stiffness)), float(min(straight.max(), 0.99 * limit)), *curve
    )


def find_branches(record: Record) -> list[tuple[Vector, Vector]]:
    """(positions, efforts) from one reversal of the effort to the next. Raises NothingUsable where there are fewer than two reversals."""
    effort = record.effort
    points = np.empty(effort.size, dtype=np.int64)
    count = turning_points(effort, 0.05 * float(np.ptp(effort)), points)
    if count < 2:
        raise NothingUsable(f"the effort reverses {count} times; loops need at least 2")
    return [
        (record.position[first : last + 1], effort[first : last + 1])
        for first, last in itertools.pairwise((*points[:count], effort.size - 1))
        if abs(record.position[last] - record.position[first]) > record.resolution
    ]


def _virgin_points(branches: list[tuple[Vector, Vector]]) -> tuple[Vector, Vector]:
    """Half the distance from the reversal, and half the change of effort, of all branches, sorted by the distance."""
    if not branches:
        raise NothingUsable("the encoder sees no motion below the breakaway: z_max is below its count")
    distance = np.concatenate([0.5 * np.abs(x - x[0]) for x, _ in branches])
    change = np.concatenate([0.5 * np.abs(u - u[0]) for _, u in branches])
    order = np.argsort(distance, kind="stable")
    return distance[order], change[order]


def _concave(distance: Vector, change: Vector) -> tuple[Vector, Vector]:
    """POINTS points of a curve through 0 whose slopes fall and are not negative."""
    grid = np.linspace(0.0, float(distance[-1]), POINTS + 1)
    hats = np.array([np.interp(distance, grid, row) for row in np.eye(POINTS + 1)[1:]]).T
    values = np.linalg.lstsq(hats, change, rcond=None)[0]
    slopes = isotonic_regression(np.diff(values, prepend=0.0), increasing=False).x
    return grid[1:], np.cumsum(np.maximum(slopes, 0.0))


def _limit(displacement: Vector, force: Vector, breakaway: float) -> float:
    """Where the curve reaches the breakaway; beyond its end along the parabola that its last half fits (friction/virgin_curve.py)."""
    if force[-1] >= breakaway:
        return float(np.interp(breakaway, np.append(0.0, force), np.append(0.0, displacement)))
    left = 1.0 - np.sqrt(1.0 - force / breakaway)  # z/z_max of the parabola
    return float(np.sum(displacement * left) / np.sum(left**2))


def preisach_table(record: Record, amplitudes: int) -> Vector:
    """Everett's table (friction/preisach.py) from centred cycles of amplitudes k z/K, k = 1 .. K = `amplitudes`.

    Raises NothingUsable where the record does not hold a falling branch from +a to -a of each.
    """
    largest = 0.5 * float(np.ptp(record.position))
    centre = 0.5 * float(record.position.max() + record.position.min())
    if largest < FEWEST_COUNTS * amplitudes * record.resolution:
        raise NothingUsable(
            f"the largest cycle is {largest / record.resolution:.3g} counts; {amplitudes} amplitudes need {FEWEST_COUNTS * amplitudes:g}"
        )
    falling = [(x - centre, u) for x, u in find_branches(record) if x[-1] < x[0]]
    cycles = []
    for k in range(1, amplitudes + 1):
        wanted = largest * k / amplitudes
        near = [b for b in falling if max(abs(b[0][0] - wanted), abs(b[0][-1] + wanted)) < SAME_SIZE * largest / amplitudes]
        if not near:
            raise NothingUsable(f"there is no centred cycle of amplitude {wanted:.3g}, number {k} of {amplitudes}")
        cycles.append(_resampled(near[0], wanted))
    return everett_tail(cycles)


def _resampled(branch: tuple[Vector, Vector], amplitude: float) -> tuple[Vector, Vector]:
    """The branch on positions that fall from +amplitude to -amplitude; what repeats a position is averaged."""
    position, back = np.unique(branch[0], return_inverse=True)
    effort = np.bincount(back, branch[1]) / np.bincount(back)
    grid = np.linspace(amplitude, -amplitude, 201)
    return grid, np.interp(grid, position, effort)
