"""Warnings about example values of `frictool init` that are still in a document.

Each document lists the keys of its example values under `examples`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from frictool.documents.name_list import listed

LONGEST_KEYS = 105  # characters of the keys in a message


def examples_of(document: Any) -> tuple[str, ...]:
    """Return the keys under `examples` of a document and of its bench."""
    bench = getattr(document, "bench", None)
    examples: tuple[str, ...] = getattr(document, "examples", ())
    return (*examples, *(f"bench.{key}" for key in getattr(bench, "examples", ())))


def examples_words(groups: Mapping[str, Iterable[str]]) -> str:
    """Return a message on example values that are not replaced yet; empty if all are replaced.

    groups: keys of the example values of each document. A long message names only the first keys.
    """
    left = {name: keys for name, values in groups.items() if (keys := tuple(values))}
    described = [
        f"{name}: {listed(keys, LONGEST_KEYS // len(left))}" for name, keys in left.items()
    ]
    return (
        f"example values of `frictool init` are not replaced yet: {'; '.join(described)}"
        if described
        else ""
    )
