"""`resonances` of `model.yaml`: modes of compliant links between the effort and the position.

    position = H(s) (rigid position),  H(0) = 1
    H = (product of the factors of all zeros)/(product of the factors of all poles)

    1 + 2 d s/w + s^2/w^2     factor of a complex pair of zeros or poles
    1 + s/w                   factor of a real zero or pole

The rigid position is the position that rigid links would have. w is an angular frequency [rad/s],
and d is a damping ratio.
"""

from __future__ import annotations

from typing import Annotated, Self

import msgspec

Ends = tuple[float, float]
Frequency = Annotated[float, msgspec.Meta(gt=0)]
MOST = 8


class Oscillation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Pair of poles or zeros with the factor 1 + 2 damping s/rad_s + s^2/rad_s^2.

    - `rad_s`: Undamped angular frequency.
    - `damping`: Damping ratio; negative for zeros in the right half-plane.
    - `interval_rad_s`: Interval [low, high] of the angular frequency.
    """

    rad_s: Frequency
    damping: Annotated[float, msgspec.Meta(gt=-1, lt=1)]
    interval_rad_s: Ends | None = None

    def scaled(self, factor: float) -> Self:
        """Return an oscillation with `factor` times the frequency and the same damping ratio."""
        ends = self.interval_rad_s
        scaled = None if ends is None else (factor * ends[0], factor * ends[1])
        return msgspec.structs.replace(self, rad_s=factor * self.rad_s, interval_rad_s=scaled)


class Ringing(Oscillation, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Oscillation of the position that the logs of an axis show.

    - `rad_s`: Undamped angular frequency.
    - `damping`: Damping ratio.
    - `interval_rad_s`: Interval [low, high] of the angular frequency.
    - `in_motion`: True if the axis oscillates while it moves, so that all its bodies oscillate;
      False if it rings after stops, when friction may hold a body.
    """

    in_motion: bool = False


class Resonances(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Poles and zeros of the transfer function H of compliant links, with H(0) = 1.

    The position is H(s) times the position that rigid links would have.

    - `poles`: Complex pairs of poles.
    - `links`: Names of the compliant links.
    - `zeros`: Complex pairs of zeros.
    - `real_poles_rad_s`: Angular frequency w of each real pole, which has the factor 1 + s/w.
    - `real_zeros_rad_s`: Angular frequency w of each real zero, which has the factor 1 + s/w;
      negative for a zero in the right half-plane.
    """

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
            raise ValueError("real_zeros_rad_s: found 0; allowed: other than 0")
