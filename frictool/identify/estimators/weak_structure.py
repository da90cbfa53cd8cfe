"""Choice of position polynomials and speed knees for the weak form, by the prediction of strokes.

Friction is a polynomial of the position. The best order has the smallest error in the prediction of
strokes that the fit did not use. The smallest order whose prediction is not significantly worse is
used. The order is 0 unless the best order reduces the rms prediction error significantly and by at
least a fifth.

Viscous friction changes at certain speeds, the knees. Each new knee is placed at the speed at which
the knee reduces the residual most. The knee is kept if the rms prediction error decreases
significantly and by at least a fifth. The order is chosen again after each knee, because a missing
knee looks like a dependence on position.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.identify.fit_result import SLIDING
from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.regression import SingularRegressors, least, residual_norm
from frictool.identify.regression.term_selection import (
    beyond_chance,
    by_stroke,
    clearly_better,
    halved,
    held_out_squares,
)
from frictool.identify.rows.friction_columns import HIGHEST, FrictionRows, bend_column, names_to
from frictool.identify.rows.regression_samples import RegressionSamples, reduced
from frictool.typing import Vector

MOST_KNEES = 2
GRID_POINTS = 30  # grid points of the first search for a knee
ENDS = 0.05  # least share of the rows on either side of a knee, slower and faster


@dataclass(frozen=True)
class FrictionStructure:
    """Dependence of the friction on position and speed.

    - order: degree of the polynomials in the position; 0 for friction that is constant over
      position
    - knees: speeds [rad/s | m/s], ascending, at which the viscous friction changes
    """

    order: int = 0
    knees: tuple[float, ...] = ()


def choose_structure(
    samples: RegressionSamples, parts: Sequence[FrictionRows], overlap: int, confidence: float
) -> FrictionStructure:
    """Return the dependence of friction on position and speed that the strokes support.

    - samples: regression rows with all position columns
    - parts: signals of each record, from which the columns of knees (speeds at which the viscous
      friction changes) are computed
    - overlap: number of successive rows whose errors are correlated
    """
    best = _Comparison(samples, parts, (), overlap, confidence).of_best_order()
    for _ in range(MOST_KNEES):
        candidate = _place(samples, parts, best[0], overlap)
        other = _Comparison(
            samples, parts, (*best[0].knees, candidate), overlap, confidence
        ).of_best_order()
        if not clearly_better(other[1], best[1], confidence):
            break
        best = other
    return best[0]


def with_structure(
    samples: RegressionSamples, parts: Sequence[FrictionRows], structure: FrictionStructure
) -> RegressionSamples:
    """Return the samples with the columns of the sliding parameters and of `structure` only."""
    loads = {name: samples.loads[name] for name in names_to(structure.order)}
    bends = {
        f"bend_{j}": bend_column(parts, knee) for j, knee in enumerate(structure.knees, start=1)
    }
    return replace(samples, loads={**loads, **bends})


class _Comparison:
    """Comparison of polynomial orders on strokes that the fit did not use, with fixed knees."""

    def __init__(
        self,
        samples: RegressionSamples,
        parts: Sequence[FrictionRows],
        knees: tuple[float, ...],
        overlap: int,
        confidence: float,
    ) -> None:
        whole = with_structure(samples, parts, FrictionStructure(HIGHEST, knees))
        self.knees = tuple(sorted(knees))
        self.confidence = confidence
        self.names = (*SLIDING, *whole.loads)
        self.plain, _, _, self.stroke = reduced(
            whole, np.ones(samples.velocity.size), len(SLIDING), overlap
        )

    def squares(self, order: int) -> Vector | None:
        """Return the squared prediction error (s,) of each stroke, by a fit to the other half.

        Return None if one half of the strokes does not determine the fit.
        """
        needless = set(names_to(HIGHEST)) - set(names_to(order))
        columns = [k for k, name in enumerate(self.names) if name not in needless]
        squares = held_out_squares(self.plain, self.plain, halved(self.stroke), columns)
        return None if squares is None else by_stroke(squares, self.stroke)

    def of_best_order(self) -> tuple[FrictionStructure, Vector | None]:
        errors = {
            order: squares
            for order in range(HIGHEST + 1)
            if (squares := self.squares(order)) is not None
        }
        if 0 not in errors:
            return FrictionStructure(0, self.knees), None
        best = min(errors, key=lambda order: float(np.sum(errors[order])))
        chosen = 0
        if clearly_better(errors[best], errors[0], self.confidence):
            chosen = next(
                order
                for order in errors
                if order > 0 and not beyond_chance(errors[best], errors[order], self.confidence)
            )
        return FrictionStructure(chosen, self.knees), errors[chosen]


def _place(
    samples: RegressionSamples,
    parts: Sequence[FrictionRows],
    structure: FrictionStructure,
    overlap: int,
) -> float:
    """Return the speed at which one more knee reduces the residual most, rad/s | m/s."""
    others = with_structure(samples, parts, structure)
    speed = np.abs(samples.velocity)
    low, high = (float(np.quantile(speed, share)) for share in (ENDS, 1.0 - ENDS))
    candidates = np.linspace(low, high, GRID_POINTS)

    def left(bend: Vector) -> float:
        tried = replace(others, loads={**others.loads, "bend": bend})
        runs = reduced(tried, np.ones(speed.size), len(SLIDING), overlap)[0]
        try:
            return residual_norm(runs, least(runs)[0])
        except SingularRegressors:
            return float(np.inf)

    # approximate: not averaged with the test function
    near = int(
        np.argmin(
            [left(samples.sign * np.maximum(speed - candidate, 0.0)) for candidate in candidates]
        )
    )
    return bounded_minimum(
        lambda candidate: left(bend_column(parts, candidate)),
        float(candidates[max(near - 1, 0)]),
        float(candidates[min(near + 1, GRID_POINTS - 1)]),
    )
