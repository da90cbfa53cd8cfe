"""Timing of two functions alternately, so that a slower machine affects both alike."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any


def pair(ours: Callable[[], Any], theirs: Callable[[], Any], repeats: int) -> tuple[float, float]:
    """Return the median wall times of both functions [s].

    Each function is called once to warm up, and then `repeats` times, in turn with the other.
    """
    ours()
    theirs()
    seconds: tuple[list[float], list[float]] = ([], [])
    for _ in range(repeats):
        for call, kept in zip((ours, theirs), seconds, strict=True):
            start = time.perf_counter()
            call()
            kept.append(time.perf_counter() - start)
    return statistics.median(seconds[0]), statistics.median(seconds[1])
