"""How many trials pass, and what that says of all plants: the rate with its interval, or a count
where vertices were played.

A trial that the specification cannot decide is neither: it fails in the lower bound and passes in
the upper one. One that could not be simulated has not passed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.campaign.draws.sampling import Method
from frictool.campaign.statistics.clopper_pearson import CONFIDENCE, interval, lower
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, Trials


@dataclass(frozen=True)
class PassRate:
    """n trials: passed, failed (with those that could not be simulated, not_run) and undecided.

    low, high: the pass rate with `confidence`, two-sided; at_least: its lower bound, one-sided.
    None of vertices that were all played: they are no draws. Of a part of the vertices these are of
    the share of all 2^d, of which a random part was played.
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
        """Of all trials those that pass, 0..1; nan of no trial."""
        return self.passed / self.count if self.count else float("nan")

    @property
    def noun(self) -> str:
        """What a trial is called."""
        return (
            ("vertex" if self.count == 1 else "vertices")
            if self.method == "vertices"
            else ("draw" if self.count == 1 else "draws")
        )

    def reaches(self, asked: float) -> bool:
        """Whether the pass rate is at least `asked`, with the confidence; of all vertices, whether
        their share is."""
        return (self.share if self.at_least is None else self.at_least) >= asked


def pass_rate(trials: Trials, method: Method, confidence: float = CONFIDENCE) -> PassRate:
    """Of the trials; a part of the vertices is one of fewer than 2^d."""
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
