"""Gains of a PID controller in `design.yaml`, for method `pid`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from frictool.documents.bench import PositiveNumber
from frictool.documents.quantity import Stiffness, ViscousGain
from frictool.documents.weights import Weights

if TYPE_CHECKING:
    from frictool.documents.design import Design


class Pid(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Gains of method pid: effort/error = K (1 + 1/(T_i s) + T_d s/(T_d/a s + 1)).

    - `gain`: Gain K of a position loop.
    - `speed_gain`: Gain K of a speed loop, which has no derivative part.
    - `integral_time_s`: Integral time T_i. By default there is no integral part.
    - `derivative_time_s`: Derivative time T_d. By default there is no derivative part.
    - `filter_ratio`: Ratio a of the derivative filter's bandwidth to 1/T_d.
    """

    # (5.39)
    gain: Stiffness | None = None
    speed_gain: ViscousGain | None = None
    integral_time_s: PositiveNumber | None = None
    derivative_time_s: PositiveNumber | None = None
    filter_ratio: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if (self.gain is None) == (self.speed_gain is None):
            raise ValueError("give `gain` for a position loop, or `speed_gain` for a speed loop")
        if (self.derivative_time_s is None) != (self.filter_ratio is None):
            raise ValueError(
                "derivative_time_s and filter_ratio go together: a derivative without "
                "a filter cannot be realised"
            )
        if self.speed_gain is not None and self.derivative_time_s is not None:
            raise ValueError(
                "derivative_time_s is for a position loop: the speed loop is a PI controller"
            )


def check_gains(design: Design) -> None:
    """Raise ValueError if gains are missing, or if gains or weights do not fit the structure."""
    if design.pid is None:
        raise ValueError("`method: pid` needs the key `pid` with the gains")
    if (design.structure == "position") != (design.pid.gain is not None):
        raise ValueError(
            "pid: `structure: position` takes `gain` (effort per position); `structure: "
            "speed_cascade` takes `speed_gain` (effort per speed)"
        )
    if design.structure == "speed_cascade" and design.weights != Weights():
        raise ValueError(
            "weights: method pid verifies the sensitivity of a speed loop without weights; write "
            "weights: {}"
        )
