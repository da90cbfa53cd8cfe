"""Specification and logs (and controller) to a verdict: the worst value over all steps of all streams, against each limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.logs.log import Log
from frictool.metrics.drive_peak import command_peak, drive_peak
from frictool.report.evidence import Evidence, gather
from frictool.report.measure import Measured, measure
from frictool.report.requirement import Requirement, Verdict, Where

Judged = tuple[tuple[Evidence, tuple[Measured, ...]], ...]
Judge = Callable[[Spec, Judged, Controller | None], Requirement]
NEVER = "does not settle within the hold, or stops short of half of the step"


def judge(spec: Spec, logs: list[Log], controller: Controller | None = None) -> Verdict:
    """One requirement per key that the specification has, in its order.

    Raises LogError where a log cannot be reported on at all (no stream, no samples, another kind of axis).
    """
    resolution = 0.0 if controller is None else controller.bench.encoder.resolution
    evidence = tuple((item, tuple(measure(spec, item))) for item in gather(spec, logs, resolution))
    requirements = tuple(make(spec, evidence, controller) for name, make in JUDGES.items() if getattr(spec, name) is not None)
    return Verdict(spec.name, requirements, evidence)


def _worst_step(spec: Spec, key: str, evidence: Judged) -> Requirement:
    """The largest value of a per-hold metric over all streams; undecided where no hold has it."""
    name, unit = STEP_METRICS[key]
    asked = getattr(spec, key)
    limit = float(getattr(asked, "value", getattr(asked, "limit", asked)))
    unit = unit or getattr(asked, "unit", "")
    found = [(m.values[name], e, m) for e, holds in evidence for m in holds if name in m.values]
    reason = "; ".join(_reasons(name, evidence))
    if not found:
        return Requirement(name, key, None, limit, unit, None, reason=reason or "the log has no step")
    value, item, hold = max(found, key=lambda entry: entry[0])
    where = Where(item.source, item.stream.topic, hold.number, hold.start_s)
    if math.isinf(value):
        return Requirement(name, key, None, limit, unit, False, reason=NEVER, where=where)
    return Requirement(name, key, value, limit, unit, value <= limit, reason=reason, where=where)


def _reasons(metric: str, evidence: Judged) -> Iterator[str]:
    """What keeps a metric from some stream or hold, each said once with the first place."""
    needed = ("position", "reference", "hold" if metric == "static_error" else "step")
    said: set[str] = set()
    for item, holds in evidence:
        told = any(metric in m.values for m in holds)
        gaps = [] if told else [item.gaps[signal] for signal in needed if signal in item.gaps]
        for reason in gaps[:1] + [m.missing[metric] for m in holds if metric in m.missing][:1]:
            if reason not in said:
                said.add(reason)
                yield f"{item.name}: {reason}"


def _modulus_margin(spec: Spec, evidence: Judged, controller: Controller | None) -> Requirement:
    assert spec.modulus_margin is not None
    name, limit = "modulus_margin", spec.modulus_margin
    if controller is None or not controller.verified.vertices:
        reason = "a log alone cannot tell it; give --controller" if controller is None else "the controller names no vertex"
        return Requirement(name, name, None, limit, "", None, ">=", reason)
    worst = min(controller.verified.vertices, key=lambda vertex: (vertex.stable, vertex.modulus_margin))
    met = worst.stable and worst.modulus_margin >= limit
    reason = "" if worst.stable else "the sampled loop is unstable there"
    return Requirement(name, name, worst.modulus_margin, limit, "", met, ">=", reason, Where(vertex=worst.name))


def _drive_peak(spec: Spec, evidence: Judged, controller: Controller | None) -> Requirement:
    """The larger of the command's peak and of the measured drive's, less its noise floor."""
    assert spec.drive_peak is not None
    limit, unit = spec.drive_peak.value, spec.drive_peak.unit
    found: list[tuple[float, Evidence, str]] = []
    for item, _ in evidence:
        if item.command is not None:
            found.append((command_peak(item.command), item, "of the command"))
        if item.measured is not None:
            found.append((drive_peak(item.measured), item, f"of the measured {spec.drive}, less its noise floor"))
    if not found:
        return Requirement("drive_peak", "drive_peak", None, limit, unit, None, reason=_no_drive(spec, evidence))
    value, item, signal = max(found, key=lambda entry: entry[0])
    where = Where(item.source, item.stream.topic)
    return Requirement("drive_peak", "drive_peak", value, limit, unit, value <= limit, reason=signal, where=where)


def _no_drive(spec: Spec, evidence: Judged) -> str:
    return f"{evidence[0][0].name}: {evidence[0][0].gaps[spec.drive]} and no usable command"


def _rest(spec: Spec, evidence: Judged, controller: Controller | None) -> Requirement:
    """Both halves of rest; the value shown is the drive, the motion is in the details."""
    assert spec.rest is not None
    unit, after = si_unit(spec.drive, spec.axis), spec.rest.after_s
    found = [(m, e) for e, holds in evidence for m in holds if "rest_motion" in m.values]
    if not found:
        gaps = [item.gaps[name] for item, _ in evidence for name in ("position", "reference", "hold") if name in item.gaps]
        reason = gaps[0] if gaps else f"no hold lasts beyond {after:g} s"
        return Requirement("rest", "rest", None, spec.rest.drive, unit, None, reason=reason)
    moving, mover = max(found, key=lambda f: f[0].values["rest_motion"] - f[1].resolution)
    motion, allowed = moving.values["rest_motion"], mover.resolution * (1.0 + 1e-6)
    driven = [(m.values["rest_drive"], m, e) for m, e in found if "rest_drive" in m.values]
    details = {"after_s": after, "motion": motion, "motion_limit": mover.resolution}
    place = Where(mover.source, mover.stream.topic, moving.number, moving.start_s)
    if motion > allowed:
        value = max((d[0] for d in driven), default=None)
        reason = f"still moves {motion:.3g} {si_unit('position', spec.axis)} peak to peak after {after:g} s of hold"
        return Requirement("rest", "rest", value, spec.rest.drive, unit, False, reason=reason, where=place, details=details)
    if not driven:
        reason = f"stands still, but {_no_drive(spec, evidence)}"
        return Requirement("rest", "rest", None, spec.rest.drive, unit, None, reason=reason, where=place, details=details)
    value, hold, item = max(driven, key=lambda d: d[0])
    place = Where(item.source, item.stream.topic, hold.number, hold.start_s)
    signal = "command" if item.command is not None else f"measured {spec.drive}, less its noise floor"
    reason = f"stands still after {after:g} s; {signal}"
    return Requirement("rest", "rest", value, spec.rest.drive, unit, value <= spec.rest.drive, reason=reason, where=place, details=details)


def _energy(spec: Spec, evidence: Judged, controller: Controller | None) -> Requirement:
    assert spec.energy is not None
    unit = f"{si_unit(spec.drive, spec.axis)}^2"
    if all(item.measured is None and item.command is None for item, _ in evidence):
        return Requirement("energy", "energy", None, spec.energy.limit, unit, None, reason=_no_drive(spec, evidence))
    return replace(_worst_step(spec, "energy", evidence), unit=unit)


def _per_step(key: str) -> Judge:
    return lambda spec, evidence, controller: _worst_step(spec, key, evidence)


# specification key -> name of the metric, and its unit where the key's value does not carry it
STEP_METRICS: dict[str, tuple[str, str]] = {
    "response_time_95_s": ("response_time_95", "s"),
    "overshoot_percent": ("overshoot", "%"),
    "static_error": ("static_error", ""),
    "oscillations": ("oscillations", ""),
    "energy": ("energy", ""),
}

# specification key -> its judge, in the order of the specification
JUDGES: dict[str, Judge] = {
    "response_time_95_s": _per_step("response_time_95_s"),
    "overshoot_percent": _per_step("overshoot_percent"),
    "static_error": _per_step("static_error"),
    "oscillations": _per_step("oscillations"),
    "modulus_margin": _modulus_margin,
    "drive_peak": _drive_peak,
    "rest": _rest,
    "energy": _energy,
}
