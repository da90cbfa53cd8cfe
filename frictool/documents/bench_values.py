"""Warning about models that contain only values of the bench (`identify --keep-bench-values`)."""

from __future__ import annotations

# key of the reason, in a model and in the record `log` of a simulated log's metadata
KEY = "bench_values_only"


def bench_values_words(model: str, reason: str) -> str:
    """Return the warning that `model` (name or path) contains only the bench's values."""
    return f"{model} contains only the bench's values ({reason})"
