"""Evidence for the verdict: position, reference, drive and other data of each stream of the logs.

The logs' streams ──▶ StreamEvidence ──▶ HoldMetrics of each hold ──▶ Requirement, the worst value

A hold is a phase of constant reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import PurePath
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.errors import LogError
from frictool.logs.log import MAIN_TOPIC, Log, Stream
from frictool.logs.quality.time_base import encoder_step
from frictool.metrics.drive_noise import WhiteNoise, white_noise
from frictool.metrics.load_position_bounds import load_bounds
from frictool.metrics.reference_holds import Hold, find_holds
from frictool.presentation.decimation import finite_or_nan
from frictool.report.plotted_velocity import shown_velocity
from frictool.report.rig_facts import RigFacts
from frictool.typing import Vector

if TYPE_CHECKING:
    from frictool.report.judged_loop import JudgedLoop

UNKNOWN = RigFacts()
NO_CONTROLLER = "a log does not contain the margin; give --controller"


@dataclass(frozen=True)
class StreamEvidence:
    """Stream of a log with the data that a verdict needs.

    - source: label of the log
    - resolution: step of the position sensor, rad | m; 0 if unknown
    - holds: phases of constant reference
    - command, measured: command and measured drive, (n,), A | V; None if missing or not finite
    - gaps: reason for each missing item: a signal, the drive limit, holds, or steps
    - nominal: True for the nominal plant (`/axis`, or the only stream of its log), False for a
      plant variant
    - simulated: True for a stream of a simulated log
    - load: lower and upper bound of the load's position behind the backlash, (n,) each; both equal
      the logged load position if the log contains it; None if the load's position is unknown
    - drive_limit: limit of the drive, A | V; None if unknown
    - modulus_margin: modulus margin of the controller's loop with the stream's plant; None if
      unknown
    - margin_gap: reason why the margin is unknown; empty if it is known
    - beyond: text on differences between the stream's rig and the rig for which the controller was
      verified, and on doubts about the margins; empty if there are none
    - worst: True for the stream with the worst value of a requirement; figures show it in red
    """

    source: str
    stream: Stream
    resolution: float
    holds: tuple[Hold, ...]
    command: Vector | None
    measured: Vector | None
    gaps: dict[str, str]
    nominal: bool
    simulated: bool
    load: tuple[Vector, Vector] | None = None
    drive_limit: float | None = None
    modulus_margin: float | None = None
    margin_gap: str = ""
    beyond: str = ""
    worst: bool = False

    def has(self, signal: str) -> bool:
        """Return True if the stream has this signal, even if its values are not finite."""
        return signal in self.stream.signals

    def plotted(self, signal: str) -> Vector:
        """Return a signal for a plot, with NaN in place of infinite values; NaN leaves a gap."""
        return finite_or_nan(self.stream.signals[signal])

    @property
    def plant(self) -> str:
        """Return the name of the stream in the legend of a chart."""
        return self.source if self.nominal else f"{self.source} {self.stream.topic}"

    @property
    def drawing_order(self) -> int:
        """Return the rank of a stream in the order of drawing; later streams cover earlier ones.

        The rank is 0 for a variant and 1 for the nominal stream, plus 2 if the stream is `worst`.
        """
        return 2 * self.worst + self.nominal

    @property
    def drive(self) -> Vector | None:
        """Return the measured drive (n,), else the command; None if the log has neither."""
        return self.measured if self.measured is not None else self.command

    @property
    def load_is_bounded(self) -> bool:
        """Return True if only bounds of the load's position are known."""
        return self.load is not None and self.load[0] is not self.load[1]

    @cached_property
    def noise(self) -> WhiteNoise:
        """Return the white noise on the measured drive [A | V]."""
        return WhiteNoise(0.0, True) if self.measured is None else white_noise(self.measured)

    @cached_property
    def velocity(self) -> tuple[Vector, str] | None:
        """Return (velocity (n,) for plots, text on its source); None without a velocity."""
        return shown_velocity(self.stream, self.resolution)

    @cached_property
    def has_backlash(self) -> bool:
        """Return True if the load's position is known and differs from the sensor's position."""
        if self.load is None or not self.has("position"):
            return False
        apart = float(np.max(np.abs(self.load[1] - self.stream.signals["position"]), initial=0.0))
        return apart > 1.5 * self.resolution + 1e-9 * float(np.ptp(self.load[1]))

    @cached_property
    def sensor_error(self) -> Vector | None:
        """Return sensor position - true position (n,) [rad | m].

        Return None if the log lacks one of the positions, or if they agree within the resolution.
        """
        if not (self.has("position") and self.has("position_true")):
            return None
        error: Vector = self.plotted("position") - self.plotted("position_true")
        return (
            error
            if float(np.max(np.abs(error), initial=0.0))
            > 1.5 * self.resolution + 1e-9 * float(np.ptp(error))
            else None
        )

    @property
    def name(self) -> str:
        """Return the log's name and the stream's topic as text for messages."""
        return f"{self.source} {self.stream.topic}"


