"""`measurement` of `model.yaml`: what the logs tell of the bench itself, beside the friction."""

from __future__ import annotations

import msgspec

from frictool.documents.quantity import (
    NonNegativeLengthEstimate,
    NonNegativeTimeEstimate,
    TimeEstimate,
)


class Measurement(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """backlash: full width. delay: by how much the logged drive comes after the position (negative:
    before).

    loop_time_constant: of the current loop, from commanded and measured current. What the logs do
    not tell is in `refused`.
    """

    backlash: NonNegativeLengthEstimate | None = None
    delay: TimeEstimate | None = None
    loop_time_constant: NonNegativeTimeEstimate | None = None
    refused: dict[str, str] = {}
