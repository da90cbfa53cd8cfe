"""JSON view of an identification; the keys are part of the format (docs/formats.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import Any

from msgspec import to_builtins

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.identify.absolute_intervals import parameter_intervals
from frictool.identify.breakaway.breakaway import Breakaway
from frictool.identify.fit_result import Interval
from frictool.identify.identification import Identification
from frictool.identify.model_document import unit_of


def as_view(result: Identification, bench: Bench, model: Model | None = None) -> dict[str, Any]:
    """Return the identification as a mapping of built-in types that JSON can represent."""
    fit, ramp = result.fit, result.ramp
    return {
        "method": result.method,
        "confidence": result.confidence,
        "logs": [{"name": Path(name).name, "kind": kind} for name, kind in result.kinds.items()],
        "parameters": _intervals_view(result.identified, bench, model),
        "narrowed": _intervals_view(result.narrowed, bench, model),
        "force_error": fit.force_error if fit else None,
        "residual": fit.residual if fit else None,
        "held_out_residual": fit.held_out_residual if fit else None,
        "condition": fit.condition if fit else None,
        "samples": fit.samples if fit else None,
        "details": fit.details if fit else {},
        "chosen_because": fit.why if fit else None,
        "dropped": list(fit.dropped) if fit else [],
        "explanations": [asdict(one) for one in fit.explanations] if fit else [],
        "not_identified": result.refused,
        "warnings": list(result.warnings),
        "notes": list(result.notes),
        "laws": None if result.laws is None else to_builtins(result.laws),
        "measurement": None
        if model is None or model.measurement is None
        else to_builtins(model.measurement),
        "presliding": None
        if model is None or model.presliding is None
        else to_builtins(model.presliding),
        "ringing": None if model is None or model.ringing is None else to_builtins(model.ringing),
        "servo": to_builtins(fit.constants) if fit and fit.constants else None,
        "ramp": _ramp_view(ramp) if ramp else None,
        "breakaway_over_rate": None if result.over_rate is None else asdict(result.over_rate),
    }


def _intervals_view(
    intervals: Mapping[str, Interval], bench: Bench, model: Model | None
) -> dict[str, Any]:
    """Return the intervals; add the absolute intervals of parameters in the model."""
    rows = [] if model is None else parameter_intervals(model)
    absolute = {row.name: row.absolute for row in rows}
    out: dict[str, Any] = {}
    for name, interval in intervals.items():
        out[name] = {
            "value": interval.value,
            "low": interval.low,
            "high": interval.high,
            "unit": unit_of(name, bench),
        }
        if name in absolute:
            out[name]["absolute"] = {"low": absolute[name].low, "high": absolute[name].high}
    return out


def _ramp_view(ramp: Breakaway) -> dict[str, Any]:
    """Return the onsets of breakaway ramps as a mapping.

    The key `fall` contains the range of Stribeck velocities for which the interval of the breakaway
    is valid; null marks an end without a limit.
    """
    fall = ramp.fall
    return {
        "forward": ramp.forward,
        "backward": ramp.backward,
        "onsets": ramp.onsets,
        "delay_corrected": ramp.delay,
        "fall": {
            "value": fall.velocity if isfinite(fall.velocity) else None,
            "low": fall.low,
            "high": fall.high if isfinite(fall.high) else None,
            "from": "fit" if fall.known else "onsets",
        },
    }
