"""`friction.yaml`: parameters for the comparison of friction laws (thesis table 3.1)."""

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
    """Parameters of the hybrid law versions (3.28)-(3.39).

    `step_s`: T_e. `switch_velocity`: Sigma; below it, slip may become stick. `decay_rad_s`: p0 of
    version A (3.8). `preisach_intervals`: n of version C's triangle; n/2 centred cycles give its
    distribution (3.7.1).
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
    """Friction levels that differ in the negative direction."""

    coulomb: PositiveEffort | None = None
    breakaway: PositiveEffort | None = None
    viscous: Viscous | None = None


class SpeedRegime(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Viscous friction above a knee speed (figure 4.10); the friction is continuous at the knee."""

    above: PositiveVelocity
    viscous: Viscous


class Levels(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Position-dependent friction `over` a travel (4.44).

    Each polynomial divided by its mean over the travel is a factor of its direction's levels.
    """

    over: PositionSpan
    levels: Polynomial


class Film(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Frictional memory (3.4.2.3): lag of the velocity at which the Stribeck curve is evaluated.

    No film forms below the speed `boundary` (figure 2.16).
    """

    lag_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    boundary: PositiveVelocity | None = None


class Friction(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`friction.yaml`.

    `presliding`: z_max, the largest deflection of the contacts before they break. `plastic_from`:
    z_ba/z_max, the deflection at which an elasto-plastic contact begins to slip (2.46).
    `leuven_exponent`: i of (2.49); the law drifts like LuGre if it is small. `effort_limit`: u_max
    of (3.31). `dead_band`: speed below which Karnopp's law (2.35) and the law (2.32) take a
    velocity for zero.

    `backward`, `position`, `regimes`, `dwell` and `film` extend the laws (friction/extension.py).
    By default `bristle_stiffness` and `bristle_damping` follow from (3.35).
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
                f"breakaway {self.breakaway.value:g} is below coulomb "
                f"{self.coulomb.value:g}; allowed: breakaway >= coulomb"
            )
