"""Selection of the streams that a page shows, because hundreds would make it unusable."""

from __future__ import annotations

from frictool.report.requirement import Verdict
from frictool.report.worst_hold import JudgedStreams

MOST_SHOWN = 40


def select_streams(verdict: Verdict) -> JudgedStreams:
    """Return the streams to draw and to list, in order: all, or at most forty.

    The forty contain the nominal streams, the worst ones and those that fail. The remaining places
    go to other streams, spread evenly. The judgement and `--json` always cover all streams.
    """
    streams = verdict.evidence
    if len(streams) <= MOST_SHOWN:
        return streams
    named = {(r.where.log, r.where.stream) for r in verdict.requirements if r.where is not None}
    nominal = [k for k, (item, _) in enumerate(streams) if item.nominal]
    worst = [k for k, (item, _) in enumerate(streams) if (item.source, item.stream.topic) in named]
    failing = [k for k, meets in enumerate(verdict.meets) if not meets]
    first = list(dict.fromkeys([*nominal, *worst, *failing]))[:MOST_SHOWN]
    others = [k for k in range(len(streams)) if k not in set(first)]
    free = MOST_SHOWN - len(first)
    spread = [others[part * len(others) // free] for part in range(min(free, len(others)))]
    return tuple(streams[k] for k in sorted({*first, *spread}))
