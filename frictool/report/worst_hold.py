"""Worst value of a metric in all holds of all streams, compared with its limit.

A hold is a phase of constant reference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from frictool.documents.controller import Controller
from frictool.documents.metric_table import HOLD_METRICS, REQUIREMENTS, Metric
from frictool.documents.spec import Spec
from frictool.presentation.tie_rule import largest
from frictool.report.evidence import StreamEvidence
from frictool.report.hold_metrics import HoldMetrics
from frictool.report.metric_samples import NO_STEP, MeasuredPart, measure
from frictool.report.requirement import Requirement, ValueLocation

JudgedStreams = tuple[tuple[StreamEvidence, tuple[HoldMetrics, ...]], ...]
Judge = Callable[[Spec, JudgedStreams, Controller | None], Requirement]
NEVER = "does not settle within the hold, or moves by less than half of the step"


class JudgedValue(NamedTuple):
    """Value of a metric for the stream `item` or, if `hold` is not None, for one hold.

    A hold is a phase of constant reference.

    - reason: remark on the value
    """

    value: float
    item: StreamEvidence
    hold: HoldMetrics | None = None
    reason: str = ""


def limit_of(spec: Spec, key: str) -> float:
    """Return the limit in SI that the specification states under `key`."""
    limit = getattr(spec, key)
    if isinstance(limit, float):
        return float(limit)
    for part in ("limit", "drive", "value"):  # limit of `energy`, of `rest` or of a quantity
        limit = getattr(limit, part, limit)
    return float(limit)


def location_of(item: StreamEvidence, hold: HoldMetrics | None = None) -> ValueLocation:
    """Return the location of a value; `hold` is None if the value belongs to the whole stream."""
    if hold is None:
        return ValueLocation(item.source, item.stream.topic)
    return ValueLocation(item.source, item.stream.topic, hold.number, hold.start_s)


def largest_value(
    spec: Spec, metric: Metric, judged: list[JudgedValue], undecided: str
) -> Requirement:
    """Compare the largest judged value with the metric's limit and return the requirement.

    If `judged` is empty, the requirement is undecided, with the reason `undecided`. An infinite
    value does not meet the requirement.
    """
    limit = limit_of(spec, metric.key)
    unit = metric.unit(spec)
    name = metric.requirement_name
    key = metric.key
    if not judged:
        return Requirement(name, key, None, limit, unit, None, reason=undecided)
    _, at = largest(one.value for one in judged)
    value, item, hold, reason = judged[at]
    where = location_of(item, hold)
    if math.isinf(value):
        return Requirement(name, key, None, limit, unit, False, reason=NEVER, where=where)
    return Requirement(name, key, value, limit, unit, value <= limit, reason=reason, where=where)


def worst_hold(
    spec: Spec, metric: Metric, evidence: JudgedStreams, *, with_reasons: bool = True
) -> Requirement:
    """Compare the largest value of a metric over all holds with the limit; return the requirement.

    A hold is a phase of constant reference.

    - with_reasons: True to add the reasons why the metric is unknown in some holds
    """
    name = metric.name
    reason = "; ".join(reasons(metric.name, evidence))
    judged = [
        JudgedValue(m.values[name], e, m, reason if with_reasons else "")
        for e, holds in evidence
        for m in holds
        if name in m.values
    ]
    return largest_value(spec, metric, judged, reason or "the log has no step")


def worst_stream(spec: Spec, metric: Metric, evidence: JudgedStreams) -> Requirement:
    """Compare the largest value of a stream metric over all streams with the metric's limit.

    Return the requirement with its outcome.
    """
    judged, missing = [], []
    for item, _ in evidence:
        value = measure(metric, MeasuredPart(spec, item))
        if isinstance(value, str):
            missing.append(f"{item.name}: {value}")
        else:
            signal = "command" if item.measured is None else f"measured {spec.drive}"
            of_signal = f", of the {signal}" if "drive" in metric.needs else ""
            assert not isinstance(value, tuple)
            remark = f"over the whole record{of_signal}"
            judged.append(JudgedValue(float(value), item, reason=remark))
    return largest_value(spec, metric, judged, "; ".join(missing[:1]))


def reasons(metric: str, evidence: JudgedStreams) -> Iterator[str]:
    """Yield each reason why a metric is unknown, with the first stream to which it applies."""
    needed = ("position", "reference", "step" if "step" in HOLD_METRICS[metric].needs else "hold")
    said: set[str] = set()
    for item, holds in evidence:
        measured = any(metric in m.values for m in holds)
        gaps = [] if measured else [item.gaps[signal] for signal in needed if signal in item.gaps]
        lacking = [m.missing[metric] for m in holds if m.missing.get(metric, NO_STEP) != NO_STEP]
        for reason in (gaps or lacking)[:1]:
            if reason not in said:
                said.add(reason)
                yield f"{item.name}: {reason}"


def judge_cycle(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge the largest amplitude of a limit cycle.

    Phases of constant reference that are too short to show a limit cycle are ignored.
    """
    return worst_hold(spec, REQUIREMENTS["limit_cycle"], evidence, with_reasons=False)


def judge_of(metric: Metric) -> Judge:
    """Return the function that judges a metric by its worst value over all holds or streams."""
    worst = {"hold": worst_hold, "stream": worst_stream}[metric.scope]
    return lambda spec, evidence, controller: worst(spec, metric, evidence)
