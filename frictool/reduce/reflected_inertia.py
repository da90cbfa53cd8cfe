"""Inertia reflected through lossy links: an interval around J + r^2 m."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReflectedInertia:
    """Bounds of the reflected inertia through lossy links, relative to the lossless value.

    least: lower bound, coasting. most: upper bound, accelerating. inner_least: lower bound for the
    part that moves inside a backlash.
    """

    least: float = 1.0
    most: float = 1.0
    inner_least: float = 1.0
