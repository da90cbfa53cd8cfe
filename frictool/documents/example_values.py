"""Example values that `frictool init` wrote and nobody replaced: each document lists their keys
under `examples`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any


def _unseen(path: str, keys: tuple[str, ...]) -> None:
    """Ignore example values: a library prints nothing."""


notify: Callable[[str, tuple[str, ...]], None] = (
    _unseen  # called with a document's path and its examples; the command line warns
)


def examples_of(document: Any) -> tuple[str, ...]:
    """Return the keys of example values in a document, those of the bench that it contains
    included."""
    bench = getattr(document, "bench", None)
    own: tuple[str, ...] = getattr(document, "examples", ())
    return (*own, *(f"bench.{key}" for key in getattr(bench, "examples", ())))


def examples_words(groups: Mapping[str, Iterable[str]]) -> str:
    """Say which example values are left in place, by the name of their document; empty if there is
    none."""
    found = [
        f"{name}: {', '.join(keys)}"
        for name, keys in ((name, tuple(keys)) for name, keys in groups.items())
        if keys
    ]
    return (
        f"example values of `frictool init` are left in place: {'; '.join(found)}" if found else ""
    )
