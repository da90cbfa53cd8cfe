"""Regression rows with columns for the hypotheses of `explanation_search`, and fits to these rows.

Groups of rows are reduced to triangular matrices, so that each of the many fits takes little time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frictool.identify.fit_result import SLIDING
from frictool.identify.regression.joint_test import joint_probability
from frictool.identify.regression.regression import SingularRegressors, least
from frictool.identify.regression.term_selection import by_stroke, halved
from frictool.identify.regression.tsqr import Tensor, merged
from frictool.identify.rows.effects import DELAY, Hypothesis
from frictool.identify.rows.load_columns import indistinct_terms
from frictool.identify.rows.regression_samples import RegressionSamples
from frictool.typing import IntVector, Matrix, Vector

# least effort of a hypothesis, relative to the effort that the encoder's noise causes
ABOVE_NOISE = 3.0


@dataclass(frozen=True)
class ReducedRows:
    """Regression rows in g groups of successive rows; each group is reduced to a triangular matrix.

    - samples: rows before the reduction
    - plain: triangular matrix of each group by QR, (g, q, q), from q - 1 regressors and the effort
    - names: names of the regressors, (q - 1,)
    - base: names of the regressors that every fit includes
    - cluster, stroke: number of the cluster and of the stroke of each group, (g,)
    - noise: rms noise of the acceleration due to the encoder, rad/s^2 | m/s^2
    """

    samples: RegressionSamples
    plain: Tensor
    cluster: IntVector
    stroke: IntVector
    names: tuple[str, ...]
    base: tuple[str, ...]
    noise: float

    def columns(self, hypotheses: Sequence[Hypothesis]) -> list[int]:
        """Return the indices of the columns that a fit with `hypotheses` uses."""
        chosen = {*self.base, *(name for one in hypotheses for name in one.names)}
        return [k for k, name in enumerate(self.names) if name in chosen]

    @cached_property
    def half(self) -> IntVector:
        """Return 0 or 1 for each group of rows (g,): the half of the strokes with this group."""
        return halved(self.stroke)

    @cached_property
    def sides(self) -> Tensor:
        """Return the triangular matrices of the two halves of the strokes, (2, q, q)."""
        return np.array([_triangle(self.plain[self.half == side]) for side in (0, 1)])

    def fitted(self, columns: Sequence[int]) -> Vector:
        """Return the parameters (p,) of the columns with indices `columns`, fitted to all rows."""
        return least(self.sides[:, :, [*columns, -1]])[0]

    def squares(self, hypotheses: Sequence[Hypothesis]) -> Vector | None:
        """Return the squared prediction error of each stroke in fits with `hypotheses`, (s,).

        Each half of the strokes is predicted by a fit to the other half. Return None if one half of
        the strokes does not determine the parameters.
        """
        chosen = [*self.columns(hypotheses), -1]
        out = np.empty(self.half.size)
        for side in (0, 1):
            try:
                value = least(self.sides[1 - side : 2 - side, :, chosen])[0]
            except SingularRegressors:
                return None
            parts = self.plain[self.half == side][:, :, chosen]
            out[self.half == side] = np.sum(
                (parts[:, :, -1] - parts[:, :, :-1] @ value) ** 2, axis=1
            )
        return by_stroke(out, self.stroke)

    def probability(self, tested: Hypothesis, others: Sequence[Hypothesis]) -> float:
        """Return the p-value of the test that all parameters of the hypothesis `tested` are 0.

        The fit contains the columns of `tested` and of the hypotheses `others`.
        """
        columns = self.columns([*others, tested])
        indices = [k for k, column in enumerate(columns) if self.names[column] in tested.names]
        return joint_probability(self.plain[:, :, [*columns, -1]], self.cluster, indices)

    def effort(self, tested: Hypothesis, others: Sequence[Hypothesis]) -> float:
        """Return the rms effort [N m | N] of the hypothesis `tested`, fitted with `others`."""
        columns = self.columns([*others, tested])
        value = self.fitted(columns)
        factor = np.zeros(len(self.names))
        for k, one in zip(columns, value, strict=True):
            factor[k] = one if self.names[k] in tested.names else 0.0
        size = float(np.linalg.norm(self.sides[:, :, :-1] @ factor))
        return size / float(np.sqrt(self.samples.velocity.size))

    def fitted_to(self, tested: Hypothesis, others: Sequence[Hypothesis]) -> Vector:
        """Return the parameters of the hypothesis `tested`, fitted together with `others`."""
        columns = self.columns([*others, tested])
        chosen = [self.names[k] in tested.names for k in columns]
        return np.asarray(self.fitted(columns)[chosen])

    def amplitude(self, tested: Hypothesis, others: Sequence[Hypothesis]) -> float:
        """Return the amplitude [N m | N] of the ripple `tested`, fitted together with `others`."""
        return float(np.linalg.norm(self.fitted_to(tested, others)))

    def visible(self, tested: Hypothesis, others: Sequence[Hypothesis]) -> bool:
        """Return True if the rows determine the hypothesis `tested`, and noise cannot look like it.

        The result is False, too, if a parameter of `tested` has an impossible sign.

        The encoder's noise makes the fitted inertia too small, so that a part of the inertial
        effort is left over. A column of `tested` that resembles the acceleration, or the derivative
        of the acceleration, would be fitted to this part.
        """
        columns = self.columns([*others, tested])
        names = [self.names[k] for k in columns]
        if indistinct_terms(self.sides[:, :, [*columns, -1]], names, self.samples.velocity.size):
            return False
        try:
            if not self.possible(tested, others):
                return False
            if tested.differentiates:
                known = self.samples.fixed.get("inertia")
                inertia = float(self.fitted(columns)[0]) if known is None else known.value
                return self.effort(tested, others) > ABOVE_NOISE * abs(inertia) * self.noise
            fewer = self.columns(others)
            gain = self._left(fewer, -1) - self._left(columns, -1)
            return gain > ABOVE_NOISE * self._gain_of_noise(fewer, columns)
        except SingularRegressors:
            return False

    def possible(self, tested: Hypothesis, others: Sequence[Hypothesis]) -> bool:
        """Return whether the parameters of `tested` have a possible sign in a fit with `others`."""
        if not tested.positive:
            return True
        return bool(np.all(self.fitted_to(tested, others) > 0.0))

    def lags(self, hypotheses: Sequence[Hypothesis]) -> bool:
        """Return True if, in a fit with `hypotheses`, the effort acts later than logged.

        The parameter of the delay is then negative. The result is False if the rows do not
        determine this parameter.
        """
        chosen = {*self.columns(hypotheses), *(k for k, n in enumerate(self.names) if n == DELAY)}
        columns = sorted(chosen)
        try:
            value = self.fitted(columns)
        except SingularRegressors:
            return False
        return any(
            one < 0.0 for k, one in zip(columns, value, strict=True) if self.names[k] == DELAY
        )

    def _gain_of_noise(self, fewer: Sequence[int], more: Sequence[int]) -> float:
        """Return the decrease of the mean square residual if added columns explain noise only.

        `fewer` and `more` are the indices of the columns without and with the added columns. Let J
        be the inertia, n the rms noise of the acceleration, and s^2 the mean square of the
        acceleration that the other columns do not explain. The noise contributes J^2 n^2 (s^2 -
        n^2)/s^2 to the mean square residual [(N m)^2 | N^2]. Added columns reduce s^2 and thus this
        contribution. If the inertia is fixed, the result is 0.
        """
        if "inertia" in self.samples.fixed:
            return 0.0
        noise = self.noise**2
        before, after = (
            max(self._left([k for k in columns if k != 0], 0), noise) for columns in (fewer, more)
        )
        inertia = float(self.fitted(fewer)[0])
        return inertia**2 * noise**2 * (1.0 / after - 1.0 / before)

    def left_by_others(self, hypotheses: Sequence[Hypothesis]) -> float:
        """Return the mean square of the part of the acceleration that other columns do not explain.

        The other columns are all columns of a fit with `hypotheses` except the acceleration. The
        unit is (rad/s^2)^2 | (m/s^2)^2.
        """
        return self._left([k for k in self.columns(hypotheses) if k != 0], 0)

    def _left(self, columns: Sequence[int], target: int) -> float:
        triangle = merged(self.sides[:, :, [*columns, target]])
        return float(triangle[-1, -1] ** 2) / self.samples.velocity.size

    def table(self, hypotheses: Sequence[Hypothesis]) -> Matrix:
        """Return the regressors (n, p) of a fit with `hypotheses`."""
        named = dict(zip(SLIDING, self.samples.columns, strict=True)) | self.samples.loads
        return np.column_stack([named[self.names[k]] for k in self.columns(hypotheses)])

    def residual(self, hypotheses: Sequence[Hypothesis]) -> Vector:
        """Return the residual effort (n,) of the rows in a fit with `hypotheses`."""
        value = self.fitted(self.columns(hypotheses))
        return np.asarray(self.samples.effort - self.table(hypotheses) @ value)


def _triangle(parts: Tensor) -> Matrix:
    q = parts.shape[2]
    out = np.zeros((q, q))
    if parts.shape[0]:
        triangle = merged(parts)
        out[: triangle.shape[0]] = triangle
    return out
