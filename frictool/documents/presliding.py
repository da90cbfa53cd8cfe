"""`presliding` of `model.yaml`: what slow loops below the breakaway tell of a contact that has not
yet broken (2.4.3)."""

from __future__ import annotations

from typing import Literal

import msgspec

from frictool.documents.quantity import (
    EffortEstimate,
    NonNegativeEffortEstimate,
    PositiveLengthEstimate,
    StiffnessEstimate,
    ViscousEstimate,
)


class Contact(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A law's parameters; force_error, held_out: rms of what it leaves, on branches seen and not,
    over the breakaway.

    damping: sigma_1 = 2 sqrt(inertia stiffness), a start: slow loops do not tell it. elastic_limit:
    z_ba of the elasto-plastic law (2.46).
    """

    stiffness: StiffnessEstimate
    damping: ViscousEstimate
    force_error: float
    held_out: float
    elastic_limit: PositiveLengthEstimate | None = None


class MaxwellSlip(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The virgin curve, force over displacement from (0, 0), which the elements' bank goes through;
    in SI. `stiffness`: its slope at 0."""

    stiffness: StiffnessEstimate
    displacement: tuple[float, ...]
    force: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    force_error: float
    held_out: float

    def __post_init__(self) -> None:
        if len({len(row) for row in (self.displacement, self.force, self.low, self.high)}) != 1:
            raise ValueError(
                "displacement, force, low, high: found different lengths; allowed: one"
            )


class Preisach(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Everett's table of friction/preisach.py, row by row, over its last node's value `saturation`;
    +-half_width, of the same shape.

    `limit`: the largest amplitude of the cycles that gave it.
    """

    limit: PositiveLengthEstimate
    saturation: EffortEstimate
    table: tuple[tuple[float, ...], ...]
    half_width: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        nodes = len(self.table)
        if (
            nodes < 3
            or any(len(row) != nodes for row in (*self.table, *self.half_width))
            or len(self.half_width) != nodes
        ):
            raise ValueError(
                f"table, half_width: found {nodes} rows; allowed: square, one row and column a node, at least 3"
            )


class Presliding(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`law`: the one that predicts best the branches that its fit has not seen. limit, stiffness:
    z_max and the slope at 0, by that law.

    A law that the loops do not tell is left out, with the reason in `refused`.
    """

    law: Literal["lugre", "elasto_plastic", "maxwell_slip"]
    limit: PositiveLengthEstimate
    stiffness: StiffnessEstimate
    breakaway: NonNegativeEffortEstimate
    lugre: Contact | None = None
    elasto_plastic: Contact | None = None
    maxwell_slip: MaxwellSlip | None = None
    preisach: Preisach | None = None
    refused: dict[str, str] = {}
