"""The polytope of plants (5.51), (5.68): the corners of the intervals of the scheduled parameters.

    p0 = (J, viscous, coulomb, K)   centre: the middle of each interval, also for a parameter that
                                    is not scheduled
    vertices                        2^l corners in the order of itertools.product, J slowest;
                                    equal corners (an interval of width 0) are listed once

If the speed regimes are scheduled, annex (30)-(32), viscous and coulomb are those of the tangent of
each regime (plant/regime_tangents.py): two vertices for one knee, times those of the other
parameters, 2^5 = 32 with all of them. The centre is then the middle of the tangents.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Backward, FrictionOverPosition
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.friction.position_polynomial import normalise
from frictool.plant.linear_axis import AxisRates
from frictool.plant.regime_tangents import regime_levels, tangents

Parameter = Literal["inertia", "viscous", "coulomb", "constant", "regime"]
PARAMETERS: tuple[Parameter, ...] = ("inertia", "viscous", "coulomb", "constant")
PLACES = 1001  # number of positions at which a polynomial is evaluated over the travel


@dataclass(frozen=True)
class PlantPoint:
    """One constant plant, SI.

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
        """The exact rates of this plant (5.48)."""
        return AxisRates(
            self.constant / self.inertia, self.viscous / self.inertia, self.coulomb / self.inertia
        )


@dataclass(frozen=True)
class Polytope:
    """Centre and vertices, and the parameters that change from vertex to vertex."""

    centre: PlantPoint
    vertices: tuple[PlantPoint, ...]
    scheduled: tuple[Parameter, ...] = PARAMETERS


def intervals(model: Model) -> dict[str, tuple[float, float]]:
    """Return the intervals for which `synth` designs and `verify` compares.

    They are `ranges`, extended by the local Coulomb friction over the travel.
    """
    found = ranges(model)
    if model.laws is not None and model.laws.position is not None:
        local = _over_position(model.laws.position, model.parameters.coulomb, model.laws.backward)
        found["coulomb"] = (min(found["coulomb"][0], local[0]), max(found["coulomb"][1], local[1]))
    return found


def ranges(model: Model) -> dict[str, tuple[float, float]]:
    """Return the hull of the model's intervals and of the bench's range over the product's life.

    The hull includes every direction and regime. `simulate` and `campaign` draw from it; friction
    that varies with position has its mean there. A bench value without a range has the width 0. The
    hull is used, not the intersection: the log gives the parameter of this bench today, the bench
    its future range.
    """
    known, today = model.bench.mechanics, model.parameters
    pairs: dict[str, tuple[Quantity, ...]] = {
        "inertia": (today.inertia, known.inertia),
        "viscous": (today.viscous, known.viscous),
        "coulomb": (today.coulomb, known.coulomb),
        "constant": (model.bench.actuator.constant,),
    }
    if model.laws is not None:
        backward, regimes = model.laws.backward, model.laws.regimes
        slopes = [found for regime in regimes for found in (regime.viscous, regime.backward)]
        slopes += [backward.viscous] if backward else []
        pairs["viscous"] += tuple(found for found in slopes if found is not None)
        pairs["coulomb"] += (backward.coulomb,) if backward and backward.coulomb else ()
    return {name: hull(*quantities) for name, quantities in pairs.items()}


def hull(*quantities: Quantity) -> tuple[float, float]:
    """Return the smallest interval that contains the intervals of all quantities."""
    return min(one.interval[0] for one in quantities), max(one.interval[1] for one in quantities)


def _over_position(
    law: FrictionOverPosition, forward: Quantity, opposite: Backward | None
) -> tuple[float, float]:
    """Return the least and the largest Coulomb friction over the travel and both directions."""
    backward = (opposite.coulomb if opposite else None) or forward
    lows, highs = [], []
    for level, powers in (
        (forward, law.coulomb.forward),
        (backward, law.coulomb.backward or law.coulomb.forward),
    ):
        normal, _ = normalise(np.array(powers), law.over.low, law.over.high)
        factors = np.polynomial.polynomial.polyval(
            np.linspace(law.over.low, law.over.high, PLACES), normal
        )
        lows.append(max(0.0, float(factors.min())) * level.interval[0])
        highs.append(float(factors.max()) * level.interval[1])
    return min(lows), max(highs)


def polytope(model: Model, scheduled: Sequence[Parameter] = PARAMETERS) -> Polytope:
    """Return the polytope spanned by `scheduled`: 1 to 5 parameters, 2 to 32 vertices.

    A model with several knees has more vertices. Without regimes the polytope is `intervals(model)`
    in the scheduled parameters. The documents do not allow an inertia or constant that may be zero.
    Raises FrictoolError if regimes are scheduled and the model has none, ValueError for an empty
    list or a repeated parameter.
    """
    if not scheduled or len(set(scheduled)) != len(scheduled):
        raise ValueError(
            f"scheduled: found {list(scheduled)}; allowed: 1 to 5 different ones of "
            f"{', '.join((*PARAMETERS, 'regime'))}"
        )
    box, names = intervals(model), set(scheduled)

    def ends(name: Parameter) -> tuple[float, ...]:
        return box[name] if name in names else (0.5 * sum(box[name]),)

    if "regime" in names:
        levels = regime_levels(model, box["coulomb"])
        frictions = tangents(levels, viscous="viscous" in names, coulomb="coulomb" in names)
        moving = itertools.product(ends("inertia"), frictions, ends("constant"))
        return _named(
            [(j, tangent.viscous, tangent.coulomb, k) for j, tangent, k in moving], tuple(scheduled)
        )
    corners = itertools.product(ends("inertia"), ends("viscous"), ends("coulomb"), ends("constant"))
    return _named(list(corners), tuple(scheduled))


def bench_intervals(bench: Bench) -> dict[str, tuple[float, float]]:
    """Return the interval of each parameter over the product's life, from the bench alone.

    The intervals of `intervals` contain these.
    """
    known = {name: getattr(bench.mechanics, name) for name in ("inertia", "viscous", "coulomb")}
    return {
        name: quantity.interval
        for name, quantity in (known | {"constant": bench.actuator.constant}).items()
    }


def corner_points(box: Mapping[str, tuple[float, float]]) -> tuple[PlantPoint, ...]:
    """Return the corners of the four intervals, named like those of `polytope`."""
    corners = itertools.product(box["inertia"], box["viscous"], box["coulomb"], box["constant"])
    return _named(list(corners), PARAMETERS).vertices


def _named(
    corners: list[tuple[float, float, float, float]], scheduled: tuple[Parameter, ...]
) -> Polytope:
    """Return the polytope of the corners without repetition, centred in their enclosing box."""
    corners = list(dict.fromkeys(corners))
    centre = PlantPoint(
        "centre", *(0.5 * (min(values) + max(values)) for values in zip(*corners, strict=True))
    )
    width = len(str(len(corners)))
    vertices = tuple(
        PlantPoint(f"v{index:0{width}d}", *corner) for index, corner in enumerate(corners, start=1)
    )
    return Polytope(centre, vertices, scheduled)
