"""Judges of the tracking error, for streams whose reference moves."""

from __future__ import annotations

from frictool.documents.controller import Controller
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.spec import Spec
from frictool.metrics.reference_motion import find_motions
from frictool.report.evidence import StreamEvidence
from frictool.report.metric_samples import tracked_signal
from frictool.report.requirement import Requirement
from frictool.report.worst_hold import Judge, JudgedStreams, largest_value, worst_stream

NO_MOTION = "the reference does not move, or moves by steps only, which no axis can track"


def judge_tracking(key: str) -> Judge:
    """Return the judge of the tracking error that the specification limits under `key`.

    A stream is ignored if it has no profile and its reference changes by steps only.
    """
    metric = REQUIREMENTS[key]

    def judge(spec: Spec, evidence: JudgedStreams, controller: Controller | None) -> Requirement:
        moving = tuple(one for one in evidence if not _is_still(one[0]))
        if moving:
            return worst_stream(spec, metric, moving)
        return largest_value(spec, metric, [], f"{evidence[0][0].name}: {NO_MOTION}")

    return judge


def _is_still(evidence: StreamEvidence) -> bool:
    signal = tracked_signal(evidence)
    return "reference" not in evidence.gaps and not find_motions(evidence.stream.signals[signal])
