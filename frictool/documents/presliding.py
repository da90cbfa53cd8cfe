"""`presliding` of `model.yaml`: the contact before breakaway, from slow loops (2.4.3)."""

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
    """Parameters of one presliding law.

    `force_error`, `held_out`: rms residual on the fitted and on the held-out branches, relative to
    the breakaway. `damping`: sigma_1 = 2 sqrt(inertia stiffness), an initial value, because slow
    loops do not determine it. `elastic_limit`: z_ba of the elasto-plastic law (2.46).
    """

    stiffness: StiffnessEstimate
    damping: ViscousEstimate
    force_error: float
    held_out: float
    elastic_limit: PositiveLengthEstimate | None = None


class MaxwellSlip(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Virgin curve of a bank of Maxwell-slip elements: force over displacement from (0, 0), in SI.

    `stiffness`: slope of the curve at 0.
    """

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
    """Everett table of friction/preisach.py, row by row, relative to `saturation`.

    `saturation`: the value at the last node. `half_width`: half-widths of the intervals, in the
    same shape. `limit`: largest amplitude of the identification cycles.
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
                f"table, half_width: found {nodes} rows; allowed: square, one row and "
                "column a node, at least 3"
            )


class Presliding(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Presliding laws of a model.

    `law`: the law with the best prediction of held-out branches. `limit`, `stiffness`: z_max and
    the slope at 0 by this law. `refused` maps each law that the loops do not determine to the
    reason.
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
