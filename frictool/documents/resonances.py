"""`resonances` of `model.yaml`: what links that yield add to the one inertia, between the drive's
effort and the measured position.

position = H(s) rigid position        H = prod_zeros (1 + 2 d s/w + s^2/w^2) prod (1 + s/w) / the
                                      same of the poles,  H(0) = 1
"""

from __future__ import annotations

from typing import Annotated

import msgspec

Ends = tuple[float, float]
Frequency = Annotated[float, msgspec.Meta(gt=0)]
MOST = 8


class Oscillation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A pair of poles or zeros: angular frequency w without damping, and damping ratio d; negative
    of zeros on the right."""

    rad_s: Frequency
    damping: Annotated[float, msgspec.Meta(gt=-1, lt=1)]
    interval_rad_s: Ends | None = None


class Resonances(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """links: those that yield. real_poles_rad_s, real_zeros_rad_s: of factors 1 + s/w, w < 0 for a
    zero on the right."""

    poles: tuple[Oscillation, ...]
    links: tuple[str, ...]
    zeros: tuple[Oscillation, ...] = ()
    real_poles_rad_s: tuple[Frequency, ...] = ()
    real_zeros_rad_s: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.poles) > MOST:
            raise ValueError(f"poles: found {len(self.poles)}; allowed: at most {MOST}")
        below = 2 * len(self.poles) + len(self.real_poles_rad_s)
        above = 2 * len(self.zeros) + len(self.real_zeros_rad_s)
        if above > below:
            raise ValueError(
                f"zeros: found {above} zeros and {below} poles; allowed: no more zeros than poles"
            )
        if any(value == 0.0 for value in self.real_zeros_rad_s):
            raise ValueError("real_zeros_rad_s: found 0; allowed: any other")
