"""Judge of the load's static error behind a backlash; the error is exact or has bounds."""

from __future__ import annotations

from dataclasses import replace

from frictool.documents.controller import Controller
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.spec import Spec
from frictool.presentation.tie_rule import largest
from frictool.report.requirement import Requirement
from frictool.report.worst_hold import JudgedStreams, largest_value, location_of, reasons

METRIC = "load_static_error"
BOUNDED = "bound from the motor's position and the backlash"


def judge_load(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge the largest static error of the load.

    The requirement is met if the upper bound of the error is at most the limit, and not met if the
    lower bound is above the limit. If the limit is between the bounds, the requirement is
    undecided.
    """
    undecided = largest_value(spec, REQUIREMENTS["load_static_error"], [], "")
    ratios = [
        (m.bounds.get(METRIC) or (m.values[METRIC], m.values[METRIC]), e, m)
        for e, holds in evidence
        for m in holds
        if METRIC in m.values or METRIC in m.bounds
    ]
    exact = tuple((e, holds) for e, holds in evidence if not any(METRIC in m.bounds for m in holds))
    missing = "; ".join(reasons(METRIC, exact))
    if not ratios:
        gaps = [item.gaps["load_position"] for item, _ in evidence if "load_position" in item.gaps]
        reason = (
            f"{evidence[0][0].name}: {gaps[0]}"
            if gaps
            else missing or "the reference is never constant"
        )
        return replace(undecided, reason=reason)
    least, at = largest(entry[0][0] for entry in ratios)
    _, item, hold = ratios[at]
    if least > undecided.limit:
        reason = f"lower {BOUNDED}" if METRIC in hold.bounds else missing
        where = location_of(item, hold)
        return replace(undecided, value=least, met=False, reason=reason, where=where)
    most, at = largest(entry[0][1] for entry in ratios)
    (least, _), item, hold = ratios[at]
    where = location_of(item, hold)
    if most <= undecided.limit:
        reason = f"upper {BOUNDED}" if METRIC in hold.bounds else missing
        return replace(undecided, value=most, met=True, reason=reason, where=where)
    reason = f"between {least:.4g} and {most:.4g} {undecided.unit}: {BOUNDED}"
    return replace(undecided, reason=reason, where=where)
