"""Preisach distribution, as Everett's table, from cycles that are centred at 0 (thesis 7.2).

The cycles have K amplitudes a = k z/K, k = 1 to K, with the largest amplitude z. The falling branch
of each cycle, from +a to -a, is used (friction/preisach_cycles.py). Table r is computed from the
r-th falling branch of each amplitude. The result is the mean over all tables. The interval of the
mean combines Student's interval over the tables and an error of one encoder count.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import scipy

from frictool.friction.preisach_cycles import everett_tail
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.presliding.loops import PreslidingLoops
from frictool.identify.rows.strokes import turning_points
from frictool.typing import Matrix, Vector

MOST, FEWEST = 10, 2  # largest and least number of amplitudes
SAME_SIZE = 0.1  # largest error of a centred cycle's ends, relative to the step between amplitudes
COUNTS = 10.0  # least step between amplitudes, in encoder counts
# counts, and share of the reach, below which a reversal of the position is noise
TURN_COUNTS, TURN = 1.5, 0.02
FEWEST_REPEATS = 2
GRID_POINTS = 201

Branch = tuple[Vector, Vector]  # positions and forces


@dataclass(frozen=True)
class EverettTable:
    """Everett's table of a Preisach operator.

    - everett: Everett's function E(alpha, beta) (defined in friction/preisach.py), divided by the
      saturation, (n + 1, n + 1); one row for each alpha, one column for each beta
    - half_width: half widths of the intervals of the table's elements, (n + 1, n + 1)
    - saturation: half the difference of the forces at the positions +limit and -limit, N m | N
    - limit: largest amplitude of the cycles, rad | m
    """

    everett: Matrix
    half_width: Matrix
    saturation: Interval
    limit: Interval


def preisach(loops: PreslidingLoops, confidence: float) -> EverettTable:
    """Return Everett's table for the largest number of amplitudes that the loops support.

    The loops must contain centred cycles with equally spaced amplitudes, at least FEWEST_REPEATS
    cycles of each amplitude. Raises UnusableLogs if the loops contain no such cycles of FEWEST to
    MOST amplitudes.
    """
    centre = 0.5 * float(loops.position.max() + loops.position.min())
    falling = [(x - centre, f) for x, f in _branches(loops) if x[-1] < x[0]]
    for amplitudes in range(MOST, FEWEST - 1, -1):
        if loops.reach < COUNTS * amplitudes * loops.count:
            continue
        near = [
            _near(falling, loops.reach * k / amplitudes, loops.reach / amplitudes)
            for k in range(1, amplitudes + 1)
        ]
        if min(map(len, near)) >= FEWEST_REPEATS:
            return _table(near, loops, confidence)
    raise UnusableLogs(
        f"the loops have no set of centred cycles with equally spaced amplitudes; needed: "
        f"{FEWEST} to {MOST} amplitudes, each at least {FEWEST_REPEATS} times"
    )


def _branches(loops: PreslidingLoops) -> list[Branch]:
    """Return each branch between two reversals of the position.

    Reversals of the effort are not used: near the largest deflection, noise reverses the effort
    before the axis reverses.
    """
    points = np.empty(loops.position.size, dtype=np.int64)
    edges = []
    threshold = max(TURN_COUNTS * loops.count, TURN * loops.reach)
    for first, last in itertools.pairwise(
        [*np.flatnonzero(loops.starts).tolist(), loops.position.size]
    ):
        turns = points[: turning_points(loops.position[first:last], threshold, points)] + first
        edges += list(itertools.pairwise([first, *turns.tolist(), last - 1]))
    return [(loops.position[start : end + 1], loops.force[start : end + 1]) for start, end in edges]


def _near(falling: list[Branch], amplitude: float, step: float) -> list[Branch]:
    chosen = [
        b
        for b in falling
        if max(abs(b[0][0] - amplitude), abs(b[0][-1] + amplitude)) < SAME_SIZE * step
    ]
    return [_resampled(branch, amplitude) for branch in chosen]


def _resampled(branch: Branch, amplitude: float) -> Branch:
    position, back = np.unique(branch[0], return_inverse=True)
    force = np.bincount(back, branch[1]) / np.bincount(back)
    grid = np.linspace(amplitude, -amplitude, GRID_POINTS)
    return grid, np.interp(grid, position, force)


def _table(near: list[list[Branch]], loops: PreslidingLoops, confidence: float) -> EverettTable:
    repeats = min(map(len, near))
    tables = np.array([everett_tail([branches[r] for branches in near]) for r in range(repeats)])
    falls = np.array([0.5 * float(near[-1][r][1][0] - near[-1][r][1][-1]) for r in range(repeats)])
    reach = float(scipy.special.stdtrit(repeats - 1, 0.5 + 0.5 * confidence)) / np.sqrt(repeats)
    nodes = 2 * len(near) + 1
    steepest = (
        float(np.max(np.abs(np.diff(tables.mean(axis=0).reshape(nodes, nodes)[-1]))))
        * (nodes - 1)
        / (2.0 * loops.reach)
    )
    half = np.hypot(reach * tables.std(axis=0, ddof=1), steepest * loops.count).reshape(
        nodes, nodes
    )
    size = float(falls.mean())
    spread = float(reach * falls.std(ddof=1))
    return EverettTable(
        tables.mean(axis=0).reshape(nodes, nodes),
        half,
        Interval.around(size, spread),
        Interval.around(loops.reach, loops.count),
    )
