"""Warning about models whose values all come from bench.yaml (`identify --keep-bench-values`)."""

from __future__ import annotations

# key of the reason, in a model and in the record `log` of a simulated log's metadata
KEY = "bench_values_only"


def bench_values_words(model: str, reason: str) -> str:
    """Return the warning that all values of `model` (name or path) come from bench.yaml only."""
    return f"{model} contains only the bench's values ({reason})"
