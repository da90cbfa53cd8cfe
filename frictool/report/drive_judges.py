"""Judges of the drive requirements: peak, rms, saturation time, energy, and drive at rest."""

from __future__ import annotations

from dataclasses import replace

from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.metrics.drive_peak import command_peak, drive_peak
from frictool.metrics.drive_rms import drive_rms
from frictool.presentation.ties import largest
from frictool.report.evidence import StreamEvidence
from frictool.report.hold_metrics import HoldMetrics, no_drive, saturation
from frictool.report.requirement import Requirement
from frictool.report.worst_hold import JudgedStreams, location_of, worst_hold


def _undecided(
    spec: Spec, key: str, name: str, limit: float, unit: str, evidence: JudgedStreams
) -> Requirement:
    first = evidence[0][0]
    return Requirement(
        name, key, None, limit, unit, None, reason=f"{first.name}: {no_drive(spec, first)}"
    )


def judge_peak(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge the peak drive: of the command, or of the measured drive less its noise floor.

    The larger one counts.
    """
    assert spec.drive_peak is not None
    limit, unit = spec.drive_peak.value, spec.drive_peak.unit
    found: list[tuple[float, StreamEvidence, str]] = []
    for item, _ in evidence:
        if item.command is not None:
            found.append((command_peak(item.command), item, "of the command"))
        if item.measured is not None:
            found.append(
                (
                    drive_peak(item.measured),
                    item,
                    f"of the measured {spec.drive}, less its noise floor",
                )
            )
    if not found:
        return _undecided(spec, "drive_peak", "drive_peak", limit, unit, evidence)
    value, at = largest(entry[0] for entry in found)
    _, item, signal = found[at]
    return Requirement(
        "drive_peak",
        "drive_peak",
        value,
        limit,
        unit,
        value <= limit,
        reason=signal,
        where=location_of(item),
    )


def judge_rms(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge the rms drive over each whole stream, because it heats the motor."""
    assert spec.drive_rms is not None
    limit, unit = spec.drive_rms.value, spec.drive_rms.unit
    found = [
        (drive_rms(item.stream.time, item.drive), item)
        for item, _ in evidence
        if item.drive is not None
    ]
    if not found:
        return _undecided(spec, "drive_rms", "drive_rms", limit, unit, evidence)
    value, at = largest(entry[0] for entry in found)
    _, item = found[at]
    signal = (
        "over the whole record, of the "
        f"{'command' if item.measured is None else f'measured {spec.drive}'}"
    )
    return Requirement(
        "drive_rms",
        "drive_rms",
        value,
        limit,
        unit,
        value <= limit,
        reason=signal,
        where=location_of(item),
    )


def judge_saturation(
    spec: Spec, evidence: JudgedStreams, controller: Controller | None
) -> Requirement:
    """Judge the longest saturation time in one hold.

    A stream without a hold counts as a whole.
    """
    assert spec.saturation_time_s is not None
    name, key, limit = "saturation_time", "saturation_time_s", spec.saturation_time_s
    if all(item.drive is None for item, _ in evidence):
        return _undecided(spec, key, name, limit, "s", evidence)
    found: list[tuple[float, StreamEvidence, HoldMetrics | None]] = []
    for item, holds in evidence:
        found += [(m.values[name], item, m) for m in holds if name in m.values]
        if not holds and item.drive is not None and item.drive_limit is not None:
            found.append((saturation(item, slice(None)), item, None))
    if not found:
        gap = next(item.gaps["drive_limit"] for item, _ in evidence if item.drive is not None)
        return Requirement(name, key, None, limit, "s", None, reason=gap)
    value, at = largest(entry[0] for entry in found)
    _, item, hold = found[at]
    whole = "" if hold is not None else "over the whole record, which is never held"
    return Requirement(
        name, key, value, limit, "s", value <= limit, reason=whole, where=location_of(item, hold)
    )


def judge_energy(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge the energy of the worst step, as in table 5.3."""
    assert spec.energy is not None
    unit = f"{si_unit(spec.drive, spec.axis)}^2"
    if all(item.drive is None for item, _ in evidence):
        return _undecided(spec, "energy", "energy", spec.energy.limit, unit, evidence)
    return replace(worst_hold(spec, "energy", "energy", evidence), unit=unit)


def judge_rest(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge motion and drive at rest.

    The value is the drive; the motion is in `details`.
    """
    assert spec.rest is not None
    unit, after, allowed = si_unit(spec.drive, spec.axis), spec.rest.after_s, spec.rest.drive
    found = [(m, e) for e, holds in evidence for m in holds if "rest_motion" in m.values]
    if not found:
        gaps = [
            item.gaps[name]
            for item, _ in evidence
            for name in ("position", "reference", "hold")
            if name in item.gaps
        ]
        reason = gaps[0] if gaps else f"no hold lasts beyond {after:g} s"
        return Requirement("rest", "rest", None, allowed, unit, None, reason=reason)
    _, at = largest(m.values["rest_motion"] - e.resolution for m, e in found)
    moving, mover = found[at]
    motion = moving.values["rest_motion"]
    driven = [(m.values["rest_drive"], m, e) for m, e in found if "rest_drive" in m.values]
    details = {"after_s": after, "motion": motion, "motion_limit": mover.resolution}
    where = location_of(mover, moving)
    if motion > mover.resolution * (1.0 + 1e-6):
        value = moving.values.get("rest_drive")
        reason = (
            f"still moves {motion:.3g} {si_unit('position', spec.axis)} peak to peak after "
            f"{after:g} s of hold"
        )
        return Requirement(
            "rest", "rest", value, allowed, unit, False, reason=reason, where=where, details=details
        )
    if not driven:
        reason = f"stands still, but {evidence[0][0].name}: {no_drive(spec, evidence[0][0])}"
        return Requirement(
            "rest", "rest", None, allowed, unit, None, reason=reason, where=where, details=details
        )
    value, at = largest(d[0] for d in driven)
    _, hold, item = driven[at]
    signal = (
        "command" if item.command is not None else f"measured {spec.drive}, less its noise floor"
    )
    reason = f"stands still after {after:g} s; {signal}"
    return Requirement(
        "rest",
        "rest",
        value,
        allowed,
        unit,
        value <= allowed,
        reason=reason,
        where=location_of(item, hold),
        details=details,
    )
