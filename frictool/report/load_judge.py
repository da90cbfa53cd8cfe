"""Judge of the static error behind the backlash, exact or from bounds."""

from __future__ import annotations

from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.presentation.ties import largest
from frictool.report.requirement import Requirement
from frictool.report.worst_hold import JudgedStreams, location_of, reasons

METRIC = "load_static_error"
BOUNDED = "bound from the motor's position and the backlash"


def judge_load(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge the largest static error of the load.

    It is met if its upper bound is within the limit, broken if its lower bound is above the limit,
    and undecided otherwise.
    """
    assert spec.load_static_error is not None
    limit, unit = spec.load_static_error.value, si_unit("position", spec.axis)
    found = [
        (m.bounds.get(METRIC) or (m.values[METRIC], m.values[METRIC]), e, m)
        for e, holds in evidence
        for m in holds
        if METRIC in m.values or METRIC in m.bounds
    ]
    told = "; ".join(
        reasons(
            METRIC,
            tuple(
                (e, holds) for e, holds in evidence if not any(METRIC in m.bounds for m in holds)
            ),
        )
    )
    if not found:
        lacking = [
            item.gaps["load_position"] for item, _ in evidence if "load_position" in item.gaps
        ]
        reason = (
            f"{evidence[0][0].name}: {lacking[0]}" if lacking else told or "the log has no hold"
        )
        return Requirement(METRIC, METRIC, None, limit, unit, None, reason=reason)
    least, at = largest(entry[0][0] for entry in found)
    _, item, hold = found[at]
    if least > limit:
        reason = f"lower {BOUNDED}" if METRIC in hold.bounds else told
        return Requirement(
            METRIC, METRIC, least, limit, unit, False, reason=reason, where=location_of(item, hold)
        )
    most, at = largest(entry[0][1] for entry in found)
    (least, _), item, hold = found[at]
    if most <= limit:
        reason = f"upper {BOUNDED}" if METRIC in hold.bounds else told
        return Requirement(
            METRIC, METRIC, most, limit, unit, True, reason=reason, where=location_of(item, hold)
        )
    reason = f"between {least:.4g} and {most:.4g} {unit}: {BOUNDED}"
    return Requirement(
        METRIC, METRIC, None, limit, unit, None, reason=reason, where=location_of(item, hold)
    )
