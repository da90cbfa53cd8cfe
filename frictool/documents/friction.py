"""`friction.yaml`: the parameters that friction laws are compared with (thesis table 3.1)."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.laws import Dwell, Polynomial
from frictool.documents.quantity import (
    Axis,
    Inertia,
    PositionSpan,
    PositiveEffort,
    PositiveLength,
    PositiveVelocity,
    Stiffness,
    Viscous,
)

Share = Annotated[float, msgspec.Meta(gt=0, lt=1)]


class Hybrid(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What the hybrid versions (3.28)-(3.39) are simulated with.

    step_s: T_e. switch_velocity: Sigma, below which slip may turn into stick. decay_rad_s: p0 of
    version A (3.8). preisach_intervals: n of version C's triangle, whose distribution n/2 centred
    cycles give (3.7.1).
    """

    step_s: PositiveNumber
    switch_velocity: PositiveVelocity
    decay_rad_s: PositiveNumber
    preisach_intervals: Annotated[int, msgspec.Meta(ge=2, le=200)] = 20

    def __post_init__(self) -> None:
        if self.preisach_intervals % 2:
            raise ValueError(
                f"preisach_intervals: found {self.preisach_intervals}; allowed: an even number"
            )


class Opposite(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Where the negative direction differs."""

    coulomb: PositiveEffort | None = None
    breakaway: PositiveEffort | None = None
    viscous: Viscous | None = None


class SpeedRegime(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The viscous friction above a knee (figure 4.10), where friction is continuous."""

    above: PositiveVelocity
    viscous: Viscous


class Levels(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How friction varies `over` a travel (4.44): each polynomial over its mean is a factor of its
    direction's levels."""

    over: PositionSpan
    levels: Polynomial


class Film(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Frictional memory (3.4.2.3): the lag of the velocity that the Stribeck curve is taken at.

    No film forms below `boundary` (figure 2.16).
    """

    lag_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    boundary: PositiveVelocity | None = None


class Friction(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`friction.yaml`.

    presliding: z_max, how far contacts yield before they break. plastic_from: z_ba/z_max, from
    where an elasto-plastic contact slips (2.46). leuven_exponent: i of (2.49); small ones drift
    like LuGre. effort_limit: u_max of (3.31). dead_band: below it the laws of Karnopp (2.35) and
    (2.32) take a velocity for zero. backward, position, regimes, dwell, film: what the laws take on
    top (friction/extension.py). Without bristle_stiffness and bristle_damping they follow from
    (3.35).
    """

    format: Literal["friction/1"]
    name: Name
    axis: Axis
    inertia: Inertia
    coulomb: PositiveEffort
    breakaway: PositiveEffort
    viscous: Viscous
    stribeck_velocity: PositiveVelocity
    presliding: PositiveLength
    effort_limit: PositiveEffort
    hybrid: Hybrid
    stribeck_exponent: Annotated[float, msgspec.Meta(ge=0.5, le=4)] = 2.0
    plastic_from: Share = 0.9
    leuven_exponent: Annotated[float, msgspec.Meta(gt=0, le=100)] = 10.0
    bristle_stiffness: Stiffness | None = None
    bristle_damping: Viscous | None = None
    dead_band: PositiveVelocity | None = None
    backward: Opposite | None = None
    position: Levels | None = None
    regimes: tuple[SpeedRegime, ...] = ()
    dwell: Dwell | None = None
    film: Film | None = None

    def __post_init__(self) -> None:
        if self.breakaway.value < self.coulomb.value:
            raise ValueError(
                f"breakaway {self.breakaway.value:g} is below coulomb {self.coulomb.value:g}; allowed: breakaway >= coulomb"
            )
