"""Texts on the requirements that a candidate of a search does not meet."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from frictool.documents.metric_table import requirement_title

if TYPE_CHECKING:
    from frictool.synth.search.played_search import Candidate


def nearest_words(candidate: Candidate, plants: int, reserve: float) -> str:
    """Return a candidate's worst requirement, and the number of its simulated plants, as text.

    - plants: number of all plants
    - reserve: relative distance to the limits that the search requires
    """
    if candidate.largest_missing > 0.0:
        words = missed_words(candidate)
    elif reserve > 0.0:
        words = f"every limit met, but not with the reserve of {100.0 * reserve:g} %"
    else:
        words = "every limit met"
    return f"{words}, on {candidate.plants} of {plants} plants"


def missed_words(candidate: Candidate) -> str:
    """Return, as text, the requirement that a candidate violates most, with value and limit."""
    worst = candidate.worst_requirement
    return f"{requirement_title(worst.name)} {value_words(worst, candidate.worst(worst))}"


def value_words(metric: Any, value: float) -> str:
    """Return value and limit of a requirement as text, with enough digits to distinguish them."""
    reached, limit = distinguished(value, metric.limit, metric.unit)
    return f"{reached} (specified {metric.relation} {limit})"


def number_words(value: float, unit: str, digits: int = 4) -> str:
    """Return a number with its unit; `infinite` or `none` (NaN) have no unit."""
    if math.isfinite(value):
        return f"{value:.{digits}g} {unit}".rstrip()
    return "none" if math.isnan(value) else "infinite"


def distinguished(value: float, limit: float, unit: str) -> tuple[str, str]:
    """Return the texts of a value and of its limit, with enough digits to distinguish them."""
    for digits in range(4, 17):
        texts = number_words(value, unit, digits), number_words(limit, unit, digits)
        if texts[0] != texts[1]:
            break
    return texts
