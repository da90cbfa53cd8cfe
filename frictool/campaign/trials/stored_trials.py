"""Results of trials in arrays, one row for each draw."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping

import numpy as np

from frictool.campaign.trials.trials import UNDECIDED, Marks, TrialResult
from frictool.typing import BoolVector, Vector

MOST_DRAWS = 10_000_000  # a damaged file may contain any index


class StoredTrials(MutableMapping[int, TrialResult]):
    """Mapping from the index of a draw to its TrialResult; all results have the same metrics."""

    def __init__(self) -> None:
        self._values: Vector = np.empty((0, 0))
        self._met: Marks = np.empty((0, 0), dtype=np.int8)
        self._present: BoolVector = np.empty(0, dtype=bool)
        self._failed = dict[int, str]()
        self._count = 0

    def __setitem__(self, draw: int, trial: TrialResult) -> None:
        if not 0 <= draw < MOST_DRAWS:
            raise IndexError(f"draw {draw}; allowed: 0 to {MOST_DRAWS - 1}")
        self._reserve(draw + 1, len(trial.metric_values))
        self._count += not self._present[draw]
        self._present[draw] = True
        self._failed.pop(draw, None)
        if trial.failed:
            self._failed[draw] = trial.failed
        else:
            self._values[draw], self._met[draw] = trial.metric_values, trial.met

    def __getitem__(self, draw: int) -> TrialResult:
        if draw not in self:
            raise KeyError(draw)
        if draw in self._failed:
            return TrialResult(draw, (), (), self._failed[draw])
        return TrialResult(
            draw, tuple(self._values[draw].tolist()), tuple(self._met[draw].tolist())
        )

    def __delitem__(self, draw: int) -> None:
        if draw not in self:
            raise KeyError(draw)
        self._present[draw] = False
        self._count -= 1
        self._failed.pop(draw, None)

    def __contains__(self, draw: object) -> bool:
        return isinstance(draw, int) and 0 <= draw < self._present.size and self._present[draw]

    def __iter__(self) -> Iterator[int]:
        return iter(np.flatnonzero(self._present).tolist())

    def __len__(self) -> int:
        return self._count

    def _reserve(self, draws: int, metrics: int) -> None:
        rows, columns = self._values.shape[0], self._values.shape[1] or metrics
        if draws <= rows and columns == self._values.shape[1]:
            return
        size = rows if draws <= rows else max(draws, 2 * rows)
        values = np.full((size, columns), np.nan)
        met = np.full((size, columns), UNDECIDED, dtype=np.int8)
        values[:rows, : self._values.shape[1]] = self._values
        met[:rows, : self._met.shape[1]] = self._met
        self._present = np.append(self._present, np.zeros(size - rows, dtype=bool))
        self._values, self._met = values, met
