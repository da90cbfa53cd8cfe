"""Samples of a hold or of a whole stream, and the metrics that are computed from them.

A hold is a phase of constant reference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from inspect import signature
from typing import Any

from frictool.documents.metric_table import Metric, check_known
from frictool.documents.spec import Spec
from frictool.metrics.limit_cycle import LimitCycle, limit_cycle
from frictool.metrics.reference_holds import Hold
from frictool.metrics.rest_motion import late_samples
from frictool.report.evidence import StreamEvidence
from frictool.report.plotted_velocity import used_velocity

NO_STEP = "this hold does not begin with a step"
MetricResult = float | tuple[float, float] | str
_MetricParts = tuple[
    Sequence[Callable[[Any], str]], Callable[..., MetricResult], Sequence[Callable[[Any], Any]]
]


@dataclass(frozen=True)
class MeasuredPart:
    """Samples of a stream for which metrics are computed.

    These are the samples of `hold` (phase of constant reference) or, if `hold` is None, all
    samples.
    """

    spec: Spec
    evidence: StreamEvidence
    hold: Hold | None = None

    def of(self, signal: Any) -> Any:
        """Return the samples of a signal (n,) in this part of the stream; None without a signal."""
        return signal if signal is None or self.hold is None else self.hold.of(signal)

    def signal(self, name: str) -> Any:
        """Return the samples of the signal `name` in this part of the stream."""
        return self.of(self.evidence.stream.signals[name])

    def late(self, signal: Any) -> Any:
        """Return the samples of a signal in the slice `rest`; None without a signal."""
        return None if signal is None else self.of(signal)[self.rest]

    @cached_property
    def rest(self) -> slice | None:
        """Return the slice of samples in which the axis must be at rest, from `rest.after_s` on.

        The time is counted from the start of the hold. Return None if there are too few samples.
        """
        return late_samples(self.of(self.evidence.stream.time), self.spec.rest.after_s)

    @cached_property
    def cycle(self) -> LimitCycle:
        """Return the result of the limit-cycle test of this part of the stream."""
        time = self.of(self.evidence.stream.time)
        return limit_cycle(time, self.signal("position"), self.evidence.resolution)


# Parameter of a metric's function -> value in SI. Signals are (n,) and begin at the step, or at the
# start of the stream. A parameter whose value can be absent needs a row in NEEDS as well.
ARGUMENTS: dict[str, Callable[[MeasuredPart], Any]] = {
    # time [s] of each sample, from the origin of the log's clock
    "time": lambda part: part.of(part.evidence.stream.time),
    "position": lambda part: part.signal("position"),
    "reference": lambda part: part.signal("reference"),
    # reference that the loop follows: the controller's profile, or the reference itself
    "tracked": lambda part: part.signal(tracked_signal(part.evidence)),
    # largest error of an axis that has settled after a profile
    "settling_band": lambda part: part.spec.settling_after_profile.within.value,
    # reference before the step; None if the hold does not begin with a step
    "origin": lambda part: part.hold and part.hold.origin,
    # reference of the hold; None for a whole stream
    "target": lambda part: part.hold and part.hold.target,
    # step of the position sensor; 0 if unknown
    "resolution": lambda part: part.evidence.resolution,
    # measured drive, or the command if no drive was measured
    "drive": lambda part: part.of(part.evidence.drive),
    # command and measured drive; None if not logged
    "command": lambda part: part.of(part.evidence.command),
    "measured": lambda part: part.of(part.evidence.measured),
    # limit of the drive in the bench, None if unknown
    "drive_limit": lambda part: part.evidence.drive_limit,
    # standard deviation of the measured drive's noise
    "drive_noise": lambda part: part.evidence.noise.deviation,
    # time t_int [s] over which the energy is integrated
    "energy_window": lambda part: energy_window(part.spec),
    # lowest and highest position behind the backlash, (2, n)
    "load": lambda part: tuple(map(part.of, part.evidence.load or ())),
    # result of the limit-cycle test of the hold
    "cycle": lambda part: part.cycle,
    # samples from rest.after_s after the start of the hold
    "rest_position": lambda part: part.late(part.evidence.stream.signals["position"]),
    "rest_command": lambda part: part.late(part.evidence.command),
    "rest_measured": lambda part: part.late(part.evidence.measured),
    # velocity that the controller used, and true velocity, of a simulated log
    "estimated": lambda part: part.signal("velocity_estimated"),
    "velocity": lambda part: part.signal("velocity"),
}

# Condition that a metric needs -> reason why the condition does not hold, or an empty text.
NEEDS: dict[str, Callable[[MeasuredPart], str]] = {
    # the hold begins with a step
    "step": lambda part: NO_STEP if part.hold is None or part.hold.origin is None else "",
    # the hold is at least as long as the allowed response time, if there is one
    "response_time": lambda part: _cut_short(part),
    # the log has a measured drive or a command
    "drive": lambda part: no_drive(part.spec, part.evidence) if part.evidence.drive is None else "",
    # the limit of the drive is known
    "drive_limit": lambda part: part.evidence.gaps.get("drive_limit", ""),
    # the specification gives t_int
    "energy_window": lambda part: (
        "the specification has neither energy.window_s nor response_time_95_s"
        if energy_window(part.spec) is None
        else ""
    ),
    # the position behind the backlash is known, at least within bounds
    "load_position": lambda part: (
        part.evidence.gaps["load_position"] if part.evidence.load is None else ""
    ),
    # the specification has `rest`, and the hold is longer than rest.after_s
    "rest": lambda part: _no_rest(part),
    # position and reference are logged and finite
    "tracking": lambda part: next(
        (
            part.evidence.gaps[name]
            for name in ("position", "reference")
            if name in part.evidence.gaps
        ),
        "",
    ),
    # the specification says when an axis has settled after a profile
    "settling": lambda part: (
        "the specification has no settling_after_profile"
        if part.spec.settling_after_profile is None
        else ""
    ),
    # a simulated log has the velocity that the controller used
    "used_velocity": lambda part: (
        found
        if isinstance(found := used_velocity(part.evidence.stream, part.evidence.simulated), str)
        else ""
    ),
}


def measure(metric: Metric, part: MeasuredPart) -> MetricResult:
    """Return a metric's value in SI (ratios in %), its bounds, or the reason why it is unknown."""
    needs, function, arguments = _parts_of(metric)
    for reason_of in needs:
        if reason := reason_of(part):
            return reason
    return function(*[value_of(part) for value_of in arguments])


