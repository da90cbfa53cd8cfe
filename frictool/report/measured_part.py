"""Samples of a stream, or of one hold, and the metrics that are computed from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from inspect import signature
from typing import Any

from frictool.documents.metric_table import Metric
from frictool.documents.spec import Spec
from frictool.metrics.limit_cycle import LimitCycle, limit_cycle
from frictool.metrics.reference_holds import Hold
from frictool.metrics.rest_motion import late_samples
from frictool.report.evidence import StreamEvidence
from frictool.report.plotted_velocity import used_velocity

NO_STEP = "no step leads to this hold"
MetricResult = float | tuple[float, float] | str


@dataclass(frozen=True)
class MeasuredPart:
    """Part of a stream: one hold, or the whole stream if `hold` is None."""

    spec: Spec
    evidence: StreamEvidence
    hold: Hold | None = None

    def of(self, signal: Any) -> Any:
        """Return the samples of a signal (n,) in this part; None if there is no signal."""
        return signal if signal is None or self.hold is None else self.hold.of(signal)

    def signal(self, name: str) -> Any:
        """Return the samples of a signal of the log in this part."""
        return self.of(self.evidence.stream.signals[name])

    def late(self, signal: Any) -> Any:
        """Return the samples of a signal (n,) from `rest.after_s` after the start of the hold."""
        return None if signal is None else self.of(signal)[self.rest]

    @cached_property
    def rest(self) -> slice | None:
        """Samples of the hold from `rest.after_s` on; None if there are too few."""
        return late_samples(self.of(self.evidence.stream.time), self.spec.rest.after_s)

    @cached_property
    def cycle(self) -> LimitCycle:
        """Result of the limit-cycle test of the hold."""
        time = self.of(self.evidence.stream.time)
        return limit_cycle(time, self.signal("position"), self.evidence.resolution)


# parameter of a metric's function -> its value; signals are (n,) in SI
ARGUMENTS: dict[str, Callable[[MeasuredPart], Any]] = {
    "time": lambda part: part.of(part.evidence.stream.time),
    "position": lambda part: part.signal("position"),
    "reference": lambda part: part.signal("reference"),
    "origin": lambda part: part.hold and part.hold.origin,
    "target": lambda part: part.hold and part.hold.target,
    "resolution": lambda part: part.evidence.resolution,
    "drive": lambda part: part.of(part.evidence.drive),
    "command": lambda part: part.of(part.evidence.command),
    "measured": lambda part: part.of(part.evidence.measured),
    "drive_limit": lambda part: part.evidence.drive_limit,
    "drive_noise": lambda part: part.evidence.drive_noise,
    "energy_window": lambda part: energy_window(part.spec),
    "load": lambda part: tuple(map(part.of, part.evidence.load or ())),
    "cycle": lambda part: part.cycle,
    "rest_position": lambda part: part.late(part.evidence.stream.signals["position"]),
    "rest_command": lambda part: part.late(part.evidence.command),
    "rest_measured": lambda part: part.late(part.evidence.measured),
    "estimated": lambda part: part.signal("velocity_estimated"),
    "velocity": lambda part: part.signal("velocity"),
}

# need of a metric -> reason why it is not met, or an empty text
NEEDS: dict[str, Callable[[MeasuredPart], str]] = {
    "step": lambda part: NO_STEP if part.hold is None or part.hold.origin is None else "",
    "response_time": lambda part: _cut_short(part),
    "drive": lambda part: no_drive(part.spec, part.evidence) if part.evidence.drive is None else "",
    "drive_limit": lambda part: part.evidence.gaps.get("drive_limit", ""),
    "energy_window": lambda part: (
        "the specification has neither energy.window_s nor response_time_95_s"
        if energy_window(part.spec) is None
        else ""
    ),
    "load_position": lambda part: (
        part.evidence.gaps["load_position"] if part.evidence.load is None else ""
    ),
    "rest": lambda part: _no_rest(part),
    "tracking": lambda part: next(
        (
            part.evidence.gaps[name]
            for name in ("position", "reference")
            if name in part.evidence.gaps
        ),
        "",
    ),
    "used_velocity": lambda part: (
        found
        if isinstance(found := used_velocity(part.evidence.stream, part.evidence.simulated), str)
        else ""
    ),
}


def measure(metric: Metric, part: MeasuredPart) -> MetricResult:
    """Return a metric's value in SI (a ratio in %), its two bounds, or the reason for neither."""
    for need in metric.needs:
        if reason := NEEDS[need](part):
            return reason
    function, parameters = _function(metric.compute)
    result: MetricResult = function(*(ARGUMENTS[name](part) for name in parameters))
    return result


@cache
def _function(compute: str) -> tuple[Callable[..., Any], tuple[str, ...]]:
    """Return a function of `frictool/metrics/` with the names of its parameters."""
    module, _, name = compute.partition(".")
    function = getattr(import_module(f"frictool.metrics.{module}"), name)
    return function, tuple(signature(function).parameters)


def energy_window(spec: Spec) -> float | None:
    """Return t_int of table 5.3 [s], as specified or else the allowed response time."""
    window: float | None = spec.response_time_95_s if spec.energy is None else spec.energy.window_s
    return window


def no_drive(spec: Spec, evidence: StreamEvidence) -> str:
    """Return the reason why a stream has no drive."""
    return f"{evidence.gaps[spec.drive]} and no usable command"


def _cut_short(part: MeasuredPart) -> str:
    """Return the reason why a hold is too short for a final value, or an empty text."""
    time = part.of(part.evidence.stream.time)
    allowed = part.spec.response_time_95_s
    duration = float(time[-1] - time[0])
    return (
        f"held for {duration:.3g} s only, less than the response time allowed"
        if allowed is not None and duration < allowed
        else ""
    )


def _no_rest(part: MeasuredPart) -> str:
    """Return the reason why a hold has no rest to measure, or an empty text."""
    if part.spec.rest is None:
        return "the specification has no rest requirement"
    return f"not held beyond {part.spec.rest.after_s:g} s" if part.rest is None else ""
