"""Fit of a presliding law, an offset and a damping to the force along measured loops.

    minimise sum (force - law(path; parameters) - offset - damping speed)^2

A branch is the path between two reversals of the effort. The sum has one term for each row of
`loops` whose samples all belong to one branch. Parameters are positive; the search variables are
their logarithms. The intervals come from a jackknife over branches (`regression`), and include the
effect of the breakaway's interval, and of an error of half a count at the ends of the branches
(`combined_interval`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.presliding.loops import PreslidingLoops
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.typing import Vector

FARTHEST = 30.0  # largest factor between a parameter and its start value in the search
MOST_STEPS = 40
# largest standard deviation of a parameter's logarithm; two such deviations are a factor of ten
MOST_UNSURE = 1.2

# loops and parameters (p,) in SI -> force (n,), N m | N
Path = Callable[[PreslidingLoops, Vector], Vector]


@dataclass(frozen=True)
class PreslidingFit:
    """Fit of a presliding law.

    - parameters: intervals of the parameters, in the order of the law
    - force_error: rms residual on the branches of the fit, relative to the breakaway
    - held_out: rms residual on branches that the fit did not use, relative to the breakaway
    - limit: always None, because the largest deflection z_max follows from the breakaway
    """

    parameters: tuple[Interval, ...]
    force_error: float
    held_out: float
    limit: None = None

    @property
    def stiffness(self) -> Interval:
        """Return the stiffness [N m/rad | N/m], the first of `parameters` for every law."""
        return self.parameters[0]


def fit_path(loops: PreslidingLoops, path: Path, start: Vector, confidence: float) -> PreslidingFit:
    """Return the fit of a presliding law to the force along loops.

    - path: function that returns the force of the law along the path of the loops, (n,)
    - start: start values of the parameters, (p,), SI; the first parameter is the stiffness

    Raises UnusableLogs if the loops do not determine the parameters.
    """
    value, details = _minimum(loops, path, start, loops.used)
    residual = (loops.force - details - path(loops, value))[loops.used]
    columns = np.column_stack(
        [*_slopes(loops, path, value), np.ones(loops.force.size), loops.speed]
    )[loops.used]
    try:
        solution = solve(columns, residual, np.ones(residual.size), loops.branch[loops.used])
    except SingularRegressors as error:
        raise UnusableLogs(f"the presliding loops do not determine the law: {error}") from None
    statistical = solution.half_width(confidence)[:-2] / float(
        scipy.special.ndtri(0.5 + 0.5 * confidence)
    )
    ends = [
        _minimum(with_breakaway(loops, end), path, value, loops.used)[0]
        for end in (loops.breakaway.low, loops.breakaway.high)
    ]
    # half a count relative to z_max: uncertainty of the reversal within its count
    counts = 0.5 * loops.count * float(value[0]) / loops.breakaway.value
    if not np.all(np.isfinite(statistical) & (statistical < MOST_UNSURE)):
        raise UnusableLogs(
            "the loops determine a parameter only to within a factor of ten; record more loops"
        )
    estimates = []
    for k, centre in enumerate(value):
        width = half_width(
            confidence,
            float(statistical[k]),
            [0.5 * float(np.log(ends[1][k] / ends[0][k])), counts],
        )
        estimates.append(
            Interval(float(centre), float(centre * np.exp(-width)), float(centre * np.exp(width)))
        )
    size = loops.breakaway.value
    return PreslidingFit(
        tuple(estimates), _rms(residual) / size, _rms(_held_out(loops, path, value)) / size
    )


def with_breakaway(loops: PreslidingLoops, value: float) -> PreslidingLoops:
    """Return the loops with a breakaway of exactly `value`, N m | N."""
    return replace(loops, breakaway=Interval(value, value, value))


def _minimum(
    loops: PreslidingLoops, path: Path, start: Vector, rows: NDArray[np.bool_]
) -> tuple[Vector, Vector]:
    """Return the parameters (p,) fitted to `rows`, and the force (n,) of offset and damping.

    The force is linear in offset and damping, which are therefore eliminated from the search.
    """
    columns = np.column_stack((np.ones(loops.speed.size), loops.speed))
    q, r = np.linalg.qr(columns[rows])

    def residual(x: Vector) -> Vector:
        left = (loops.force - path(loops, np.exp(x)))[rows]
        return np.asarray(left - q @ (q.T @ left)) / loops.breakaway.value

    reach = np.log(FARTHEST)
    value = np.exp(
        scipy.optimize.least_squares(
            residual,
            np.log(start),
            bounds=(np.log(start) - reach, np.log(start) + reach),
            max_nfev=MOST_STEPS,
        ).x
    )
    return value, columns @ np.linalg.lstsq(
        r, q.T @ (loops.force - path(loops, value))[rows], rcond=None
    )[0]


def _slopes(loops: PreslidingLoops, path: Path, value: Vector) -> list[Vector]:
    step = 1e-4
    out = []
    for k in range(value.size):
        up, down = (
            value * np.exp(side * step * (np.arange(value.size) == k)) for side in (1.0, -1.0)
        )
        out.append((path(loops, up) - path(loops, down)) / (2.0 * step))
    return out


def _held_out(loops: PreslidingLoops, path: Path, start: Vector) -> Vector:
    """Return the force error (n,) of each row, predicted by a fit to the other half of the rows."""
    half = (loops.branch // 2) % 2
    errors = []
    for side in (0, 1):
        value, details = _minimum(loops, path, start, loops.used & (half != side))
        errors.append((loops.force - details - path(loops, value))[loops.used & (half == side)])
    return np.concatenate(errors)


def _rms(values: Vector) -> float:
    return float(np.sqrt(np.mean(values**2)))
