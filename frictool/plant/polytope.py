"""Polytope of plants (thesis 5.51, 5.68), spanned by the intervals of the scheduled parameters.

    p0 = (J, viscous, coulomb, K)   centre: the middle of each interval, also for a parameter that
                                    is not scheduled
    vertices                        2^l corners of the l intervals, in the order of
                                    itertools.product, J slowest; equal corners are listed once

A speed regime is a speed range with its own viscous coefficient. If the speed regimes are
scheduled, thesis annex C (30)-(32), viscous and coulomb are slope and intercept of each regime's
tangent (plant/regime_tangents.py). Two regimes double the number of vertices; if all other
parameters are scheduled, too, there are 2^5 = 32. With regimes, slope and intercept of the centre
are midway between their smallest and largest value.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from frictool.plant.linear_axis import AxisRates
from frictool.plant.regime_tangents import RegimeLevels, tangents

Parameter = Literal["inertia", "viscous", "coulomb", "constant", "regime"]
PARAMETERS: tuple[Parameter, ...] = ("inertia", "viscous", "coulomb", "constant")


@dataclass(frozen=True)
class PlantPoint:
    """Plant with constant parameters, SI.

    inertia [kg m^2 or kg], viscous [N m s/rad or N s/m], coulomb [N m or N], constant
    [N m or N per A or V].
    """

    name: str
    inertia: float
    viscous: float
    coulomb: float
    constant: float

    @property
    def rates(self) -> AxisRates:
        """Return the rates of this plant (thesis 5.48), without linearisation."""
        return AxisRates(
            self.constant / self.inertia, self.viscous / self.inertia, self.coulomb / self.inertia
        )


@dataclass(frozen=True)
class Polytope:
    """Centre and vertices of the polytope, and the parameters that differ between vertices."""

    centre: PlantPoint
    vertices: tuple[PlantPoint, ...]
    scheduled: tuple[Parameter, ...] = PARAMETERS


def spanned(
    box: Mapping[str, tuple[float, float]],
    scheduled: Sequence[Parameter] = PARAMETERS,
    levels: RegimeLevels | None = None,
) -> Polytope:
    """Return the polytope that the 1 to 5 parameters `scheduled` span within `box`.

    - box: interval of each of PARAMETERS [SI]
    - levels: intervals of the speed regimes, with separate vertices for each regime, if "regime" is
      scheduled; else None

    Raises ValueError if `scheduled` is empty or names a parameter twice.
    """
    if not scheduled or len(set(scheduled)) != len(scheduled):
        raise ValueError(
            f"scheduled: found {list(scheduled)}; allowed: 1 to 5 different names of "
            f"{', '.join((*PARAMETERS, 'regime'))}"
        )
    names = set(scheduled)

    def ends(name: Parameter) -> tuple[float, ...]:
        return box[name] if name in names else (0.5 * sum(box[name]),)

    if levels is not None:
        frictions = tangents(levels, viscous="viscous" in names, coulomb="coulomb" in names)
        moving = itertools.product(ends("inertia"), frictions, ends("constant"))
        return _named(
            [(j, tangent.viscous, tangent.coulomb, k) for j, tangent, k in moving], tuple(scheduled)
        )
    corners = itertools.product(ends("inertia"), ends("viscous"), ends("coulomb"), ends("constant"))
    return _named(list(corners), tuple(scheduled))


def corner_points(box: Mapping[str, tuple[float, float]]) -> tuple[PlantPoint, ...]:
    """Return all different corners of the four intervals in `box`, with the names v1, v2, ..."""
    corners = itertools.product(box["inertia"], box["viscous"], box["coulomb"], box["constant"])
    return _named(list(corners), PARAMETERS).vertices


def _named(
    corners: list[tuple[float, float, float, float]], scheduled: tuple[Parameter, ...]
) -> Polytope:
    corners = list(dict.fromkeys(corners))
    centre = PlantPoint(
        "centre", *(0.5 * (min(values) + max(values)) for values in zip(*corners, strict=True))
    )
    width = len(str(len(corners)))
    vertices = tuple(
        PlantPoint(f"v{index:0{width}d}", *corner) for index, corner in enumerate(corners, start=1)
    )
    return Polytope(centre, vertices, scheduled)
