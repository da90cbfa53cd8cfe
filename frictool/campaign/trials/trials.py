"""Results of the trials of a campaign, one row per draw."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.campaign.draws.factor_space import FactorSpace
from frictool.typing import Vector

Marks = NDArray[np.int8]
MET, BROKEN, UNDECIDED = 1, 0, -1


@dataclass(frozen=True)
class MetricLimit:
    """Metric of a requirement, and its limit in SI.

    `name`: name of the requirement in `report`.
    `key`: key of the requirement in the specification.
    `relation`: "<=" if the limit is the largest allowed value, ">=" if it is the smallest.
    """

    name: str
    key: str
    unit: str
    limit: float
    relation: Literal["<=", ">="]


class TrialResult(NamedTuple):
    """Result of the trial of one draw.

    `metric_values`, `met` (m,): values and outcomes of the m metrics, as in a row of Trials.
    `failed`: reason why the draw could not be simulated; "" if the draw was simulated.
    """

    draw: int
    metric_values: tuple[float, ...]
    met: tuple[int, ...]
    failed: str = ""


@dataclass(frozen=True)
class Trials:
    """Results of n trials of d factors, judged by m metrics.

    `units` (n, d): draws in the unit cube.
    `values` (n, d): the same draws in SI (factor_space.py).
    `metric_values` (n, m): worst value of each metric in a trial; infinite for a failure without a
        number (an axis that never settles), NaN if the metric is undefined or the trial could not
        be simulated.
    `met` (n, m): outcome of each requirement, decided as in `report`: MET 1, BROKEN 0 or UNDECIDED
        -1.
    `passed` (n,): outcome of the whole trial (`trial_outcomes`).
    `failed`: reason for each trial that could not be simulated, by the trial's index. Such a trial
        is BROKEN, and its requirements are UNDECIDED.
    """

    space: FactorSpace
    metrics: tuple[MetricLimit, ...]
    units: Vector
    values: Vector
    metric_values: Vector
    met: Marks
    passed: Marks
    failed: Mapping[int, str] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Return the number of trials n."""
        return int(self.passed.size)


def collect_trials(
    space: FactorSpace, metrics: Sequence[MetricLimit], units: Vector, trials: Iterable[TrialResult]
) -> Trials:
    """Return the Trials of the draws `units` (n, d).

    `trials`: result of each draw, in any order. Raises ValueError if a result is missing.
    """
    n = units.shape[0]
    m = len(metrics)
    values = np.full((n, m), np.nan)
    met = np.full((n, m), UNDECIDED, dtype=np.int8)
    there = np.zeros(n, dtype=bool)
    failed = dict[int, str]()
    for trial in trials:
        there[trial.draw] = True
        if trial.failed:
            failed[trial.draw] = trial.failed
        else:
            values[trial.draw], met[trial.draw] = trial.metric_values, trial.met
    if not there.all():
        raise ValueError(f"trial {int(np.argmin(there))} is missing")
    passed = trial_outcomes(met, tuple(failed))
    return Trials(
        space,
        tuple(metrics),
        units,
        space.values(units),
        values,
        met,
        passed,
        dict(sorted(failed.items())),
    )


def trial_outcomes(met: Marks, failed: Sequence[int] = ()) -> Marks:
    """Return the outcomes (n,) of the trials from the outcomes `met` (n, m) of the requirements.

    A trial is BROKEN if it violates a requirement or could not be simulated, else UNDECIDED if a
    requirement is undecided, else MET. Requirements that no trial decides are ignored.
    """
    decidable = met[:, (met != UNDECIDED).any(axis=0)]
    passed = np.where((decidable == UNDECIDED).any(axis=1), UNDECIDED, MET).astype(np.int8)
    if not decidable.shape[1]:
        passed[:] = UNDECIDED
    passed[(decidable == BROKEN).any(axis=1)] = BROKEN
    passed[list(failed)] = BROKEN
    return passed
