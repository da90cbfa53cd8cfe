"""Judges of requirements on the drive: peak, saturation time, and drive at rest."""

from __future__ import annotations

from dataclasses import replace

from frictool.documents.controller import Controller
from frictool.documents.metric_table import REQUIREMENTS, STREAM_METRICS
from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.metrics.drive_peak import command_peak, least_peak
from frictool.metrics.rest_motion import MOTION_TOLERANCE
from frictool.presentation.tie_rule import largest
from frictool.report.metric_samples import MeasuredPart, measure, no_drive
from frictool.report.requirement import Requirement
from frictool.report.worst_hold import (
    JudgedStreams,
    JudgedValue,
    largest_value,
    location_of,
)


def _undecided(spec: Spec, evidence: JudgedStreams) -> str:
    first = evidence[0][0]
    return f"{first.name}: {no_drive(spec, first)}" if first.drive is None else ""


def judge_peak(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge the largest peak of the drive, from the command and the measured drive.

    The noise of the measured drive is subtracted from the peak of the measured drive. The
    requirement becomes undecided if three conditions hold: the limit is met only because of this
    subtraction, the noise may be an oscillation, and the log contains no command.
    """
    measured = f"peak of the measured {spec.drive}, minus its noise floor"
    peaks: list[JudgedValue] = []
    doubtful: list[JudgedValue] = []
    for item, _ in evidence:
        if item.command is not None:
            value = command_peak(item.command)
            peaks.append(JudgedValue(value, item, reason="peak of the command"))
        if item.measured is not None:
            value = least_peak(item.measured, item.noise)
            peaks.append(JudgedValue(value, item, reason=measured))
            if item.command is None and not item.noise.shown:
                doubtful.append(JudgedValue(command_peak(item.measured), item))
    judged = largest_value(spec, REQUIREMENTS["drive_peak"], peaks, _undecided(spec, evidence))
    if not (judged.met and doubtful):
        return judged
    value, at = largest(one.value for one in doubtful)
    if value <= judged.limit:
        return judged
    reason = (
        f"the measured {spec.drive} reaches {value:.4g} {judged.unit}, but its noise is not white: "
        "a part may be an oscillation; log the command, too"
    )
    return replace(judged, met=None, reason=reason, where=location_of(doubtful[at].item))


def judge_saturation(
    spec: Spec, evidence: JudgedStreams, controller: Controller | None
) -> Requirement:
    """Judge the longest time at the drive's limit within one phase of constant reference.

    In a stream without such phases, the time of the whole stream counts.
    """
    metric = REQUIREMENTS["saturation_time_s"]
    durations = []
    for item, holds in evidence:
        durations += [
            JudgedValue(m.values[metric.name], item, m) for m in holds if metric.name in m.values
        ]
        if not holds:
            whole = measure(STREAM_METRICS[metric.name], MeasuredPart(spec, item))
            reason = "over the whole record, as the reference is never constant"
            durations += (
                [JudgedValue(whole, item, reason=reason)] if isinstance(whole, float) else []
            )
    gaps = [
        item.gaps["drive_limit"]
        for item, _ in evidence
        if item.drive is not None and "drive_limit" in item.gaps
    ]
    return largest_value(spec, metric, durations, gaps[0] if gaps else _undecided(spec, evidence))


def judge_rest(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge motion and drive while the axis should be at rest.

    The field `value` of the requirement is the drive; the field `details` contains the motion.
    """
    after = spec.rest.after_s
    undecided = largest_value(spec, REQUIREMENTS["rest"], [], "")
    rests = [(m, e) for e, holds in evidence for m in holds if "rest_motion" in m.values]
    if not rests:
        gaps = [
            item.gaps[name]
            for item, _ in evidence
            for name in ("position", "reference", "hold")
            if name in item.gaps
        ]
        return replace(
            undecided,
            reason=gaps[0] if gaps else f"the reference is never held for more than {after:g} s",
        )
    _, at = largest(m.values["rest_motion"] - e.resolution for m, e in rests)
    moving, mover = rests[at]
    motion = moving.values["rest_motion"]
    driven = [(m.values["rest_drive"], m, e) for m, e in rests if "rest_drive" in m.values]
    details = {"after_s": after, "motion": motion, "motion_limit": mover.resolution}
    still = replace(undecided, where=location_of(mover, moving), details=details)
    if motion > mover.resolution * (1.0 + MOTION_TOLERANCE):
        reason = (
            f"still moves {motion:.3g} {si_unit('position', spec.axis)} peak to peak after "
            f"{after:g} s of hold"
        )
        return replace(still, value=moving.values.get("rest_drive"), met=False, reason=reason)
    if not driven:
        reason = f"stands still, but {evidence[0][0].name}: {no_drive(spec, evidence[0][0])}"
        return replace(still, reason=reason)
    value, at = largest(d[0] for d in driven)
    _, hold, item = driven[at]
    signal = (
        "command" if item.command is not None else f"measured {spec.drive}, minus its noise floor"
    )
    return replace(
        still,
        value=value,
        met=value <= still.limit,
        reason=f"no motion after {after:g} s of hold; value: peak of the {signal}",
        where=location_of(item, hold),
    )
