"""Findings of a campaign: outcome, pass rate, distribution of each metric, and sensitivities.

Trials ──pass_rate.py, distribution.py, sensitivity.py──▶ Findings ──▶ text_view.py, page.py,
json_view.py
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from frictool.campaign.draws.sampling import Method
from frictool.campaign.statistics.clopper_pearson import CONFIDENCE, draws_to_show
from frictool.campaign.statistics.distribution import Distribution, distribution
from frictool.campaign.statistics.pass_rate import PassRate, pass_rate
from frictool.campaign.statistics.sensitivity import Sensitivity, sensitivity
from frictool.campaign.trials.trials import Trials
from frictool.campaign.trials.worst_case import WorstCase

Outcome = Literal["PASS", "FAIL", "UNDECIDED", "NOT SHOWN"]


@dataclass(frozen=True)
class Findings:
    """Statistics of the trials, and worst cases.

    `required`: required pass rate, 0 to 1; None if every trial must pass.
    `remarks`: warnings for the user.
    `doubt`: reason why the axis may fail although the trials pass; "" if there is none.
    """

    trials: Trials
    rate: PassRate
    distributions: tuple[Distribution, ...]
    sensitivity: Sensitivity
    worst: tuple[WorstCase, ...]
    required: float | None
    remarks: tuple[str, ...] = ()
    doubt: str = ""

    @property
    def reached(self) -> bool:
        """Return True if the trials show the pass rate `required`.

        If `required` is None, return True if all trials pass.
        """
        if self.required is None:
            return 0 < self.rate.count == self.rate.passed
        return self.rate.count > 0 and self.rate.reaches(self.required)

    @property
    def outcome(self) -> Outcome:
        """Return the outcome: PASS, FAIL, UNDECIDED or NOT SHOWN.

        If the trials show the required pass rate (`reached`), the outcome is

        - UNDECIDED if there is a `doubt`, or a requirement that no trial decides,
        - PASS in all other cases.

        If the trials do not show this rate, the outcome is

        - UNDECIDED if all trials are undecided, or if no rate is required and no trial fails,
        - NOT SHOWN if more draws may show the required pass rate,
        - FAIL in all other cases.
        """
        if self.reached:
            return "UNDECIDED" if self.undecided_requirements or self.doubt else "PASS"
        if (
            self.rate.count == 0
            or self.rate.undecided == self.rate.count
            or (self.required is None and self.rate.failed == 0)
        ):
            return "UNDECIDED"
        high = self.rate.high
        return (
            "NOT SHOWN"
            if self.required is not None and high is not None and high >= self.required
            else "FAIL"
        )

    @property
    def passed(self) -> bool:
        """Return True if the outcome is PASS."""
        return self.outcome == "PASS"

    def acceptable(self, allow_undecided: bool) -> bool:
        """Return True if the campaign passes.

        If `allow_undecided` is True, the campaign also passes if the outcome is UNDECIDED and at
        least one requirement is met in a trial.
        """
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
        """Return the number of draws that would show the required rate.

        The share of passing draws is assumed to stay the same. Return None unless the outcome is
        NOT SHOWN.
        """
        if self.outcome != "NOT SHOWN" or self.required is None:
            return None
        return draws_to_show(self.required, self.rate.share, self.rate.confidence, self.rate.method)


def find(
    trials: Trials,
    method: Method,
    worst: Sequence[WorstCase] = (),
    at_least: float | None = None,
    confidence: float = CONFIDENCE,
    remarks: tuple[str, ...] = (),
    doubt: str = "",
) -> Findings:
    """Compute the statistics of the trials.

    `method`: method that chose the draws.
    `at_least`: required pass rate, 0 to 1; None if every trial must pass.
    `remarks`: warnings for the user.
    `doubt`: reason why the axis may fail although the trials pass; "" if there is none.

    Raises ValueError if `at_least` or `confidence` is out of range, or if there is no trial.
    """
    if trials.count == 0:
        raise ValueError("there is no trial")
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence: found {confidence:g}; allowed: above 0 and below 1")
    if at_least is not None and not 0.0 < at_least <= 1.0:
        raise ValueError(f"at_least: found {at_least:g}; allowed: above 0 and at most 1")
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
        doubt,
    )
