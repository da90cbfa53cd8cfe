"""Inertia felt through links that lose: an interval about J + r^2 m, not a value."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReflectedInertia:
    """What the source feels of inertia through links that lose, of what it is without: least
    (coasting) and most (accelerating).

    inner_least: the least of what moves inside a play alone.
    """

    least: float = 1.0
    most: float = 1.0
    inner_least: float = 1.0
