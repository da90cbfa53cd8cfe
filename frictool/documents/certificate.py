"""Certificate of a controller: the bounds that `frictool verify` proves again.

A certificate holds the parameter intervals, the weights of the norm, and the value of each bound.
The proof needs nothing else and no search (verify/zero_exclusion.py). A certificate contains no
digest, because the proof depends on the coefficients alone.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import PositiveNumber

Row = tuple[float, ...]
Amplitude = Annotated[float, msgspec.Meta(ge=0)]


def _increasing(name: str, interval: Row) -> None:
    if len(interval) != 2 or interval[0] > interval[1]:
        raise ValueError(f"{name}: found {list(interval)}; allowed: [low, high] with low <= high")


class Box(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Intervals [low, high] of the parameters (SI).

    Both ends are equal for an exactly known parameter.
    """

    inertia: Row
    viscous: Row
    coulomb: Row
    constant: Row

    def __post_init__(self) -> None:
        for name in ("inertia", "viscous", "coulomb", "constant"):
            _increasing(name, getattr(self, name))
        for name in ("inertia", "constant"):
            if getattr(self, name)[0] <= 0.0:
                raise ValueError(f"{name}: found {list(getattr(self, name))}; allowed: > 0")


class Filter(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Weight gain (s/zero + 1)/(s/pole + 1), run as its Tustin equivalent.

    - `gain`: Gain at frequency 0.
    - `zero`, `pole`: Angular frequency [rad/s]. By default infinite.
    """

    gain: Amplitude
    zero: PositiveNumber | None = None
    pole: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if self.zero is not None and self.pole is None:
            raise ValueError("a weight with a zero needs a pole")


class CertifiedWeights(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Weights of the generalised plant whose norm is bounded.

    - `error`: Error weight W2.
    - `disturbance`: Disturbance weight W1.
    - `drive`: Weight W3 on the drive that reaches the actuator.
    - `command`: Weight on the commanded drive.
    - `noise`: Noise weight W4.
    - `eta`: Weight on the measured signal.
    """

    error: Filter
    disturbance: Amplitude
    drive: Amplitude
    command: Amplitude = 0.0
    noise: Filter = Filter(0.0)
    eta: Amplitude = 0.0


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Part of a proof of version 1. It is read, and not used.

    - `drive_rate`: [low, high] of constant/inertia (SI).
    - `viscous_rate`: [low, high] of viscous/inertia (SI).
    - `at_low`, `at_high`: Lyapunov matrix at this end of the drive rate.
    """

    drive_rate: Row
    viscous_rate: Row
    at_low: str
    at_high: str


class Bound(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One bound.

    - `of`: `norm`: from the weighted inputs to the weighted outputs. `sensitivity`: the largest
      sensitivity, the inverse of the modulus margin.
    - `below`: Value of the bound.
    - `bits`, `factor`, `cells`: Matrices of a proof of version 1. They are read, and not used.
    """

    of: Literal["norm", "sensitivity"]
    below: PositiveNumber
    bits: Annotated[int, msgspec.Meta(ge=1, le=64)] | None = None
    factor: tuple[Row, ...] = ()
    cells: tuple[Cell, ...] = ()

    @property
    def modulus_margin(self) -> float | None:
        """Return the modulus margin that a sensitivity bound implies; None for a norm."""
        return 1.0 / self.below if self.of == "sensitivity" else None


class Certificate(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Parameter intervals, weights and bounds of a certificate.

    - `version`: Version of this layout. Both versions state the same bounds, and `verify` proves
      both in the same way.
    - `box`: Intervals of the parameters.
    - `weights`: Weights of the norm.
    - `bounds`: Bounds that are proved.
    - `not_proved`: Reason for each bound without a proof.
    """

    version: Literal[1, 2]
    box: Box
    weights: CertifiedWeights
    bounds: tuple[Bound, ...]
    not_proved: dict[str, str] = {}
