"""Worst value of a metric over all holds of all streams, against its limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from frictool.documents.controller import Controller
from frictool.documents.spec import Spec
from frictool.presentation.ties import largest
from frictool.report.evidence import StreamEvidence
from frictool.report.hold_metrics import NO_STEP, OF_A_STEP, HoldMetrics
from frictool.report.metric_table import HOLD_METRICS
from frictool.report.requirement import Requirement, ValueLocation

JudgedStreams = tuple[tuple[StreamEvidence, tuple[HoldMetrics, ...]], ...]
Judge = Callable[[Spec, JudgedStreams, Controller | None], Requirement]
NEVER = "does not settle within the hold, or stops short of half of the step"


def limit_of(spec: Spec, key: str) -> float:
    """Return the limit that the specification's key sets, in SI."""
    asked = getattr(spec, key)
    return float(getattr(asked, "value", getattr(asked, "limit", asked)))


def location_of(item: StreamEvidence, hold: HoldMetrics | None = None) -> ValueLocation:
    """Return the location of a value: stream, and hold if it belongs to one."""
    if hold is None:
        return ValueLocation(item.source, item.stream.topic)
    return ValueLocation(item.source, item.stream.topic, hold.number, hold.start_s)


def worst_hold(
    spec: Spec, key: str, metric: str, evidence: JudgedStreams, *, name: str = "", tell: bool = True
) -> Requirement:
    """Return the requirement on the largest value of a hold metric; undecided without a value.

    `name`: name of the requirement, if it is not the metric's. `tell`: a decided requirement also
    names the holds without a value.
    """
    name, limit, unit = name or metric, limit_of(spec, key), HOLD_METRICS[metric].unit(spec)
    found = [(m.values[metric], e, m) for e, holds in evidence for m in holds if metric in m.values]
    reason = "; ".join(reasons(metric, evidence))
    if not found:
        return Requirement(
            name, key, None, limit, unit, None, reason=reason or "the log has no step"
        )
    value, at = largest(entry[0] for entry in found)
    _, item, hold = found[at]
    if math.isinf(value):
        return Requirement(
            name, key, None, limit, unit, False, reason=NEVER, where=location_of(item, hold)
        )
    return Requirement(
        name,
        key,
        value,
        limit,
        unit,
        value <= limit,
        reason=reason if tell else "",
        where=location_of(item, hold),
    )


def reasons(metric: str, evidence: JudgedStreams) -> Iterator[str]:
    """Yield why streams or holds lack a metric, each reason once with its first location."""
    needed = ("position", "reference", "step" if metric in OF_A_STEP else "hold")
    said: set[str] = set()
    for item, holds in evidence:
        told = any(metric in m.values for m in holds)
        gaps = [] if told else [item.gaps[signal] for signal in needed if signal in item.gaps]
        lacking = [m.missing[metric] for m in holds if m.missing.get(metric, NO_STEP) != NO_STEP]
        for reason in (gaps or lacking)[:1]:
            if reason not in said:
                said.add(reason)
                yield f"{item.name}: {reason}"


def hold_judge(key: str, metric: str, *, name: str = "", tell: bool = True) -> Judge:
    """Return the judge of a key that limits a metric in each hold."""
    return lambda spec, evidence, controller: worst_hold(
        spec, key, metric, evidence, name=name, tell=tell
    )
