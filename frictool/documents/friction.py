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
from frictool.runtime.object_view import ObjectView

Share = Annotated[float, msgspec.Meta(gt=0, lt=1)]


class Hybrid(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Parameters of the hybrid friction laws (versions A to C).

    - `step_s`: Time step of the laws.
    - `switch_velocity`: Speed below which slip may become stick.
    - `decay_rad_s`: Decay rate [1/s] of the remaining velocity after the switch to stick.
    - `preisach_intervals`: Number of intervals along each side of version C's Preisach triangle; it
      must be even.
    """

    # (3.28)-(3.39): step_s is T_e, switch_velocity Sigma, decay_rad_s p0 of (3.8),
    # preisach_intervals n of 3.7.1
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
    """Friction levels of the negative direction.

    A level that is absent is the same in both directions.
    """

    coulomb: PositiveEffort | None = None
    breakaway: PositiveEffort | None = None
    viscous: Viscous | None = None


class SpeedRegime(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Viscous friction at speeds above `above`; the friction is continuous at this speed.

    - `above`: Speed at which the viscous friction changes.
    """

    # figure 4.10
    above: PositiveVelocity
    viscous: Viscous


class Levels(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Position-dependent friction over a travel.

    Each polynomial is divided by its mean over the travel. The result is the factor by which the
    friction level of its direction is multiplied.

    - `over`: Travel on which the polynomials apply; the friction is constant beyond the travel.
    - `levels`: Polynomials of the position.
    """

    # (4.44)
    over: PositionSpan
    levels: Polynomial


class Film(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Frictional memory: the friction follows the Stribeck curve with a lag in the velocity.

    - `lag_s`: Time constant of the lag; 0 for no lag.
    - `boundary`: Speed below which no lubricant film forms. The default is 0.
    """

    # 3.4.2.3, figure 2.16
    lag_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    boundary: PositiveVelocity | None = None


class Friction(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Parameters for the comparison of friction laws: `friction.yaml`.

    `backward`, `position`, `regimes`, `dwell` and `film` are optional extensions of the laws.

    - `stribeck_velocity`: Speed scale over which the friction decreases from the breakaway to the
      Coulomb friction.
    - `presliding`: Largest deflection z_max of the contacts before they break.
    - `effort_limit`: Largest effort u_max of the actuator.
    - `hybrid`: Parameters of the hybrid laws.
    - `stribeck_exponent`: Exponent of the Stribeck curve.
    - `plastic_from`: Deflection, relative to z_max, at which an elasto-plastic contact begins to
      slip.
    - `leuven_exponent`: Exponent of the Leuven law's hysteresis; with a small exponent the law
      drifts as LuGre does.
    - `bristle_stiffness`, `bristle_damping`: Stiffness and damping of the bristles. By default,
      they follow from the presliding, the breakaway and the inertia.
    - `dead_band`: Speed below which the laws `karnopp` and `svc_band` treat the velocity as zero.
    - `backward`: Friction levels of the negative direction that differ from the positive direction.
    - `position`: Position-dependent friction.
    - `regimes`: Viscous friction that changes above certain speeds.
    - `dwell`: Increase of the breakaway with the time at rest.
    - `film`: Lag with which the friction follows the speed.
    """

    # thesis table 3.1: plastic_from is z_ba/z_max of (2.46), leuven_exponent i of (2.49),
    # effort_limit u_max of (3.31),
    # the bristles' defaults (3.35), dead_band of (2.35) and (2.32); extensions:
    # friction/law_extension.py
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
