"""Specification and logs (and controller) to a verdict: the worst value over all steps of all streams, against each limit."""

from __future__ import annotations

from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.logs.log import Log
from frictool.report.drive_judges import judge_energy, judge_peak, judge_rest, judge_rms, judge_saturation
from frictool.report.evidence import Evidence, gather
from frictool.report.load_judge import judge_load
from frictool.report.measure import Measured, measure
from frictool.report.requirement import Requirement, Verdict, Where
from frictool.report.rig import Rig
from frictool.report.worst import Judge, Judged, per_hold
from frictool.ties import smallest


def judge(spec: Spec, logs: list[Log], controller: Controller | None = None, bench: Bench | None = None) -> Verdict:
    """One requirement per key that the specification has, in its order; `bench` is the controller's own where it is not given.

    Raises LogError where a log cannot be reported on at all (no stream, no samples, another kind of axis), FrictoolError where there is no
    log.
    """
    if not logs:
        raise FrictoolError("there is no log to judge; give at least one")
    requirements, evidence = decided(spec, logs, controller, bench, whole=True)
    of_logs = [make for name, make in _asked(spec).items() if name != "modulus_margin"]
    return Verdict(spec.name, requirements, evidence, tuple(_meets(spec, one, of_logs) for one in evidence))


def decided(
    spec: Spec, logs: list[Log], controller: Controller | None = None, bench: Bench | None = None, whole: bool = False
) -> tuple[tuple[Requirement, ...], Judged]:
    """The requirements of `judge`, and what they were decided by; whole: with metrics that are not specified."""
    rig = Rig.of(bench if bench is not None or controller is None else controller.bench)
    evidence = tuple((item, tuple(measure(spec, item, whole))) for item in gather(spec, logs, rig))
    return tuple(make(spec, evidence, controller) for make in _asked(spec).values()), evidence


def _asked(spec: Spec) -> dict[str, Judge]:
    return {name: make for name, make in JUDGES.items() if getattr(spec, name) is not None}


def _meets(spec: Spec, stream: tuple[Evidence, tuple[Measured, ...]], judges: list[Judge]) -> bool:
    """Whether one stream by itself meets every requirement."""
    return bool(judges) and all(make(spec, (stream,), None).met for make in judges)


def _modulus_margin(spec: Spec, evidence: Judged, controller: Controller | None) -> Requirement:
    assert spec.modulus_margin is not None
    name, limit = "modulus_margin", spec.modulus_margin
    if controller is None or not controller.verified.vertices:
        reason = "a log alone cannot tell it; give --controller" if controller is None else "the controller names no vertex"
        return Requirement(name, name, None, limit, "", None, ">=", reason)
    vertices = controller.verified.vertices
    unstable = next((vertex for vertex in vertices if not vertex.stable), None)
    if unstable is not None:
        reason, where = "the sampled loop is unstable there", Where(vertex=unstable.name)
        return Requirement(name, name, unstable.modulus_margin, limit, "", False, ">=", reason, where)
    margin, at = smallest(vertex.modulus_margin for vertex in vertices)
    return Requirement(name, name, margin, limit, "", margin >= limit, ">=", "", Where(vertex=vertices[at].name))


# specification key -> its judge, in the order of the specification
JUDGES: dict[str, Judge] = {
    "response_time_95_s": per_hold("response_time_95_s", "response_time_95"),
    "rise_time_s": per_hold("rise_time_s", "rise_time"),
    "overshoot_percent": per_hold("overshoot_percent", "overshoot"),
    "static_error": per_hold("static_error", "static_error"),
    "load_static_error": judge_load,
    "oscillations": per_hold("oscillations", "oscillations"),
    "limit_cycle": per_hold("limit_cycle", "limit_cycle_amplitude", name="limit_cycle", tell=False),
    "modulus_margin": _modulus_margin,
    "drive_peak": judge_peak,
    "drive_rms": judge_rms,
    "saturation_time_s": judge_saturation,
    "rest": judge_rest,
    "energy": judge_energy,
}
