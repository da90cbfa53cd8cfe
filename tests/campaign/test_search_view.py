"""Text of a search that found no design."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from frictool.campaign.views.search_view import refusal


def refused(value: float, limit: float) -> str:
    metric = SimpleNamespace(
        key="response_time_95_s", name="response_time_95", unit="s", relation="<=", limit=limit
    )
    best = SimpleNamespace(
        missing={metric.key: value / limit - 1.0},
        metrics=[metric],
        worst=lambda _: value,
        distance=value / limit - 1.0,
        largest_missing=value / limit - 1.0,
        worst_requirement=metric,
    )
    outcome = SimpleNamespace(best=best, refusals=())
    return refusal(cast(Any, SimpleNamespace(outcomes=[outcome], findings=None)))


def test_a_value_just_above_its_limit_is_shown_with_the_digits_that_differ() -> None:
    assert "is 0.019592 s for the best candidate, specified <= 0.019591 s" in refused(
        0.019592, 0.019591
    )
    assert "is 0.9113 s for the best candidate, specified <= 0.7781 s" in refused(0.91131, 0.77812)
