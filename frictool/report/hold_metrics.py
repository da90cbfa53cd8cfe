"""Metrics of each hold (phase of constant reference) of a stream, and of the whole stream."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from frictool.documents.metric_table import HOLD_METRICS, STREAM_METRICS, Metric
from frictool.documents.spec import Spec
from frictool.metrics.reference_holds import Hold
from frictool.report.evidence import StreamEvidence
from frictool.report.metric_samples import MeasuredPart, measure


@dataclass(frozen=True)
class HoldMetrics:
    """Metrics of one hold (phase of constant reference), each in `values`, `bounds` or `missing`.

    - number: number of the hold in its stream, from 1
    - start_s: start of the hold [s]
    - values: value of each metric in SI (overshoot in %)
    - bounds: (low, high) of each metric that is known only within bounds
    - missing: for each metric without a value, reason why the value is unknown
    """

    hold: Hold
    number: int
    start_s: float
    values: dict[str, float] = field(default_factory=dict)
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)


def needed_metrics(spec: Spec) -> tuple[Metric, ...]:
    """Return the metrics of a hold (phase of constant reference) that the requirements need."""
    return tuple(
        metric
        for metric in HOLD_METRICS.values()
        if metric.key and getattr(spec, metric.key) is not None
    )


def measure_holds(
    spec: Spec, evidence: StreamEvidence, wanted: Sequence[Metric] = tuple(HOLD_METRICS.values())
) -> list[HoldMetrics]:
    """Return the `wanted` metrics of every hold (phase of constant reference) of a stream."""
    metrics = []
    for number, hold in enumerate(evidence.holds, start=1):
        one = HoldMetrics(hold, number, float(evidence.stream.time[hold.start]))
        part = MeasuredPart(spec, evidence, hold)
        for metric in wanted:
            result = measure(metric, part)
            if isinstance(result, str):
                one.missing[metric.name] = result
            elif not isinstance(result, tuple):
                one.values[metric.name] = float(result)
            elif evidence.load_is_bounded:
                one.bounds[metric.name] = result
            else:
                one.values[metric.name] = result[1]
        metrics.append(one)
    return metrics


def stream_metrics(spec: Spec, evidence: StreamEvidence) -> tuple[dict[str, float], dict[str, str]]:
    """Return (values in SI, reasons why a value is unknown), by metric, for STREAM_METRICS.

    A stream with a smooth reference has no other metrics, because it has no phase of constant
    reference.
    """
    values: dict[str, float] = {}
    missing: dict[str, str] = {}
    for name, metric in STREAM_METRICS.items():
        result = measure(metric, MeasuredPart(spec, evidence))
        if isinstance(result, str):
            missing[name] = result
        else:
            assert not isinstance(result, tuple)
            values[name] = float(result)
    return values, missing


def finite_or_none(value: float) -> float | None:
    """Return the value, or None in place of an infinite value, because JSON has no infinity."""
    return value if math.isfinite(value) else None
