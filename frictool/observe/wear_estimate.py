"""Estimates of wear with intervals, as used by estimators, logs and verdicts."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["none", "multiplicative", "additive", "directional", "zones"]


@dataclass(frozen=True)
class EstimateRange:
    """Estimated value, and confidence interval of the true value."""

    value: float
    low: float
    high: float

    def over(self, other: EstimateRange) -> EstimateRange:
        """Return the ratio of this estimate to an independent estimate; both must be positive.

        The relative half width of the result is sqrt(a^2 + b^2), with the relative half widths a of
        this and b of the other estimate. For the lower end of the result, a is measured below this
        value and b above the other value. For the upper end, a is measured above and b below.
        """
        ratio = self.value / other.value
        below = ((self.value - self.low) / self.value) ** 2 + (
            (other.high - other.value) / other.value
        ) ** 2
        above = ((self.high - self.value) / self.value) ** 2 + (
            (other.value - other.low) / other.value
        ) ** 2
        return EstimateRange(ratio, ratio * (1.0 - below**0.5), ratio * (1.0 + above**0.5))

    def wider(self, half: float) -> EstimateRange:
        """Return the estimate, widened by an independent error of half width `half`."""
        below = math.hypot(self.value - self.low, half)
        above = math.hypot(self.high - self.value, half)
        return EstimateRange(self.value, self.value - below, self.value + above)

    def as_json(self) -> dict[str, float]:
        """Return the estimate as a JSON object."""
        return {"value": self.value, "low": self.low, "high": self.high}


@dataclass(frozen=True)
class WearZone:
    """Estimated wear in one zone of the travel, from position low to high [rad | m]."""

    low: float
    high: float
    wear: EstimateRange


@dataclass(frozen=True)
class UnmodelledFall:
    """Friction that falls with speed and is not in the model: sum of parts exp(-(v/w)^n).

    - speeds: speed scale w of each part, (m,), rad/s | m/s
    - values: size of each part at speed 0, (m,), N m | N
    - covariance: covariance of the sizes, (m, m), (N m)^2 | N^2
    """

    speeds: tuple[float, ...]
    values: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class WearEstimate:
    """Estimate of the wear after the moves that have ended so far.

    A move is the motion from one rest or reversal to the next.

    - time: time [s] of the last sample that was used
    - moves: number of moves that were used
    - wear: dry friction divided by the model's dry friction (1: no wear), mean over directions and
      zones
    - kind: kind of wear in the data, or `none`
    - forward, backward: wear in each direction
    - added: increase of the friction [N m | N], for kind additive
    - zones: wear in each observed zone of the travel, for kind zones
    - scale: common factor of all wear values, due to an error of the actuator constant. Its value
      is 1; its interval follows from the range of the constant in bench.yaml
      (wear/constant_error.py). The intervals of the wear values do not include this error. The
      factor cancels in a ratio to commissioning.
    - others: other parameters (inertia, ...) divided by the model's values
    - undetermined: names in `others` that the moves determine no better than the prior
    - warnings: lines of text
    - fall: friction that falls with speed and is not in the model; None before the first move
    """

    time: float
    moves: int
    wear: EstimateRange
    kind: Kind = "none"
    forward: EstimateRange | None = None
    backward: EstimateRange | None = None
    added: EstimateRange | None = None
    zones: tuple[WearZone, ...] = ()
    scale: EstimateRange | None = None
    others: dict[str, EstimateRange] = field(default_factory=dict)
    undetermined: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    fall: UnmodelledFall | None = None

    def as_json(self) -> dict[str, Any]:
        """Return the estimate as a JSON object."""
        sides = {
            "forward": self.forward,
            "backward": self.backward,
            "added": self.added,
            "scale": self.scale,
        }
        return {
            "wear": self.wear.as_json(),
            "moves": self.moves,
            "kind": self.kind,
            **{name: side.as_json() for name, side in sides.items() if side is not None},
            **(
                {
                    "zones": [
                        {"from": zone.low, "to": zone.high, **zone.wear.as_json()}
                        for zone in self.zones
                    ]
                }
                if self.zones
                else {}
            ),
            "others": {
                name: side.as_json()
                for name, side in self.others.items()
                if name not in self.undetermined
            },
            "not_determined": list(self.undetermined),
        }
