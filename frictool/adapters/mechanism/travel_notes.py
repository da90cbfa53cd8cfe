"""Notes about travels, backlashes and start positions that do not fit each other."""

from __future__ import annotations

from collections.abc import Sequence

from frictool.adapters.mechanism.block_references import BlockNames
from frictool.adapters.mechanism.sources_and_sensors import controlled_names
from frictool.documents.mechanism import Mechanism, Stop
from frictool.documents.quantity import si_unit
from frictool.plant.mechanism.link_graph import Transmission
from frictool.typing import Vector

SAME = 1e-9  # tolerance relative to the travel


def travel_notes(
    document: Mechanism, blocks: BlockNames, start: Vector, joints: Sequence[Transmission]
) -> list[str]:
    """Return notes on backlashes wider than the travel, and on starts outside the travel."""
    return [*_wide_plays(document, blocks, joints), *_travel(document, blocks, start)]


def _wide_plays(
    document: Mechanism, blocks: BlockNames, joints: Sequence[Transmission]
) -> list[str]:
    notes = []
    for link in joints:
        for block, play in ((link.b, 2.0 * link.gap), (link.a, 2.0 * link.gap / abs(link.ratio))):
            between = travel_between_stops(document, blocks.names[block])
            if between is not None and play > between[1] > 0.0:
                unit = si_unit("position", blocks.kinds[block])
                notes.append(
                    f"the backlash of {link.name}, {play:.6g} {unit} at {blocks.names[block]}, is "
                    f"wider than the travel of {blocks.names[block]} between the stops of "
                    f"{between[0]}, {between[1]:.6g} {unit}"
                )
    return notes


def travel_between_stops(document: Mechanism, block: str) -> tuple[str, float] | None:
    """Return the names of a block's innermost stops, and the distance between them [rad | m].

    The result is None if the block has no stop on one side.
    """
    stops = [
        (name, link)
        for name, link in document.links.items()
        if isinstance(link, Stop) and link.on == block
    ]
    lows = [(link.low.value, name) for name, link in stops if link.low is not None]
    highs = [(link.high.value, name) for name, link in stops if link.high is not None]
    if not lows or not highs:
        return None
    low, high = max(lows), min(highs)
    return (low[1] if low[1] == high[1] else f"{low[1]} and {high[1]}"), high[0] - low[0]


def _travel(document: Mechanism, blocks: BlockNames, start: Vector) -> list[str]:
    travel = document.travel
    if travel is None:
        return []
    sensor = controlled_names(document)[1]
    block = document.sensors[sensor].on
    start_position = float(start[blocks.index(f"sensors.{sensor}.on", block)])
    tolerance = SAME * (travel.high - travel.low)
    if travel.low - tolerance <= start_position <= travel.high + tolerance:
        return []
    unit = si_unit("position", blocks.kind(f"sensors.{sensor}.on", block))
    return [
        f"travel from {travel.low:.6g} to {travel.high:.6g} {unit} does not contain the start of "
        f"{block}, {start_position:.6g} {unit}"
    ]
