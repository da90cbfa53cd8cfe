"""Warnings about models that hold values of the bench only (`identify --keep-bench-values`)."""

from __future__ import annotations

from collections.abc import Callable

# key of the reason, in a model and in the record `log` of a simulated log's metadata
KEY = "bench_values_only"


def _unseen(path: str, reason: str) -> None:
    """Do nothing; the default of `notify`, because code used as a library must not print."""


notify: Callable[[str, str], None] = (
    _unseen  # called with a model's path and the reason; the command line warns
)


def bench_values_words(model: str, reason: str) -> str:
    """Return the warning that `model` (name or path) holds the bench's values only."""
    return f"{model} holds the bench's values only, since nothing was identified ({reason})"
