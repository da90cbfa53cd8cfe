"""Restriction of a mechanism to a part of its travel, such as one side of a default position."""

from __future__ import annotations

import msgspec

from frictool.adapters.mechanism.block_references import axis_kind
from frictool.adapters.mechanism.sources_and_sensors import controlled_names
from frictool.documents.mechanism import Mechanism
from frictool.documents.quantity import Span, si_unit


class OutsideTravelError(ValueError):
    """Error of a requested travel outside that of the mechanism."""


def restrict_travel(whole: Mechanism, ends: tuple[float, float]) -> Mechanism:
    """Return the mechanism with the travel (low, high) [rad | m] of its sensor's block.

    Raises OutsideTravelError if the mechanism's travel has no part in it.
    """
    block = whole.sensors[controlled_names(whole)[1]].on
    unit = si_unit("position", axis_kind(whole.blocks[block]))
    own = whole.travel
    if own is not None:
        if ends[1] <= own.low or ends[0] >= own.high:
            found = f"{ends[0]:g} to {ends[1]:g} {unit}"
            allowed = f"{own.low:g} to {own.high:g} {unit}"
            raise OutsideTravelError(
                f"found {found}; allowed: a part of {allowed}, the travel of {whole.name}"
            )
        ends = max(ends[0], own.low), min(ends[1], own.high)
    return msgspec.structs.replace(whole, travel=Span(*ends, unit))
