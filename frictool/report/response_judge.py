"""Judge of the response time; it also computes the shortest time that the drive allows."""

from __future__ import annotations

import math
from dataclasses import replace

from frictool.adapters.shortest_step import shortest_step_times
from frictool.documents.controller import Controller
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.spec import Spec
from frictool.report.requirement import Requirement
from frictool.report.worst_hold import JudgedStreams, worst_hold
from frictool.verify.vertices import vertex_points


def judge_response(
    spec: Spec, evidence: JudgedStreams, controller: Controller | None
) -> Requirement:
    """Judge the longest response time to 95 %.

    With a controller, `reason` and `details` also contain the shortest time in which the drive can
    make the longest step with the plants at the controller's vertices.
    """
    metric = REQUIREMENTS["response_time_95_s"]
    judged = worst_hold(spec, metric, evidence)
    lengths = [
        abs(one.hold.target - one.hold.origin)
        for _, holds in evidence
        for one in holds
        if metric.name in one.values and one.hold.origin is not None
    ]
    if controller is None or not controller.verified.vertices or not lengths:
        return judged
    percent = spec.overshoot_percent
    overshoot = None if percent is None else percent / 100.0
    bound = shortest_step_times(
        controller.bench, vertex_points(controller), max(lengths), overshoot
    )
    details = {"drive_step": bound.length}
    details |= {
        f"drive_{name}_s": time
        for name, time in (("best", bound.best), ("worst", bound.worst))
        if math.isfinite(time)
    }
    words = bound.words(controller.bench)
    return replace(judged, reason="; ".join(filter(None, (judged.reason, words))), details=details)
