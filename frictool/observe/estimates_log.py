"""Writer of a canonical log with the estimates, while they are computed."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import chain, tee
from typing import BinaryIO

from frictool.logs.canonical.mcap_layout import KIND, NS, TIME, StreamHeader
from frictool.logs.canonical.mcap_writer import CanonicalWriter, Notes, write_streams
from frictool.logs.canonical.sample_chunks import chunked
from frictool.logs.log import MAIN_TOPIC
from frictool.logs.log_assembly import origins
from frictool.logs.losses import LOST, record_of
from frictool.logs.stream_source import SampleBlock
from frictool.observe.combined_estimator import EstimateBlock, head
from frictool.observe.log_observer import LogObserver
from frictool.observe.second_observer import samples_of

ESTIMATE = "estimate"  # metadata record with the final estimate, each value as JSON


def write(one: LogObserver, parts: Iterator[EstimateBlock], stream: BinaryIO, notes: Notes) -> None:
    """Write the estimates of a log to `stream`.

    - one: observer that reads the log
    - parts: blocks of its estimates
    - notes: additional metadata records
    """
    first = next(parts)
    shift = max(0, -round(float(first.piece.time[0]) * NS))
    made = one.feed.made
    dated = origins(made, [one.feed.topic]).get(TIME)
    kept = (
        {}
        if dated is None
        else {
            TIME: {
                MAIN_TOPIC if key == one.feed.topic else key: text for key, text in dated.items()
            }
        }
    )
    kind = {**made.notes.get(KIND, {}), "kind": "estimated", "model": one.model.name}
    # the two streams are written alternately, so that `tee` keeps at most one block in memory
    blocks, other = tee(chain([first], parts))
    streams: list[tuple[StreamHeader, Iterator[SampleBlock]]] = [
        (head(one.model), (part.samples() for part in blocks))
    ]
    if one.second is not None:
        streams.append(
            (
                one.second.head,
                (samples_of(part.second) for part in other if part.second is not None),
            )
        )
    del other
    writer = CanonicalWriter(
        stream, tuple(each for each, _ in streams), {**kept, KIND: kind, **notes}, shift
    )

    def last() -> Notes:
        facts = one.wear.estimate.as_json()
        metadata = {ESTIMATE: {name: json.dumps(value) for name, value in facts.items()}}
        return metadata | ({LOST: record_of(one.feed.losses)} if one.feed.losses else {})

    write_streams(writer, [chunked(samples) for _, samples in streams], last)
