"""Do the intervals of `identify` hold on machines that violate the model? 100 records of each of
the 18 families of `studies/violations`, drawn by the commit's hash.

In each family at least 88 of 100 intervals of each parameter hold the truth, and 93 to 97 % of all.
The median half width is at most 3 times the rms error. Warnings come with at most 3 % of the
records of the true model and 30 % of the mild ones, false loads, knees and resonances with at most
2 %. The rows are written to build/violations.txt.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from studies.violations.__main__ import HEADER, row
from studies.violations.families import FAMILIES
from studies.violations.judgement import PARAMETERS, judge, pooled, summary
from tests.support.commit_hash import commit_hash

RECORDS = 100
FEWEST = 0.88
LOWEST, HIGHEST = 0.93, 0.97
WIDEST = 3.0
FALSE, TRUE_WARNED, MILD_WARNED = 0.02, 0.03, 0.3


def violations() -> dict[str, Any]:
    """All families; the figures name the family and parameter that hold least."""
    seed = commit_hash()
    verdicts = {
        family: [judge(seed, family, number) for number in range(RECORDS)] for family in FAMILIES
    }
    summaries = [summary(family, one) for family, one in verdicts.items()]
    page = Path("build", "violations.txt")
    page.parent.mkdir(exist_ok=True)
    page.write_text("\n".join([f"seed {seed}", HEADER, *map(row, summaries)]) + "\n")
    rates = {
        f"{one.family} {name}": hits / judged
        for one in summaries
        for name, (hits, judged) in one.held.items()
        if judged
    }
    least = min(rates, key=lambda key: rates[key])
    widest = max(one.ratio[name] for one in summaries for name in PARAMETERS)
    every = [one for family in verdicts.values() for one in family]
    mild = [one for one in every if one.mild and one.family != "true_model"]
    false = sum(bool(one.false_claims) for one in every) / len(every)
    warned = next(one.warned for one in summaries if one.family == "true_model")
    mild_warned = sum(bool(one.warnings) for one in mild) / len(mild)
    share = pooled(summaries)
    return {
        "passed": rates[least] >= FEWEST
        and LOWEST <= share <= HIGHEST
        and widest <= WIDEST
        and false <= FALSE
        and warned <= TRUE_WARNED
        and mild_warned <= MILD_WARNED,
        "seed": seed,
        "held": share,
        "least": least,
        "least_held": rates[least],
        "widest_over_rms_error": widest,
        "false_claims": false,
        "true_model_warned": warned,
        "mild_warned": mild_warned,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"violations": violations}
