"""Interval of the inertia that is reflected through lossy links."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReflectedInertia:
    """Bounds of the inertia reflected through lossy links, relative to the lossless value.

    least: lower bound, for a load that drives.
    most: upper bound, for a source that drives.
    inner_least: lower bound for the blocks that move while the backlash is open.
    """

    least: float = 1.0
    most: float = 1.0
    inner_least: float = 1.0