@cache
def _parts_of(metric: Metric) -> _MetricParts:
    function, parameters = function_of(metric)
    needs = tuple(NEEDS[need] for need in metric.needs)
    return needs, function, tuple(ARGUMENTS[name] for name in parameters)


@cache
def function_of(metric: Metric) -> tuple[Callable[..., Any], tuple[str, ...]]:
    """Return the function that computes a metric, and the names of the function's parameters.

    Raises ValueError if the module, the function or a parameter is unknown.
    """
    check_known(metric.name, "need", metric.needs, NEEDS)
    module, _, name = metric.compute.partition(".")
    try:
        function = getattr(import_module(f"frictool.metrics.{module}"), name)
    except (ImportError, AttributeError) as error:
        raise ValueError(f"metric {metric.name}: compute {metric.compute!r}: {error}") from None
    parameters = tuple(signature(function).parameters)
    check_known(metric.name, "parameter", parameters, ARGUMENTS)
    return function, parameters


def energy_window(spec: Spec) -> float | None:
    """Return the time t_int [s] over which the energy is computed.

    The time is `window_s` of the specification or, without that key, the allowed response time. The
    result is None if the specification has neither.
    """
    window: float | None = spec.response_time_95_s if spec.energy is None else spec.energy.window_s
    return window


def tracked_signal(evidence: StreamEvidence) -> str:
    """Return the name of the signal that the position should track: reference or profile."""
    return "profile" if evidence.has("profile") else "reference"


def no_drive(spec: Spec, evidence: StreamEvidence) -> str:
    """Return the reason why a stream has no drive."""
    return f"{evidence.gaps[spec.drive]} and no usable command"


def _cut_short(part: MeasuredPart) -> str:
    time = part.of(part.evidence.stream.time)
    allowed = part.spec.response_time_95_s
    duration = float(time[-1] - time[0])
    return (
        f"held for {duration:.3g} s only, less than the allowed response time"
        if allowed is not None and duration < allowed
        else ""
    )


def _no_rest(part: MeasuredPart) -> str:
    if part.spec.rest is None:
        return "the specification has no rest requirement"
    return f"hold shorter than {part.spec.rest.after_s:g} s" if part.rest is None else ""
