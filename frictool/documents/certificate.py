"""The certificate of a controller: what `frictool verify` needs to prove a bound again, without
searching for anything.

The intervals that it is about, the weights that the norm is of, and for each bound a list of cells:
rectangles in the drive rate K/J and the viscous rate sigma_v/J, each with two Lyapunov matrices. No
digest: what is proved depends on the coefficients alone.
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
            f"{name}: found {list(interval)}; allowed: [low, high] with low {'<' if strictly else '<='} high"
        )


class Box(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The intervals [low, high] of the parameters in SI; a parameter that is known exactly has two
    equal ends."""

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
    """gain (s/zero + 1)/(s/pole + 1), rad/s; what is absent is infinite. It runs as its Tustin
    equivalent."""

    gain: Amplitude
    zero: PositiveNumber | None = None
    pole: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if self.zero is not None and self.pole is None:
            raise ValueError("a weight with a zero needs a pole")


class CertifiedWeights(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The weights of the generalised plant whose norm is bounded: W2, W1, W3, on the command, W4,
    on the measured signal."""

    error: Filter
    disturbance: Amplitude
    drive: Amplitude
    command: Amplitude = 0.0
    noise: Filter = Filter(0.0)
    eta: Amplitude = 0.0


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One rectangle [low, high] of K/J and sigma_v/J in SI, and the Lyapunov matrices at its low
    and at its high K/J.

    Of each the upper triangle, row by row: integers separated by blanks, in units of 2^-bits of the
    bound. Between the ends it is linear.
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

    of: the norm from the weighted inputs to the weighted outputs, or the largest sensitivity
    (1/modulus margin). factor: the upper triangle, row by row, of W; a Lyapunov matrix is W' (its
    integers/2^bits) W.
    """

    of: Literal["norm", "sensitivity"]
    below: PositiveNumber
    bits: Annotated[int, msgspec.Meta(ge=1, le=64)]
    factor: tuple[Row, ...]
    cells: tuple[Cell, ...]

    def __post_init__(self) -> None:
        n = len(self.factor)
        if not 1 <= n <= LARGEST_ORDER or any(
            len(row) != n - index for index, row in enumerate(self.factor)
        ):
            raise ValueError(
                f"factor: allowed: 1 to {LARGEST_ORDER} rows of an upper triangle, the first the longest"
            )
        if len(self.cells) > MOST_CELLS:
            raise ValueError(f"cells: found {len(self.cells)}; allowed: up to {MOST_CELLS}")


class Certificate(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The intervals, the weights and the bounds. `version`: of this layout. not_proved: bounds that
    no proof was found for, and why."""

    version: Literal[1]
    box: Box
    weights: CertifiedWeights
    bounds: tuple[Bound, ...]
    not_proved: dict[str, str] = {}
