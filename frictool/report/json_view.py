"""JSON view of the verdict: metrics of each stream and of each phase of constant reference."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from frictool.documents.metric_table import HOLD_METRICS, STREAM_METRICS
from frictool.documents.spec import Spec
from frictool.report.evidence import StreamEvidence
from frictool.report.hold_metrics import HoldMetrics, finite_or_none, stream_metrics
from frictool.report.metric_samples import energy_window
from frictool.report.requirement import Verdict
from frictool.report.worst_hold import NEVER

if TYPE_CHECKING:
    from frictool.verify.vertex_transfers import VertexTransfers

FORMAT = "report/2"  # since version 2 the verdict has three states


def as_json(verdict: Verdict, transfers: VertexTransfers | str | None = None) -> dict[str, Any]:
    """Return the verdict as JSON values.

    `verdict` is `pass`, `fail` or `undecided`; `undecided` lists the undecided requirements. An
    unknown value of a metric is null, and `missing` has the reason. If only bounds are known, the
    value is null, and `bounds` has the bounds. `sensitivity` is null without a controller.
    `meets_all` is true for a stream that meets every requirement; for a recorded stream, the
    modulus margin is not considered.
    """
    spec = verdict.request.spec
    return {
        "format": FORMAT,
        "verdict": verdict.state,
        "name": verdict.name,
        "summary": verdict.headline,
        "plants": len(verdict.plants),
        "streams_meeting_all": sum(verdict.meets),
        "undecided": list(verdict.undecided),
        "warnings": list(verdict.remarks),
        "requirements": [requirement.as_json() for requirement in verdict.requirements],
        "units": {
            metric.name: metric.unit(spec)
            for metric in (*HOLD_METRICS.values(), *STREAM_METRICS.values())
        },
        "energy_window_s": energy_window(spec),
        "sensitivity": {"missing": transfers}
        if isinstance(transfers, str)
        else _sensitivity(transfers),
        "streams": [
            _stream(spec, evidence, holds, meets)
            for (evidence, holds), meets in zip(verdict.evidence, verdict.meets, strict=True)
        ],
    }


def _stream(
    spec: Spec, evidence: StreamEvidence, holds: tuple[HoldMetrics, ...], meets: bool
) -> dict[str, Any]:
    time = evidence.stream.time
    values, missing = stream_metrics(spec, evidence)
    return {
        "log": evidence.source,
        "stream": evidence.stream.topic,
        "meets_all": meets,
        "samples": int(time.size),
        "duration_s": float(time[-1] - time[0]),
        "encoder_step": evidence.resolution or None,
        "modulus_margin": evidence.modulus_margin,
        "gaps": evidence.gaps,
        **{name: finite_or_none(values.get(name, math.inf)) for name in STREAM_METRICS},
        "missing": missing | {name: NEVER for name in values if math.isinf(values[name])},
        "holds": [_hold(measured) for measured in holds],
    }


def _hold(measured: HoldMetrics) -> dict[str, Any]:
    hold = measured.hold
    location = {
        "number": measured.number,
        "start_s": measured.start_s,
        "from": hold.origin,
        "to": hold.target,
    }
    values = {
        name: finite_or_none(measured.values[name]) if name in measured.values else None
        for name in HOLD_METRICS
    }
    never = {name: NEVER for name in measured.values if values[name] is None}
    return {
        **location,
        **values,
        "bounds": measured.bounds,
        "missing": {**measured.missing, **never},
    }


def _sensitivity(checked: VertexTransfers | None) -> dict[str, Any] | None:
    if checked is None:
        return None
    transfers = {
        transfer.name: {
            "largest_gain": float(transfer.gains.max()),
            "worst_of_template": None if transfer.worst is None else transfer.worst.ratio,
            "vertex": None if transfer.worst is None else transfer.worst.vertex,
            "frequency_rad_s": None if transfer.worst is None else transfer.worst.frequency,
        }
        for transfer in checked.transfers
    }
    return {
        "gamma": checked.gamma,
        "gamma_is": "asked" if checked.is_requested else "verified",
        "transfers": transfers,
    }