def gather_evidence(
    spec: Spec, logs: Sequence[Log], rig: RigFacts = UNKNOWN, loop: JudgedLoop | None = None
) -> list[StreamEvidence]:
    """Return the evidence from every axis stream of every log, in the order of the logs.

    - rig: facts of the bench, such as backlash and sensor step
    - loop: closed loop of the controller, for the modulus margins; None without a controller

    Raises LogError if a log has no stream or an empty stream, or if the unit of a position is wrong
    for the kind of axis in the specification.
    """
    gathered: list[StreamEvidence] = []
    for log, label in zip(logs, log_labels(logs), strict=True):
        if not log.axes:
            raise LogError(log.source, "has no stream of an axis, so that nothing can be judged")
        beyond = "" if loop is None else loop.beyond(log)
        played = rig.played(log)
        simulated = log.metadata.get("log", {}).get("kind") == "simulated"
        for stream in log.axes:
            margin, gap = (None, NO_CONTROLLER) if loop is None else loop.margin(log, stream.topic)
            nominal = stream.topic == MAIN_TOPIC or len(log.axes) == 1
            about = AboutStream(label, nominal, simulated, margin, gap, beyond)
            gathered.append(stream_evidence(spec, log.source, stream, played, about))
    return gathered


def log_labels(logs: Sequence[Log]) -> list[str]:
    """Return the base name of each log; a number is appended to names that occur several times."""
    names = [PurePath(log.source).name or log.source for log in logs]
    return [
        name if names.count(name) == 1 else f"{name} ({names[: k + 1].count(name)})"
        for k, name in enumerate(names)
    ]


class AboutStream(NamedTuple):
    """Facts on a stream that are not in its signals: label, origin and modulus margin."""

    label: str
    nominal: bool
    simulated: bool
    modulus_margin: float | None
    margin_gap: str
    beyond: str


def stream_evidence(
    spec: Spec, source: str, stream: Stream, rig: RigFacts, about: AboutStream
) -> StreamEvidence:
    """Return the evidence of one stream of the log `source`.

    Raises LogError if the stream is empty, or if the unit of a position is wrong for the kind of
    axis in the specification.
    """
    if stream.time.size == 0:
        raise LogError(source, f"stream {stream.topic} has no samples")
    for name in ("position", "reference"):
        unit = stream.units.get(name)
        expected = si_unit("position", spec.axis)
        if unit not in (None, "", expected):
            raise LogError(
                source,
                f"{name} of {stream.topic} is in {unit}; the specification describes a {spec.axis} "
                f"axis, which needs {expected}",
            )
    gaps: dict[str, str] = {}
    position, reference = _signal(stream, "position", gaps), _signal(stream, "reference", gaps)
    measured = _signal(stream, spec.drive, gaps)
    command = _signal(stream, "command", gaps)
    if stream.units.get("command") not in (None, "", si_unit(spec.drive, spec.axis)):
        command = None
    fault = stream.signals.get("controller_fault")
    # after a fault the drive is 0, so that later samples do not test the controller
    if fault is not None and fault.any():
        begin = float(stream.time[int(np.argmax(fault != 0.0))])
        gaps["position"] = (
            f"the controller reports a fault at {begin:.6g} s, without a valid position; "
            "the drive is 0 from then on"
        )
        position = None
    seen = None if position is None else encoder_step(position)
    resolution = seen or rig.resolution
    holds: tuple[Hold, ...] = ()
    if position is not None and reference is not None:
        holds = find_holds(reference, position, resolution)
        gaps |= _without_steps(holds)
    load = _load(stream, position, rig, resolution, gaps)
    if rig.drive_limit is None:
        gaps["drive_limit"] = "the drive's limit is not known; give --bench or --controller"
    return StreamEvidence(
        about.label,
        stream,
        resolution,
        holds,
        command,
        measured,
        gaps,
        about.nominal,
        about.simulated,
        load,
        rig.drive_limit,
        about.modulus_margin,
        about.margin_gap,
        about.beyond,
    )


def _load(
    stream: Stream, position: Vector | None, rig: RigFacts, resolution: float, gaps: dict[str, str]
) -> tuple[Vector, Vector] | None:
    if "load_position" in stream.signals:
        load = _signal(stream, "load_position", gaps)
        return None if load is None else (load, load)
    if position is None or rig.backlash is None:
        gap = (
            "the bench gives no backlash"
            if rig.known
            else "the backlash is unknown without a bench (--bench or --controller)"
        )
        gaps["load_position"] = (
            gaps["position"] if position is None else f"the log has no load_position, and {gap}"
        )
        return None
    return load_bounds(position, rig.backlash, resolution + 0.5 * rig.backlash_unsure)


def _signal(stream: Stream, name: str, gaps: dict[str, str]) -> Vector | None:
    values = stream.signals.get(name)
    if values is None:
        gaps[name] = f"the log has no {name}"
    elif not np.isfinite(values).all():
        gaps[name] = f"{name} has values that are not finite"
        return None
    return values


def _without_steps(holds: tuple[Hold, ...]) -> dict[str, str]:
    if not holds:
        return {
            "hold": "the reference is never constant",
            "step": "the log has no step: its reference is smooth",
        }
    if all(hold.origin is None for hold in holds):
        return {"step": "the log has no step: its reference does not jump between holds"}
    return {}
