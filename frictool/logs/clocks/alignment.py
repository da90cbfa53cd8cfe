"""Clock offset between two files, from a quantity that both files contain (clock_offset.py)."""

from __future__ import annotations

from pathlib import Path

from frictool.documents.bench import ClockEstimate
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import NS, message_path
from frictool.logs.canonical.sample_chunks import join_blocks
from frictool.logs.stream_source import StreamSource
from frictool.typing import Vector

CLOCK_OFFSET = (
    "clock_offset"  # metadata record: topic -> lead of the stream's clock, and source of this lead
)
MOST_SAMPLES = 1_000_000  # maximum number of samples compared, from the start of each stream


def aligned(
    reference: StreamSource, flow: StreamSource, estimate: ClockEstimate, reference_ahead_ns: int
) -> tuple[int, str]:
    """Return the lead in ns of a stream's clock, and a text that describes the estimate.

    The lead is the time by which the clock of `flow` is ahead of the log's clock.

    reference: stream of the log's first file that contains the same quantity.
    estimate: names of the two signals to compare, and the largest allowed lead.
    reference_ahead_ns: time in ns by which the clock of `reference` is ahead of the log's clock.

    Raises LogError if the samples do not determine the lead, or if both streams are from one file.
    """
    from frictool.logs.clocks.clock_offset import clock_offset

    if reference.source == flow.source:
        raise LogError(
            flow.source,
            "clock_estimate compares an instrument with the log's first file; "
            "name another file before this one",
        )
    try:
        t, x = _signal(reference, estimate.reference)
        u, y = _signal(flow, estimate.channel)
        offset = clock_offset(t - reference_ahead_ns / NS, x, u, y, estimate.most.value)
    except ValueError as error:
        names = f"{estimate.channel} and {estimate.reference} of {Path(reference.source).name}"
        raise LogError(flow.source, f"clock_estimate from {names}: {error}") from None
    path = message_path(reference.head.topic, estimate.reference)
    return round(
        offset.value * NS
    ), f"from {offset.low:.6g} to {offset.high:.6g} s (95 %), {estimate.channel} against {path}"


def _signal(flow: StreamSource, name: str) -> tuple[Vector, Vector]:
    if name not in flow.head.fields:
        raise ValueError(
            f"{Path(flow.source).name} has no {name}; it has {', '.join(flow.head.fields)}"
        )
    pieces = []
    rows = 0
    for piece in flow.samples():
        pieces.append(piece)
        rows += piece.time.size
        if rows >= MOST_SAMPLES:
            break
    read = join_blocks(pieces)
    return read.time / NS, read.values[flow.head.fields.index(name)]
