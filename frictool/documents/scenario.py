"""`scenario.yaml`: what is played to the closed loop."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.quantity import Axis, Position


class Step(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The reference held for `duration_s`."""

    reference: Position
    duration_s: PositiveNumber


class Scenario(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`scenario.yaml`.

    start: position at rest before the first step. variants: `nominal` is the model's values; `vertices` adds one run at each
    vertex of the controller's polytope. drive_noise: standard deviation of the measured drive, A or V, drawn from `seed`.
    """

    format: Literal["scenario/1"]
    name: Name
    axis: Axis
    start: Position
    steps: tuple[Step, ...]
    variants: Literal["nominal", "vertices"] = "nominal"
    drive_noise: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    seed: Annotated[int, msgspec.Meta(ge=0)] = 0

    def __post_init__(self) -> None:
        if not self.steps:
            raise ValueError("steps is empty; write at least one {reference: .., duration_s: ..}")
