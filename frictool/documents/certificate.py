"""Certificate of a controller: the data that `frictool verify` needs to prove a bound again.

The proof needs no search. A certificate holds the parameter intervals, the weights of the norm, and
a list of cells for each bound. A cell is a rectangle in the drive rate K/J and the viscous rate
sigma_v/J with two Lyapunov matrices. A certificate contains no digest, because the proof depends on
the coefficients alone.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import PositiveNumber

Row = tuple[float, ...]
Amplitude = Annotated[float, msgspec.Meta(ge=0)]
LARGEST_ORDER = 64
MOST_CELLS = 2048


def _increasing(name: str, interval: Row, strictly: bool = False) -> None:
    if len(interval) != 2 or interval[0] > interval[1] or (strictly and interval[0] == interval[1]):
        raise ValueError(
            f"{name}: found {list(interval)}; allowed: [low, high] with low "
            f"{'<' if strictly else '<='} high"
        )


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
    """Rectangle of plants with the Lyapunov matrices at both ends of the drive rate.

    Each matrix is given by its upper triangle, row by row: integers separated by blanks, in units
    of 2^-bits of the bound. The matrix is interpolated linearly in the drive rate.

    - `drive_rate`: [low, high] of constant/inertia (SI).
    - `viscous_rate`: [low, high] of viscous/inertia (SI).
    - `at_low`, `at_high`: Lyapunov matrix at this end of the drive rate.
    """

    drive_rate: Row
    viscous_rate: Row
    at_low: str
    at_high: str

    def __post_init__(self) -> None:
        _increasing("drive_rate", self.drive_rate, strictly=True)
        _increasing("viscous_rate", self.viscous_rate, strictly=True)


class Bound(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One bound and its proof.

    - `of`: `norm`: from the weighted inputs to the weighted outputs. `sensitivity`: the largest
      sensitivity, the inverse of the modulus margin.
    - `below`: Value of the bound.
    - `bits`: Number of fractional bits of the cells' integers.
    - `factor`: Upper triangle of a matrix W, row by row. A Lyapunov matrix is W' M W, where M is a
      cell's integer matrix divided by 2^bits.
    - `cells`: Cells that cover all plants.
    """

    of: Literal["norm", "sensitivity"]
    below: PositiveNumber
    bits: Annotated[int, msgspec.Meta(ge=1, le=64)]
    factor: tuple[Row, ...]
    cells: tuple[Cell, ...]

    @property
    def modulus_margin(self) -> float | None:
        """Modulus margin that a bound of the sensitivity states; None for a norm."""
        return 1.0 / self.below if self.of == "sensitivity" else None

    def __post_init__(self) -> None:
        n = len(self.factor)
        if not 1 <= n <= LARGEST_ORDER or any(
            len(row) != n - index for index, row in enumerate(self.factor)
        ):
            raise ValueError(
                f"factor: allowed: 1 to {LARGEST_ORDER} rows of an upper triangle, the "
                "first the longest"
            )
        if len(self.cells) > MOST_CELLS:
            raise ValueError(f"cells: found {len(self.cells)}; allowed: up to {MOST_CELLS}")


class Certificate(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Parameter intervals, weights and bounds of a certificate.

    - `version`: Version of this layout.
    - `box`: Intervals of the parameters.
    - `weights`: Weights of the norm.
    - `bounds`: Bounds and their proofs.
    - `not_proved`: Reason for each bound without a proof.
    """

    version: Literal[1]
    box: Box
    weights: CertifiedWeights
    bounds: tuple[Bound, ...]
    not_proved: dict[str, str] = {}
