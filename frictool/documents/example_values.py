"""Warnings about example values of `frictool init` that are still in a document.

Each document lists the keys of its example values under `examples`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any


def examples_of(document: Any) -> tuple[str, ...]:
    """Return the keys of a document's example values, including those of its bench."""
    bench = getattr(document, "bench", None)
    examples: tuple[str, ...] = getattr(document, "examples", ())
    return (*examples, *(f"bench.{key}" for key in getattr(bench, "examples", ())))


def examples_words(groups: Mapping[str, Iterable[str]]) -> str:
    """Return a message on the example values that are not replaced yet; empty if there are none.

    groups: document -> keys of its example values.
    """
    described = [
        f"{name}: {', '.join(keys)}"
        for name, keys in ((name, tuple(keys)) for name, keys in groups.items())
        if keys
    ]
    return (
        f"example values of `frictool init` are left in place: {'; '.join(described)}"
        if described
        else ""
    )
