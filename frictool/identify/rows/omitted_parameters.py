"""Widening of intervals by parameters of the machine that a regression does not fit.

A fixed parameter is not fitted, but has a known value, for example the value in `bench.yaml` or
from another fit. The interval of a fixed parameter widens the intervals of the fitted parameters.

A hidden load is a declared load that the motion cannot separate from the other parameters, because
the travel is too short (`load_columns.indistinct_terms`). In the model, a hidden load is 0, and its
possible effect widens the intervals of the fitted parameters. If the bench has the key `load.most`,
the effort of the load is at most this value. Without this key, the intervals are as wide as in a
fit that includes the load.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from frictool.identify.fit_result import Interval
from frictool.identify.regression.regression import (
    LeastSquaresSolution,
    SingularRegressors,
    solve_triangles,
)
from frictool.identify.regression.tsqr import Tensor, merged
from frictool.identify.rows.load_terms import TERMS
from frictool.typing import IntVector, Matrix, Vector

DIRECTIONS = 90  # number of phases of a harmonic that are tried, over half a turn


class OmittedParameters:
    """Parameters that a fit omits, and the half widths that they add to the fitted parameters.

    - names: names of the columns of `weighted`
    - weighted: triangular matrices (g, q, q) of g groups of successive rows
    - fixed: parameters with fixed values, and their intervals
    - hidden: names of the hidden loads, which the motion cannot separate from other parameters
    """

    def __init__(
        self,
        names: Sequence[str],
        weighted: Tensor,
        fixed: Mapping[str, Interval],
        hidden: Sequence[str],
    ) -> None:
        self.free = [name for name in names if name not in fixed and name not in hidden]
        self._names = list(names)
        self._weighted = weighted
        self._hidden = list(hidden)
        self._known = {name: fixed[name] for name in names if name in fixed}
        self._added = np.zeros(len(self.free))
        whole = merged(weighted)
        outside = [*self._known, *hidden]
        columns = whole[:, [self._names.index(name) for name in self.free]]
        self._slope = {}
        if outside:
            slopes = np.linalg.lstsq(
                columns, whole[:, [self._names.index(name) for name in outside]], rcond=None
            )[0]
            self._slope = dict(zip(outside, slopes.T, strict=True))
        for name, interval in self._known.items():
            self._add(
                np.abs(self._slope[name])
                * max(interval.high - interval.value, interval.value - interval.low)
            )

    def add_loads(
        self, loads: Mapping[str, Vector], most: float | None, cluster: IntVector, confidence: float
    ) -> None:
        """Add the possible effect of the hidden loads to the half widths.

        - loads: column (n,) of each load
        - most: largest effort of each load, N m | N; None if unknown
        - cluster: number of the cluster of each group of rows, (g,)
        """
        if not self._hidden:
            return
        effects = self._hidden_load_shift(cluster, confidence)
        if most is None:
            self._add(effects)
            return
        total = np.zeros(len(self.free))
        for names in TERMS.values():
            group = [name for name in names if name in self._hidden]
            if group:
                points = most * unit_loads([loads[name] for name in group])
                total += np.max(
                    np.abs(np.column_stack([self._slope[name] for name in group]) @ points.T),
                    axis=1,
                )
        self._add(np.minimum(total, effects))

    def widened(self, names: Sequence[str], half: Vector) -> Vector:
        """Return the half widths `half` (p,) of `names`, widened for the omitted parameters."""
        added = dict(zip(self.free, self._added.tolist(), strict=True))
        if "viscous_backward" in names:
            added["viscous_backward"] += added.get("viscous", 0.0)
        if "coulomb_backward" in names:
            added["coulomb"] = added["coulomb_backward"] = added["coulomb"] + added["offset"]
        return np.hypot(half, [added.get(name, 0.0) for name in names])

    def _add(self, half: Vector) -> None:
        self._added = np.hypot(self._added, half)

    def _hidden_load_shift(self, cluster: IntVector, confidence: float) -> Vector:
        """Return the largest change (p,) of the parameters if the fit includes the hidden loads.

        The half widths of the fit with the hidden loads are added to the magnitude of the change.
        The result is inf if the rows do not determine this fit.
        """
        with_loads, without = (
            self._solution([*self.free, *more], cluster) for more in (self._hidden, [])
        )
        if with_loads is None or without is None:
            return np.full(len(self.free), np.inf)
        kept = len(self.free)
        return np.asarray(
            np.abs(with_loads.value[:kept] - without.value)
            + with_loads.half_width(confidence)[:kept]
        )

    def _solution(self, names: Sequence[str], cluster: IntVector) -> LeastSquaresSolution | None:
        columns = [*(self._names.index(name) for name in names), -1]
        try:
            return solve_triangles(self._weighted[:, :, columns], cluster)
        except SingularRegressors:
            return None


def unit_loads(columns: Sequence[Vector]) -> Matrix:
    """Return m sets of coefficients (m, k) of k loads; each set has a peak effort of 1."""
    if len(columns) == 1:
        return np.array([[1.0 / float(np.max(np.abs(columns[0])))]])
    angles = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    directions = np.column_stack((np.cos(angles), np.sin(angles)))
    reach = np.array(
        [float(np.max(np.abs(one * columns[0] + other * columns[1]))) for one, other in directions]
    )
    return np.asarray(directions / reach[:, None])
