"""Static error of the position in a hold (phase of constant reference)."""

from __future__ import annotations

from frictool.metrics.final_value import final_value
from frictool.typing import Vector


def static_error(position: Vector, target: float) -> float:
    """Return |target - final position| [rad or m] from the positions (n,) of a hold.

    The final position is the mean over the end of the hold (final_value.py).
    """
    return abs(target - final_value(position))
