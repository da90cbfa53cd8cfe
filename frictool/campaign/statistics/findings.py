"""Trials to what a campaign says: the answer, the pass rate, a distribution a metric, and where
failures and variance come from.

Trials ──pass_rate.py, distribution.py, sensitivity.py──▶ Findings ──▶ text.py, page.py,
json_view.py
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from frictool.campaign.draws.sampling import Method
from frictool.campaign.statistics.clopper_pearson import CONFIDENCE, draws_to_show
from frictool.campaign.statistics.distribution import Distribution, distribution
from frictool.campaign.statistics.pass_rate import PassRate, pass_rate
from frictool.campaign.statistics.sensitivity import Sensitivity, sensitivity
from frictool.campaign.trials.trials import Trials

Outcome = Literal["PASS", "FAIL", "UNDECIDED", "NOT SHOWN"]


class WorstCaseView(Protocol):
    """A worst case of one requirement, found by a search and kept as a scenario: what it is, and
    the command that replays it."""

    @property
    def requirement(self) -> str: ...
    @property
    def value(self) -> float: ...
    @property
    def limit(self) -> float: ...
    @property
    def unit(self) -> str: ...
    @property
    def relation(self) -> str: ...
    @property
    def met(self) -> bool | None: ...
    @property
    def values(self) -> Mapping[str, float]: ...
    @property
    def scenario(self) -> str: ...
    @property
    def command(self) -> str: ...
    @property
    def typed(self) -> str: ...


@dataclass(frozen=True)
class Findings:
    """Statistics of the trials. asked: the required pass rate, 0 to 1; None where every trial has
    to pass. remarks: warnings."""

    trials: Trials
    rate: PassRate
    distributions: tuple[Distribution, ...]
    sensitivity: Sensitivity
    worst: tuple[WorstCaseView, ...]
    asked: float | None
    remarks: tuple[str, ...] = ()

    @property
    def reached(self) -> bool:
        """Return whether all trials pass, or the requested rate is shown."""
        if self.asked is None:
            return 0 < self.rate.count == self.rate.passed
        return self.rate.count > 0 and self.rate.reaches(self.asked)

    @property
    def outcome(self) -> Outcome:
        """Return PASS, FAIL, UNDECIDED (nothing fails, and something is undecided), or NOT SHOWN:
        more draws might show it."""
        if self.reached:
            return "UNDECIDED" if self.undecided_requirements else "PASS"
        if (
            self.rate.count == 0
            or self.rate.undecided == self.rate.count
            or (self.asked is None and self.rate.failed == 0)
        ):
            return "UNDECIDED"
        high = self.rate.high
        return (
            "NOT SHOWN"
            if self.asked is not None and high is not None and high >= self.asked
            else "FAIL"
        )

    @property
    def passed(self) -> bool:
        """Return whether the campaign passes: every requirement is decided, and all trials pass or
        the requested rate is shown."""
        return self.outcome == "PASS"

    def acceptable(self, allow_undecided: bool) -> bool:
        """Return whether the campaign passes, or undecided requirements are allowed, nothing fails
        and something is met."""
        return self.passed or (
            allow_undecided
            and self.outcome == "UNDECIDED"
            and any(one.met for one in self.distributions)
        )

    @property
    def undecided_requirements(self) -> tuple[str, ...]:
        """Return the names of the requirements that no trial decides."""
        return tuple(
            one.metric.name for one in self.distributions if one.undecided == self.rate.count
        )

    @property
    def draws_needed(self) -> int | None:
        """Where the rate asked for is not shown: how many draws would show it if the share that
        passes stayed as it is."""
        if self.outcome != "NOT SHOWN" or self.asked is None:
            return None
        return draws_to_show(self.asked, self.rate.share, self.rate.confidence, self.rate.method)


def find(
    trials: Trials,
    method: Method,
    worst: Sequence[WorstCaseView] = (),
    at_least: float | None = None,
    confidence: float = CONFIDENCE,
    remarks: tuple[str, ...] = (),
) -> Findings:
    """Return the statistics of n trials whose draws `method` chose.

    at_least: the required pass rate, 0 to 1; None: every trial has to pass. remarks: warnings that
    every view of the findings repeats.

    Raises ValueError if at_least or confidence is out of range, or if there is no trial.
    """
    if trials.count == 0:
        raise ValueError("there is no trial")
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"the confidence is {confidence:g}; it lies between 0 and 1")
    if at_least is not None and not 0.0 < at_least <= 1.0:
        raise ValueError(
            f"a pass rate of {at_least:g} cannot be asked for; it is above 0 and at most 1"
        )
    rate = pass_rate(trials, method, confidence)
    distributions = tuple(
        distribution(trials, index, method, confidence) for index in range(len(trials.metrics))
    )
    return Findings(
        trials,
        rate,
        distributions,
        sensitivity(trials, drawn=not rate.whole),
        tuple(worst),
        at_least,
        remarks,
    )
