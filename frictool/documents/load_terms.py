"""`load` of `bench.yaml`: the load terms besides friction that `identify` estimates."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.quantity import NonNegativeEffort, PositiveLength

OVER_POSITION = ("spring", "gravity", "ripple")
MOST_HARMONICS = 6  # largest number of harmonics of a ripple
Term = Literal[
    "offset",
    "spring",
    "gravity",
    "ripple",
    "viscous_by_direction",
    "coulomb_by_direction",
    "drift",
    "warming",
    "temperature",
    "eccentricity",
    "stribeck",
    "wide_stribeck",
    "friction_over_position",
    "load_over_position",
    "inertial_friction",
    "delay",
    "resonance",
]
CyclesPerDistance = Annotated[float, msgspec.Meta(gt=0, le=1e6)]


class RipplePeriod(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Period of an effort ripple, such as seven periods per turn of the motor.

    - `cycles`: Number of periods in the distance `per`.
    - `per`: Distance that contains `cycles` periods.
    - `harmonics`: Up to 5 additional ripple components, each stated as its number of periods in
      `per`.
    """

    cycles: CyclesPerDistance
    per: PositiveLength
    harmonics: tuple[CyclesPerDistance, ...] = ()

    def __post_init__(self) -> None:
        if len(self.harmonics) >= MOST_HARMONICS or len(set(self.numbers)) < len(self.numbers):
            raise ValueError(
                f"harmonics: found {list(self.harmonics)} with cycles {self.cycles:g}; allowed: "
                f"at most {MOST_HARMONICS - 1}, all different"
            )

    @property
    def numbers(self) -> tuple[float, ...]:
        """Return the numbers of periods in the distance `per`, one for each harmonic."""
        return (self.cycles, *self.harmonics)


class LoadTerms(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Load terms that `identify` estimates. An offset that is not listed is assumed to be zero.

    - `terms`: Terms to estimate. `drift` and the terms after it in the list of allowed values are
      estimated only to keep the other parameters unbiased. Their effort is subtracted from the
      measured effort. Only `temperature` of these terms becomes part of the model.
    - `ripple`: Period of the ripple; required with the term `ripple`.
    - `most`: Largest sum of spring, gravity and ripple efforts that occurs on the travel. Planned
      tests reserve this effort of the drive's limit for the load; if the key is absent, they
      reserve nothing. `identify` uses the value for a load that the logs cannot separate from other
      parameters.
    """

    terms: tuple[Term, ...]
    ripple: RipplePeriod | None = None
    most: NonNegativeEffort | None = None

    def __post_init__(self) -> None:
        if len(set(self.terms)) < len(self.terms):
            raise ValueError("terms: found a term twice; allowed: each term once")
        if "offset" in self.terms and "coulomb_by_direction" in self.terms:
            raise ValueError(
                "terms: found offset and coulomb_by_direction, which cannot be distinguished while "
                "the axis slips; write one of them"
            )
        if self.most is not None and not set(OVER_POSITION) & set(self.terms):
            raise ValueError(
                f"most: this key limits {', '.join(OVER_POSITION)}, but no such term is listed; "
                "remove the key, or add such a term"
            )
        if ("ripple" in self.terms) != (self.ripple is not None):
            raise ValueError(
                "ripple: write the term `ripple` together with this key, such as {cycles: 7, "
                "per: {value: 1, unit: turn}}; or leave out both"
            )
