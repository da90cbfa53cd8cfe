"""Selection of the streams that a page shows, because hundreds of streams are unreadable."""

from __future__ import annotations

from dataclasses import replace

from frictool.report.requirement import Requirement, Verdict
from frictool.report.worst_hold import JudgedStreams

MOST_SHOWN = 40


def worst_requirement(verdict: Verdict) -> Requirement | None:
    """Return the requirement whose worst value exceeds its limit by the largest factor.

    If all limits are met, the result is the requirement whose worst value is nearest to its limit.
    The result is None if no stream has a value.
    """
    located = [r for r in verdict.requirements if r.where is not None and r.where.log is not None]
    return max(located, key=_severity, default=None)


def _severity(requirement: Requirement) -> tuple[bool, float]:
    value, limit = requirement.value, requirement.limit
    if value is None:
        return requirement.met is False, float("inf")
    low, high = (limit, value) if requirement.relation == "<=" else (value, limit)
    return requirement.met is False, high / low if low > 0.0 else float(high > low)


def _with_worst(verdict: Verdict) -> JudgedStreams:
    worst = worst_requirement(verdict)
    if worst is None or worst.where is None:
        return verdict.evidence
    if sum(item.source == worst.where.log for item, _ in verdict.evidence) < 2:
        return verdict.evidence
    named = (worst.where.log, worst.where.stream)
    return tuple(
        (replace(item, worst=(item.source, item.stream.topic) == named), holds)
        for item, holds in verdict.evidence
    )


def select_streams(verdict: Verdict) -> JudgedStreams:
    """Return the streams that a page shows, at most forty, in the order of the evidence.

    If the verdict has more than forty streams, the nominal streams, the worst stream of each
    requirement and the failing streams are selected first. Other streams, at equal distances in the
    list, fill the remaining places. The worst stream is marked if its log has several streams. The
    verdict and `--json` always include all streams.
    """
    streams = _with_worst(verdict)
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
