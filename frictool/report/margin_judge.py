"""Judge of the modulus margin.

The judge uses the margin of each simulated plant. The plant of a recorded axis is unknown, so that
the controller's vertices are judged instead.
"""

from __future__ import annotations

from dataclasses import replace

from frictool.documents.controller import Controller
from frictool.documents.spec import Spec
from frictool.presentation.tie_rule import smallest
from frictool.report.evidence import StreamEvidence
from frictool.report.requirement import Requirement, ValueLocation
from frictool.report.worst_hold import JudgedStreams, location_of

UNSTABLE = "the sampled loop is unstable there"


def judge_margin(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
    """Judge the smallest modulus margin of all streams.

    The requirement is not met if the margin is too small with a simulated plant, or at a vertex
    that the controller document lists. The requirement is undecided if the plant of a simulated
    stream is unknown, or if the controller was not verified for this plant or rig.
    """
    limit = spec.modulus_margin
    undecided = Requirement("modulus_margin", "modulus_margin", None, limit, "", None, ">=")
    streams = [item for item, _ in evidence]
    margins = _margins(streams)
    vertex = None if controller is None else _weakest(controller)
    recorded = any(not item.simulated for item in streams)
    if vertex is not None and (recorded or vertex[0] < limit):
        margins.append(vertex)
    unknown = _unknown(streams, controller)
    if not margins:
        return replace(undecided, reason=unknown or "the controller has no vertices")
    value, index = smallest(margin for margin, _ in margins)
    one = replace(undecided, value=value, where=margins[index][1])
    beyond = next((item.beyond for item in streams if item.beyond), "")
    if value < limit:
        reason = "; ".join(part for part in (UNSTABLE if value == 0.0 else "", beyond) if part)
        return replace(one, met=False, reason=reason)
    reason = unknown or beyond
    return replace(one, met=None if reason else True, reason=reason)


def _margins(streams: list[StreamEvidence]) -> list[tuple[float, ValueLocation]]:
    return [
        (item.modulus_margin, location_of(item))
        for item in streams
        if item.modulus_margin is not None
    ]


def _weakest(controller: Controller) -> tuple[float, ValueLocation] | None:
    vertices = controller.verified.vertices
    if not vertices:
        return None
    value, index = smallest(one.modulus_margin if one.stable else 0.0 for one in vertices)
    return value, ValueLocation(vertex=vertices[index].name)


def _unknown(streams: list[StreamEvidence], controller: Controller | None) -> str:
    for item in streams:
        if item.modulus_margin is None and (item.simulated or controller is None):
            return item.margin_gap
    return ""
