"""Computation of a verdict from the worst values in all steps of all streams of the logs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from frictool.adapters.temperature_factors import KEY as TEMPERATURE
from frictool.adapters.temperature_factors import temperature_words
from frictool.documents.bench import Bench
from frictool.documents.bench_values import KEY, bench_values_words
from frictool.documents.controller import Controller
from frictool.documents.digests import changed_words
from frictool.documents.example_values import examples_words
from frictool.documents.logged_positions import KEY as LOGGED
from frictool.documents.logged_positions import extrapolated_words, from_text
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.missing_effects import KEY as MISSING
from frictool.documents.missing_effects import UNDECIDED
from frictool.documents.presliding import KEY as PRESLIDING
from frictool.documents.presliding import presliding_words
from frictool.documents.spec import Spec
from frictool.documents.valid_side import KEY as SIDE
from frictool.documents.valid_side import ValidSide
from frictool.errors import FrictoolError, LogError
from frictool.logs.log import Log, Stream
from frictool.logs.quality.overspeed import overspeed_of_streams
from frictool.report.drive_judges import judge_peak, judge_rest, judge_saturation
from frictool.report.evidence import (
    NO_CONTROLLER,
    AboutStream,
    StreamEvidence,
    gather_evidence,
    log_labels,
    stream_evidence,
)
from frictool.report.hold_metrics import HoldMetrics, measure_holds, needed_metrics
from frictool.report.knowledge import with_knowledge
from frictool.report.load_judge import judge_load
from frictool.report.margin_judge import judge_margin
from frictool.report.requirement import ReportRequest, Requirement, Verdict
from frictool.report.response_judge import judge_response
from frictool.report.rig_facts import RigFacts
from frictool.report.tracking_judge import judge_tracking
from frictool.report.worst_hold import Judge, judge_cycle, judge_of
from frictool.typing import Vector

if TYPE_CHECKING:
    from frictool.report.judged_loop import JudgedLoop
    from frictool.report.run_metrics import Outcome, RunRecord
    from frictool.verify.logged_plant import LoggedPlant


def judge(
    spec: Spec,
    logs: Sequence[Log],
    controller: Controller | None = None,
    bench: Bench | None = None,
) -> Verdict:
    """Judge logs by the requirements of a specification.

    Parameters
    ----------
    spec : Spec
        The requirements.
    logs : sequence of Log
        Simulated or recorded logs, at least one.
    controller : Controller, optional
        The controller, for the modulus margin and for its bench.
    bench : Bench, optional
        The bench of recorded logs; by default the controller's bench.

    Returns
    -------
    Verdict
        One requirement for each key of the specification, in the same order, with the evidence.

    Raises
    ------
    LogError
        If a log has no stream or no samples, or if the kinds of axis in log and specification
        differ.
    FrictoolError
        If `logs` is empty.
    """
    return verdict_of(ReportRequest(spec, tuple(logs), controller, bench))


def verdict_of(request: ReportRequest) -> Verdict:
    """Return the verdict on the logs and documents of a request, as `judge` does."""
    spec, logs, controller, bench = request.spec, request.logs, request.controller, request.bench
    if not logs:
        raise FrictoolError("there is no log to judge; give at least one")
    loop = None if controller is None else _loop(controller, bench)
    bench = bench if bench is not None or controller is None else controller.bench
    evidence = tuple(
        (item, tuple(measure_holds(spec, item)))
        for item in gather_evidence(spec, logs, RigFacts.of(bench), loop)
    )
    streams = [item for item, _ in evidence]
    doubt = _doubt(request, streams, loop)
    requirements = tuple(
        with_knowledge(
            _doubted(make(spec, evidence, controller), doubt), streams, controller, request.proof
        )
        for make in _specified_judges(spec).values()
    )
    beyond = dict.fromkeys(f"{item.source}: {item.beyond}" for item, _ in evidence if item.beyond)
    remarks = [
        *_changed(controller),
        *(beyond or _played_beyond(logs, loop)),
        *_simulated_models(logs),
        *_overspeed(streams, bench),
        *_extrapolated(logs, controller),
        *_examples(spec, logs, bench),
    ]
    return Verdict(
        request,
        requirements,
        evidence,
        tuple(not doubt and _meets(spec, one) for one in evidence),
        tuple(remarks),
    )


def _doubt(
    request: ReportRequest, streams: Sequence[StreamEvidence], loop: JudgedLoop | None
) -> str:
    """Return why a simulation that meets the specification may differ from the axis, or "".

    There are three reasons:

    - Positions leave the side of the travel on which the model is valid.
    - The logs of the model show a lag that the bench lacks, and that the loop does not tolerate.
    - The axis rings after it stops. If there is a controller, and the specification has a modulus
      margin, the requirement `modulus_margin` states this reason instead.
    """
    for log in request.logs:
        if left := _left_side(request.spec, log):
            return left
    if loop is None or not loop.doubt:
        for log in request.logs:
            if reason := log.metadata.get("log", {}).get(UNDECIDED):
                return reason
    if loop is None or request.spec.modulus_margin is not None:
        return ""
    return loop.doubt if any(item.simulated for item in streams) else ""


def _left_side(spec: Spec, log: Log) -> str:
    """Return why positions of a simulated log leave the valid side of its model, or ""."""
    record = log.metadata.get("log", {}).get(SIDE)
    if record is None:
        return ""
    try:
        side = msgspec.json.decode(record, type=ValidSide)
    except msgspec.MsgspecError as error:
        raise LogError(log.source, f"metadata log: {SIDE}: {error}; simulate again") from None
    positions = _positions(log)
    if not positions.size:
        return ""
    return side.left_words(spec.axis, positions.min(), positions.max(), "positions")


def _positions(log: Log) -> Vector:
    """Return the finite positions (n,) [rad | m] of all axes of a log."""
    signals = [one.signals["position"] for one in log.axes if "position" in one.signals]
    return np.concatenate([one[np.isfinite(one)] for one in (np.empty(0), *signals)])


def _doubted(requirement: Requirement, doubt: str) -> Requirement:
    """Return the requirement; it becomes undecided if it is met and there is a `doubt`."""
    if not doubt or not requirement.met or requirement.key == "modulus_margin":
        return requirement
    return replace(requirement, met=None, reason=doubt)


def _loop(controller: Controller, bench: Bench | None) -> JudgedLoop:
    from frictool.report.judged_loop import (
        JudgedLoop,  # imported here, because a log without a controller does not need it
    )
    from frictool.verify.ringing_loop import ringing_doubt

    return JudgedLoop(controller, bench, ringing_doubt(controller))


class RunJudge:
    """Judge of the simulated plants of one controller.

    The modulus margin is computed with the simulated plant, not with the controller's vertices.
    `records`: metadata of a simulated log, with the rig and the intervals of the plant. `doubt`:
    reason why the margins may be wrong for every plant, or "".
    """

    def __init__(
        self,
        spec: Spec,
        controller: Controller,
        records: Mapping[str, dict[str, str]],
        doubt: str = "",
    ) -> None:
        from frictool.report.judged_loop import JudgedLoop, unstated_words
        from frictool.report.run_metrics import RunMetrics

        self.spec = spec
        of_run = Log((), {"log": {"kind": "simulated"}, **records})
        self._rig = RigFacts.of(controller.bench).played(of_run)
        self._metrics = needed_metrics(spec)
        self._judges = tuple(_specified_judges(spec).values())
        self._of_run = RunMetrics(spec, self._rig)
        self._loop = None
        if spec.modulus_margin is not None:
            self._loop = JudgedLoop(controller, doubt=doubt)
            self._beyond = self._loop.beyond(of_run)
            self._unstated = unstated_words(of_run)

    def __call__(
        self, source: str, stream: Stream, plant: LoggedPlant | None
    ) -> tuple[Requirement, ...]:
        """Return the requirements with their outcomes for one simulated plant.

        The requirements are in the order of the specification.

        - source: label of the simulation
        - plant: linear plant for the modulus margin; None if it is unknown
        """
        margin, gap = None, NO_CONTROLLER
        beyond = ""
        if self._loop is not None:
            margin, gap = self._loop.margin_of(plant, self._unstated)
            beyond = self._beyond
        about = AboutStream(PurePath(source).name or source, True, True, margin, gap, beyond)
        item = stream_evidence(self.spec, source, stream, self._rig, about)
        evidence = ((item, tuple(measure_holds(self.spec, item, self._metrics))),)
        return tuple(make(self.spec, evidence, None) for make in self._judges)

    def outcomes(self, run: RunRecord, plant: LoggedPlant | None) -> list[Outcome] | None:
        """Return (value, met) of each requirement for one simulated plant.

        No stream is built, which saves time. Return None if the verdict needs a stream
        (report/run_metrics.py).
        """
        if not self._of_run.covers:
            return None
        value = None if self._loop is None else self._loop.margin_of(plant, self._unstated)[0]
        if value is None:
            return self._of_run(run, (math.nan, None))
        is_broken = value < self.spec.modulus_margin
        return self._of_run(run, (value, False if is_broken else None if self._beyond else True))


def _played_beyond(logs: Sequence[Log], loop: JudgedLoop | None) -> list[str]:
    notes = (
        [] if loop is None else zip(log_labels(logs), map(loop.played_beyond, logs), strict=True)
    )
    return [f"{label}: {words}" for label, words in notes if words]


def _examples(spec: Spec, logs: Sequence[Log], bench: Bench | None) -> list[str]:
    examples = {"spec": list(spec.examples), "bench": [] if bench is None else list(bench.examples)}
    for log in logs:
        for name, keys in log.metadata.get("examples", {}).items():
            examples[name] = list(dict.fromkeys([*examples.get(name, []), *keys.split(", ")]))
    words = examples_words(examples)
    return [words] if words else []


def _changed(controller: Controller | None) -> list[str]:
    words = "" if controller is None else changed_words(controller)
    return [f"{controller.name}: {words}"] if controller is not None and words else []


def _simulated_models(logs: Sequence[Log]) -> list[str]:
    records = [log.metadata.get("log", {}) for log in logs]
    notes = [
        words(f"the model {one.get('model', '')}", one[key])
        for one in records
        for key, words in (
            (KEY, bench_values_words),
            (TEMPERATURE, temperature_words),
            (PRESLIDING, presliding_words),
        )
        if key in one
    ]
    notes += [
        f"the model {one.get('model', '')}: {text}"
        for one in records
        for text in one.get(MISSING, "").splitlines()
    ]
    return list(dict.fromkeys(notes))


def _overspeed(evidence: Sequence[StreamEvidence], bench: Bench | None) -> list[str]:
    simulated = {one.name: one.stream for one in evidence if one.simulated}
    words = "" if bench is None else overspeed_of_streams(simulated, bench)
    return [words] if words else []


def _extrapolated(logs: Sequence[Log], controller: Controller | None) -> list[str]:
    """Return a warning for each log with positions far outside those in the model's logs.

    A simulated log states the positions of the model's logs; for a recorded log, the controller
    states them.
    """
    known = None if controller is None else controller.logged_positions
    notes = []
    for label, log in zip(log_labels(logs), logs, strict=True):
        record = log.metadata.get("log", {}).get(LOGGED)
        try:
            logged = known if record is None else from_text(record)
        except msgspec.MsgspecError as error:
            raise LogError(log.source, f"metadata log: {LOGGED}: {error}; simulate again") from None
        positions = _positions(log)
        if positions.size:
            low, high = float(positions.min()), float(positions.max())
            notes.append((label, extrapolated_words(logged, low, high, "positions")))
    return [f"{label}: {words}" for label, words in notes if words]


def _specified_judges(spec: Spec) -> dict[str, Judge]:
    return {name: make for name, make in JUDGES.items() if getattr(spec, name) is not None}


def _meets(spec: Spec, stream: tuple[StreamEvidence, tuple[HoldMetrics, ...]]) -> bool:
    judges = [
        make for key, make in _specified_judges(spec).items() if REQUIREMENTS[key].scope != "loop"
    ]
    margin, simulated = stream[0].modulus_margin, stream[0].simulated
    if (
        spec.modulus_margin is not None
        and simulated
        and (margin is None or margin < spec.modulus_margin)
    ):
        return False
    return bool(judges or simulated) and all(make(spec, (stream,), None).met for make in judges)


# key -> judge that does more than compare the worst hold or stream with the limit
SPECIAL: dict[str, Judge] = {
    "response_time_95_s": judge_response,
    "load_static_error": judge_load,
    "limit_cycle": judge_cycle,
    "modulus_margin": judge_margin,
    "drive_peak": judge_peak,
    "saturation_time_s": judge_saturation,
    "rest": judge_rest,
    **{key: judge_tracking(key) for key in ("tracking_error_peak", "tracking_error_rms")},
}
# specification key -> judge, in the order of the specification
JUDGES: dict[str, Judge] = {
    key: SPECIAL.get(key) or judge_of(metric) for key, metric in REQUIREMENTS.items()
}
