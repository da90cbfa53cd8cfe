"""What is estimated of friction and wear, with intervals: the vocabulary of the estimators, the log
that they write, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["none", "multiplicative", "additive", "directional", "zones"]


@dataclass(frozen=True)
class EstimateRange:
    """A value and the interval that holds it with the confidence that was asked for."""

    value: float
    low: float
    high: float

    def over(self, other: EstimateRange) -> EstimateRange:
        """The ratio of two values that were estimated independently, both positive; intervals in
        quadrature."""
        ratio = self.value / other.value
        below = ((self.value - self.low) / self.value) ** 2 + (
            (other.high - other.value) / other.value
        ) ** 2
        above = ((self.high - self.value) / self.value) ** 2 + (
            (other.value - other.low) / other.value
        ) ** 2
        return EstimateRange(ratio, ratio * (1.0 - below**0.5), ratio * (1.0 + above**0.5))

    def as_json(self) -> dict[str, float]:
        """The machine's view."""
        return {"value": self.value, "low": self.low, "high": self.high}


@dataclass(frozen=True)
class WearZone:
    """Friction over the model's between two positions [rad | m]."""

    low: float
    high: float
    wear: EstimateRange


@dataclass(frozen=True)
class WearEstimate:
    """What is known after some moves.

    time: s, of the last sample that it is from. moves: that it is from. wear: dry friction over the
    model's, 1 where nothing has worn; of all directions and zones together. kind: what the data say
    the wear is, `none` where they say that there is none. forward, backward: the wear of each
    direction. added: of kind additive, what friction has grown by [N m | N]. zones: of kind zones.
    scale: factor that is on all of them alike where the actuator's constant is not the bench's,
    from the bench's range of it; no interval here holds it, and a ratio to commissioning is free of
    it. others: further parameters that the same moves gave, over the model's value (inertia,
    viscous, ...). warnings: for people.
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
    warnings: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """The machine's view."""
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
            **{name: found.as_json() for name, found in sides.items() if found is not None},
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
            "others": {name: found.as_json() for name, found in self.others.items()},
        }
