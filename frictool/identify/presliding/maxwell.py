"""Fit of Maxwell-slip elements to slow effort loops below the breakaway.

    F = sum_i k_i delta_i + offset + damping speed

The deflection delta_i of element i follows the path and is limited to +-d_i; the last element never
slips. For fixed yield displacements d_i the model is linear in the non-negative stiffnesses k_i.
The virgin curve is the friction during the first loading of a relaxed contact, f(z) = sum_i k_i
min(z, d_i). The curve is concave and piecewise linear, and reaches the breakaway at z_max. The
parabola of friction/virgin_curve.py continues the curve beyond its last point. The intervals come
from a jackknife over branches, the paths between two reversals of the effort.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.presliding.loops import PreslidingLoops
from frictool.identify.regression.combined_interval import half_width
from frictool.runtime.kernels import kernel
from frictool.typing import Matrix, Vector

ELEMENTS = 12
ENOUGH = 0.5  # least force of the loops relative to the breakaway


@dataclass(frozen=True)
class MaxwellFit:
    """Virgin curve of Maxwell-slip elements: friction during the first loading.

    - displacement: yield displacements d_i, (ELEMENTS,), rad | m
    - force: friction at each displacement, N m | N
    - stiffness: slope of the curve at 0, N m/rad | N/m
    - limit: displacement z_max at which the curve reaches the breakaway, rad | m
    - force_error: rms residual on the branches of the fit, relative to the breakaway
    - held_out: rms residual on branches that the fit did not use, relative to the breakaway
    """

    displacement: Vector
    force: tuple[Interval, ...]
    stiffness: Interval
    limit: Interval
    force_error: float
    held_out: float


@kernel
def element_paths(
    position: Vector, starts: NDArray[np.bool_], displacement: Vector, out: Matrix
) -> None:
    """Compute the deflections of m Maxwell-slip elements along a path.

    - position: positions of the path, (n,), rad | m
    - starts: True for the first row of a record, at which all deflections are 0, (n,)
    - displacement: yield displacement of each element, (m,), rad | m
    - out: result, deflections, (n, m), rad | m
    """
    for k in range(position.shape[0]):
        for i in range(displacement.shape[0]):
            before = 0.0 if starts[k] else out[k - 1, i] + position[k] - position[k - 1]
            out[k, i] = min(max(before, -displacement[i]), displacement[i])


def maxwell(loops: PreslidingLoops, confidence: float) -> MaxwellFit:
    """Return the virgin curve of Maxwell-slip elements that are fitted to the loops.

    Raises UnusableLogs if the forces of the loops are far below the breakaway.
    """
    displacement = loops.reach * np.arange(1, ELEMENTS + 1) / ELEMENTS
    columns = np.empty((loops.position.size, ELEMENTS))
    element_paths(loops.position, loops.starts, displacement, columns)
    used = loops.used
    number = np.unique(loops.branch[loops.used], return_inverse=True)[1]
    rows = np.column_stack((columns, np.ones(columns.shape[0]), loops.speed))[used]
    target = loops.force[used]
    count = int(number.max()) + 1
    parts = [
        (rows[number == b].T @ rows[number == b], rows[number == b].T @ target[number == b])
        for b in range(count)
    ]
    gram, right = sum(part[0] for part in parts), sum(part[1] for part in parts)
    value = _stiffnesses(gram, right)
    curve = np.minimum(displacement[:, None], displacement[None, :])

    def statistics(k: Vector) -> Vector:
        force = curve @ k[:ELEMENTS]
        limit = reached(displacement, force, loops.breakaway.value)
        return np.concatenate((force, [np.sum(k[:ELEMENTS]), limit]))

    quality = statistics(value)
    if quality[ELEMENTS - 1] < ENOUGH * loops.breakaway.value:
        raise UnusableLogs(
            f"the loops reach {100.0 * quality[ELEMENTS - 1] / loops.breakaway.value:.3g} % "
            f"of the breakaway; needed for the presliding distance: at least {100 * ENOUGH:g} %; "
            "raise the effort of the loops"
        )
    left = np.array([statistics(_stiffnesses(gram - one, right - other)) for one, other in parts])
    deviation = np.sqrt((count - 1) / count * np.sum((left - left.mean(axis=0)) ** 2, axis=0))
    deviation *= float(scipy.special.stdtrit(count - 1, 0.5 + 0.5 * confidence)) / float(
        scipy.special.ndtri(0.5 + 0.5 * confidence)
    )
    ends = [
        reached(displacement, quality[:ELEMENTS], end)
        for end in (loops.breakaway.low, loops.breakaway.high)
    ]
    # change of the force over half a count, the uncertainty of the reversal positions
    turned = 0.5 * loops.count * float(quality[-2])
    ranges = [
        *([turned] for _ in displacement),
        [turned / float(displacement[0])],
        [0.5 * (ends[1] - ends[0]), 0.5 * loops.count],
    ]
    half = [half_width(confidence, float(d), r) for d, r in zip(deviation, ranges, strict=True)]
    intervals = tuple(map(Interval.around, quality, half))
    residual = target - rows @ value
    size = loops.breakaway.value
    side = (np.arange(count) // 2) % 2
    unseen = []
    for this in (0, 1):
        fitted = _stiffnesses(
            *(sum(parts[b][j] for b in range(count) if side[b] != this) for j in (0, 1))
        )
        chosen = side[number] == this
        unseen.append(target[chosen] - rows[chosen] @ fitted)
    errors = (
        float(np.sqrt(np.mean(residual**2))) / size,
        float(np.sqrt(np.mean(np.concatenate(unseen) ** 2))) / size,
    )
    return MaxwellFit(displacement, intervals[:ELEMENTS], intervals[-2], intervals[-1], *errors)


def _stiffnesses(gram: Matrix, right: Vector) -> Vector:
    """Return the stiffnesses (>= 0) of the elements, then offset and damping.

    `gram` and `right` are the matrix and the right-hand side of the normal equations.
    """
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    value, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    kept = value > 1e-12 * value[-1]
    root = np.sqrt(value[kept])[:, None] * vectors[:, kept].T
    low = np.append(np.zeros(ELEMENTS), [-np.inf, -np.inf])
    return np.asarray(
        scipy.optimize.lsq_linear(
            root, (vectors[:, kept].T @ (right / scale)) / np.sqrt(value[kept]), (low, np.inf)
        ).x
        / scale
    )


def reached(displacement: Vector, force: Vector, breakaway: float) -> float:
    """Return the displacement [rad | m] at which a virgin curve reaches the breakaway force.

    `displacement` and `force` are points of the curve. Beyond the last point, the curve is
    continued by the parabola of friction/virgin_curve.py.
    """
    if force[-1] >= breakaway:
        return float(np.interp(breakaway, np.append(0.0, force), np.append(0.0, displacement)))
    left = 1.0 - np.sqrt(1.0 - force / breakaway)  # z/z_max of the parabola
    return float(np.sum(displacement * left) / np.sum(left**2))
