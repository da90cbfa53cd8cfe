"""Restriction of a mechanism to a part of its travel."""

from __future__ import annotations

import msgspec

from frictool.adapters.mechanism.block_references import axis_kind
from frictool.adapters.mechanism.sources_and_sensors import controlled_names
from frictool.documents.mechanism import Mechanism
from frictool.documents.quantity import Span, si_unit
from frictool.errors import FrictoolError


class OutsideTravelError(FrictoolError):
    """Error for a requested travel that is outside the mechanism's travel."""


def restrict_travel(whole: Mechanism, ends: tuple[float, float]) -> Mechanism:
    """Return the mechanism with the travel of its sensor's block restricted to `ends` [rad | m].

    Raises OutsideTravelError if `ends` (low, high) and the mechanism's travel do not overlap, or if
    low is not below high.
    """
    if ends[0] >= ends[1]:
        raise OutsideTravelError(f"found {ends[0]:g} to {ends[1]:g}; allowed: LOW < HIGH")
    block = whole.sensors[controlled_names(whole)[1]].on
    unit = si_unit("position", axis_kind(whole.blocks[block]))
    travel = whole.travel
    if travel is not None:
        if ends[1] <= travel.low or ends[0] >= travel.high:
            requested = f"{ends[0]:g} to {ends[1]:g} {unit}"
            allowed = f"{travel.low:g} to {travel.high:g} {unit}"
            raise OutsideTravelError(
                f"found {requested}; allowed: a part of {allowed}, the travel of {whole.name}"
            )
        ends = max(ends[0], travel.low), min(ends[1], travel.high)
    return msgspec.structs.replace(whole, travel=Span(*ends, unit))
