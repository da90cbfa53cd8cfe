"""Grid of positions within the travel of the source's block."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from frictool.documents.mechanism import GROUND, Cam, Curve, FrictionOf, Mechanism, Spring, Stop
from frictool.documents.quantity import Series
from frictool.errors import NoSolutionError
from frictool.reduce.assembly_cache import assemble_cached
from frictool.typing import Vector

POINTS = 241  # equidistant positions over the travel; the points of every curve are added


def travel_of(mechanism: Mechanism) -> tuple[float, float]:
    """Return the travel (low, high) of the source's block [rad | m].

    The first available entry of this list determines the travel:

    - `travel` of the document
    - the range between the end stops
    - the range of the curves
    - the range in which the source's largest effort strains the springs
    - 1 rad | 1 m to each side of the start

    Raises NoSolutionError if there are springs and the source's effort has no limit.
    """
    known = known_travel(mechanism)
    if known is not None:
        return known
    springs = [
        link
        for link in mechanism.links.values()
        if isinstance(link, Spring) and link.stiffness and GROUND in link.between
    ]
    start = float(assemble_cached(mechanism).start[0])
    if not springs:
        return start - 1.0, start + 1.0  # in this case, the efforts do not depend on the position
    stiffness = sum(one.stiffness.value for one in springs if one.stiffness)
    sources = assemble_cached(mechanism).packed.sources
    reach = float(np.max(sources.constant * sources.limit)) / stiffness
    if not np.isfinite(reach):
        raise NoSolutionError(
            f"{mechanism.name}: a mechanism with springs needs a known travel; add `travel`, end "
            "stops, or `limit` of the source"
        )
    return start - reach, start + reach


def known_travel(mechanism: Mechanism) -> tuple[float, float] | None:
    """Return the travel from the document, the end stops or the curves; None if it is unknown."""
    if mechanism.travel is not None:
        return mechanism.travel.low, mechanism.travel.high
    stops = [link for link in mechanism.links.values() if isinstance(link, Stop)]
    lows, highs = (
        [end.value for one in stops if (end := getattr(one, side)) is not None]
        for side in ("low", "high")
    )
    if lows and highs:
        return max(lows), min(highs)
    ends = [(curve.position.values[0], curve.position.values[-1]) for curve in _curves(mechanism)]
    if ends:
        return max(low for low, _ in ends), min(high for _, high in ends)
    return None


def positions(mechanism: Mechanism) -> Vector:
    """Return a grid (n,): equidistant positions within the travel, and the points of curves."""
    low, high = travel_of(mechanism)
    points = [x for curve in _curves(mechanism) for x in curve.position.values if low < x < high]
    return np.unique(np.concatenate([np.linspace(low, high, POINTS), points]))


def _curves(mechanism: Mechanism) -> Iterable[Curve]:
    for link in mechanism.links.values():
        match link:
            case Spring() if link.force is not None:
                yield link.force
            case Cam():
                yield link.force
                yield link.angle
            case FrictionOf() if link.level is not None:
                yield Curve(link.level.position, Series(link.level.factor, ""))
