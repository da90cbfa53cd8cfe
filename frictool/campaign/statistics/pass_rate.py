"""Pass rate of the trials with its confidence interval.

If all vertices were simulated, the pass rate is exact and has no interval. An undecided trial
counts as failed for the lower bound and as passed for the upper bound. A trial that could not be
simulated counts as failed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.campaign.draws.sampling import Method
from frictool.campaign.statistics.clopper_pearson import CONFIDENCE, interval, lower
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, Trials


@dataclass(frozen=True)
class PassRate:
    """Pass rate, and the numbers of trials with each outcome.

    `failed`: number of failed trials, including the `not_run` trials that could not be simulated.
    `whole`: True if all vertices were simulated.

    `low`, `high`: two-sided interval of the pass rate with `confidence`.
    `at_least`: one-sided lower bound of the pass rate with `confidence`.

    `low`, `high` and `at_least` are None if all vertices were simulated, because the vertices are
    not random draws. For a random subset of the vertices, they are bounds of the pass rate of all
    vertices.
    """

    count: int
    passed: int
    failed: int
    undecided: int
    not_run: int
    method: Method
    whole: bool
    confidence: float
    low: float | None
    high: float | None
    at_least: float | None

    @property
    def share(self) -> float:
        """Return the share of passed trials, 0 to 1; NaN without trials."""
        return self.passed / self.count if self.count else float("nan")

    @property
    def noun(self) -> str:
        """Return the noun for `count` trials: draws or vertices, in the singular or plural."""
        return (
            ("vertex" if self.count == 1 else "vertices")
            if self.method == "vertices"
            else ("draw" if self.count == 1 else "draws")
        )

    def reaches(self, required: float) -> bool:
        """Return True if the pass rate is at least `required` with `confidence`.

        If all vertices were simulated, `required` is compared with the share of passing vertices.
        """
        return (self.share if self.at_least is None else self.at_least) >= required


def pass_rate(trials: Trials, method: Method, confidence: float = CONFIDENCE) -> PassRate:
    """Return the pass rate of the trials.

    For the method `vertices` with d factors, the rate has an interval only if fewer than 2^d
    vertices were simulated.
    """
    n = trials.count
    passed, failed, undecided = (
        int(np.count_nonzero(trials.passed == mark)) for mark in (MET, BROKEN, UNDECIDED)
    )
    whole = method == "vertices" and n >= 2**trials.space.size
    low = high = at_least = None
    if n and not whole:
        low = interval(passed, n, confidence, method)[0]
        high = interval(passed + undecided, n, confidence, method)[1]
        at_least = lower(passed, n, confidence, method)
    return PassRate(
        n,
        passed,
        failed,
        undecided,
        len(trials.failed),
        method,
        whole,
        confidence,
        low,
        high,
        at_least,
    )
