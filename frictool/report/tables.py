"""Tables of the report as texts."""

from __future__ import annotations

import math

from frictool.documents.metric_table import DRIVE, HOLD_METRICS, MOTION, STREAM_METRICS, Metric
from frictool.documents.spec import Spec
from frictool.logs.quality.time_base import time_base
from frictool.presentation.sections import TextTable
from frictool.presentation.tie_rule import largest
from frictool.report.evidence import StreamEvidence
from frictool.report.hold_metrics import HoldMetrics, stream_metrics
from frictool.report.metric_samples import energy_window
from frictool.report.requirement import Verdict, number, unit_shown
from frictool.report.worst_hold import JudgedStreams

NOTHING = "–"
MOST_ROWS = 400


def hold_tables(spec: Spec, streams: JudgedStreams) -> list[TextTable]:
    """Return a table on motion and a table on drive and load, with one row per hold.

    A hold is a phase of constant reference. The tables contain the first 400 holds. Columns without
    any value are left out.
    """
    pairs = [(evidence, measured) for evidence, holds in streams for measured in holds]
    names = {name for _, measured in pairs for name in (*measured.values, *measured.bounds)}
    tables = []
    for title in (MOTION, DRIVE):
        metrics = [m for m in HOLD_METRICS.values() if m.table == title and m.name in names]
        heads = (
            "Stream",
            "hold",
            "at [s]",
            "from",
            "to",
            *(heading(metric, spec) for metric in metrics),
        )
        rows = tuple(
            (*_hold(e, m), *(cell(m, metric.name) for metric in metrics))
            for e, m in pairs[:MOST_ROWS]
        )
        if metrics:
            tables.append(TextTable(title, heads, rows, 1, max(0, len(pairs) - MOST_ROWS)))
    return tables


def heading(metric: Metric, spec: Spec) -> str:
    """Return title and unit of a metric; for the energy, also its time t_int."""
    unit = metric.unit(spec)
    window = energy_window(spec)
    title = (
        f"{metric.title} in {window:g} s"
        if "energy_window" in metric.needs and window is not None
        else metric.title
    )
    return f"{title} [{unit_shown(unit)}]" if unit else title


def _hold(evidence: StreamEvidence, measured: HoldMetrics) -> tuple[str, ...]:
    hold = measured.hold
    return (
        evidence.name,
        str(measured.number),
        f"{measured.start_s:.4g}",
        number(hold.origin),
        number(hold.target),
    )


def cell(measured: HoldMetrics, name: str) -> str:
    """Return a metric of one hold as text: the value, or both bounds if no value is known.

    An infinite value is shown as `never`, an unknown value as a dash.
    """
    if name in measured.bounds:
        return " to ".join(dict.fromkeys(number(bound) for bound in measured.bounds[name]))
    return _shown(measured.values.get(name))


def _shown(value: float | None) -> str:
    return NOTHING if value is None else "never" if math.isinf(value) else number(value)


def stream_table(spec: Spec, streams: JudgedStreams) -> TextTable:
    """Return the table with one row per stream: sampling and stream metrics."""
    heads = (
        "Stream",
        "samples",
        "duration [s]",
        "rate [Hz]",
        "gaps",
        "sensor step",
        *(heading(m, spec) for m in STREAM_METRICS.values()),
    )
    rows = []
    for evidence, _ in streams:
        base, (values, _) = time_base(evidence.stream.time), stream_metrics(spec, evidence)
        sampled = (
            str(base.samples),
            number(base.duration_s),
            number(base.rate_hz),
            str(base.gaps),
            number(evidence.resolution or None),
        )
        rows.append(
            (evidence.name, *sampled, *(_shown(values.get(name)) for name in STREAM_METRICS))
        )
    return TextTable("", heads, tuple(rows), 1)


def side_by_side(spec: Spec, verdict: Verdict) -> list[TextTable]:
    """Return tables with the worst value of each metric in each log (as thesis table 5.3).

    The last table is for all streams. If there are plant variants, another table is for the nominal
    streams only. For a single log, there is no table.
    """
    sources = tuple(dict.fromkeys(evidence.source for evidence, _ in verdict.evidence))
    if len(sources) < 2:
        return []
    tables = [_compared(spec, "Worst hold of all streams", sources, verdict.evidence)]
    if any(not evidence.nominal for evidence, _ in verdict.evidence):
        nominal = tuple(
            (evidence, holds) for evidence, holds in verdict.evidence if evidence.nominal
        )
        tables.insert(0, _compared(spec, "Worst hold of the nominal stream", sources, nominal))
    counts = [
        [
            meets
            for (e, _), meets in zip(verdict.evidence, verdict.meets, strict=True)
            if e.source == source
        ]
        for source in sources
    ]
    meeting = (
        "streams that meet all requirements",
        *(f"{sum(met)} of {len(met)}" for met in counts),
    )
    rows = (meeting, *tables[-1].rows, *_speeds(spec, sources, verdict.evidence))
    return [*tables[:-1], TextTable(tables[-1].title, tables[-1].headings, rows, 1)]


def _speeds(spec: Spec, sources: tuple[str, ...], streams: JudgedStreams) -> list[tuple[str, ...]]:
    cells = []
    for name, metric in STREAM_METRICS.items():
        if "used_velocity" not in metric.needs:
            continue
        each = [
            [stream_metrics(spec, e)[0].get(name) for e, _ in streams if e.source == source]
            for source in sources
        ]
        row = [
            max((value for value in values if value is not None), default=None) for values in each
        ]
        if any(value is not None for value in row):
            cells.append((heading(metric, spec), *map(_shown, row)))
    return cells


def _compared(
    spec: Spec, title: str, sources: tuple[str, ...], streams: JudgedStreams
) -> TextTable:
    columns = [
        [m for e, holds in streams if e.source == source for m in holds] for source in sources
    ]
    rows = [
        (heading(metric, spec), *(_worst(holds, name) for holds in columns))
        for name, metric in HOLD_METRICS.items()
    ]
    kept = tuple(row for row in rows if set(row[1:]) != {NOTHING})
    return TextTable(title, ("", *sources), kept, 1)


def _worst(holds: list[HoldMetrics], name: str) -> str:
    having = [m for m in holds if name in m.values or name in m.bounds]
    if not having:
        return NOTHING
    _, at = largest(m.bounds[name][1] if name in m.bounds else m.values[name] for m in having)
    return cell(having[at], name)
