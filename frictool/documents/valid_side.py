"""`valid_side` of `model.yaml`: the side of a position on which a model is valid."""

from __future__ import annotations

import math
from typing import Literal

import msgspec

from frictool.documents.quantity import Axis, Position, si_unit

KEY = "valid_side"  # key of the side, as JSON, in the record `log` of a simulated log


class ValidSide(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Side of a position on which the model is valid; on the other side, the load differs.

    - `side`: Side on which the model is valid.
    - `of`: Position between the sides, at which the load changes, with the position's interval.
    """

    side: Literal["above", "below"]
    of: Position

    @property
    def sign(self) -> float:
        """Return 1 if the model is valid above the position, -1 if it is valid below."""
        return 1.0 if self.side == "above" else -1.0

    @property
    def bound(self) -> float:
        """Return the end of the interval [rad | m] beyond which the model is certainly valid."""
        return self.of.interval[1 if self.side == "above" else 0]

    def contains(self, low: float, high: float) -> bool:
        """Return True if the model is certainly valid from `low` to `high` [rad | m]."""
        return self.sign * (low - self.bound) > 0.0 and self.sign * (high - self.bound) > 0.0

    def place(self, axis: Axis) -> str:
        """Return the valid positions in words, such as `above 0.4 rad (22.9 deg)`."""
        also = f" ({math.degrees(self.of.value):.4g} deg)" if axis == "rotary" else ""
        return f"{self.side} {self.of.value:.3g} {self.of.unit}{also}"

    def left_words(self, axis: Axis, low: float, high: float, moving: str) -> str:
        """Return why the range `low` to `high` [rad | m] leaves the valid side; "" if it does not.

        moving: plural noun for the text, such as `steps`.
        """
        if self.contains(low, high):
            return ""
        return (
            f"the model is valid only {self.place(axis)}, but the {moving} range from {low:.4g} to "
            f"{high:.4g} {si_unit('position', axis)}"
        )
