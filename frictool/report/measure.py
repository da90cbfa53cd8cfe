"""The metrics of each hold of a stream, and why one that is asked for cannot be had."""

from __future__ import annotations

from dataclasses import dataclass, field

from frictool.documents.spec import Spec
from frictool.logs.log import Vector
from frictool.metrics import rest
from frictool.metrics.drive_peak import command_peak, drive_peak
from frictool.metrics.energy import energy
from frictool.metrics.holds import Hold
from frictool.metrics.oscillations import oscillations
from frictool.metrics.overshoot import overshoot_percent
from frictool.metrics.response_time import response_time_95
from frictool.metrics.static_error import static_error
from frictool.report.evidence import Evidence


@dataclass(frozen=True)
class Measured:
    """One hold: metric -> value in SI (overshoot in %), and metric -> reason where it has none. `number` counts holds from 1."""

    hold: Hold
    number: int
    start_s: float
    values: dict[str, float] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)

    @property
    def is_step(self) -> bool:
        """Whether a step led to this hold."""
        return self.hold.origin is not None


def measure(spec: Spec, evidence: Evidence) -> list[Measured]:
    """The metrics of every hold; the first three and the oscillations whether or not they are specified."""
    time = evidence.stream.time
    out = []
    for number, hold in enumerate(evidence.holds, start=1):
        measured = Measured(hold, number, float(time[hold.start]))
        _measure_step(spec, evidence, measured)
        _measure_rest(spec, evidence, measured)
        out.append(measured)
    return out


def _measure_step(spec: Spec, evidence: Evidence, measured: Measured) -> None:
    hold = measured.hold
    time, position = hold.of(evidence.stream.time), hold.of(evidence.stream.signals["position"])
    held, asked = float(time[-1] - time[0]), spec.response_time_95_s
    cut = f"held for {held:.3g} s only, less than the response time allowed" if asked is not None and held < asked else ""
    if cut:
        measured.missing["static_error"] = cut
    else:
        measured.values["static_error"] = static_error(position, hold.target)
    if hold.origin is None:
        return
    step = (hold.origin, hold.target, evidence.resolution)
    if cut:
        measured.missing["response_time_95"] = cut
    else:
        measured.values["response_time_95"] = response_time_95(time, position, *step)
    measured.values["overshoot"] = overshoot_percent(position, *step)
    measured.values["oscillations"] = float(oscillations(position, *step))
    _measure_energy(spec, evidence, measured, time)


def _measure_energy(spec: Spec, evidence: Evidence, measured: Measured, time: Vector) -> None:
    drive = evidence.measured if evidence.measured is not None else evidence.command
    if spec.energy is None or drive is None:
        return
    value = energy(time, measured.hold.of(drive), spec.energy.window_s)
    if value is None:
        measured.missing["energy"] = f"held for less than the window of {spec.energy.window_s:g} s"
    else:
        measured.values["energy"] = value


def _measure_rest(spec: Spec, evidence: Evidence, measured: Measured) -> None:
    if spec.rest is None:
        return
    part = rest.remainder(measured.hold.of(evidence.stream.time), spec.rest.after_s)
    if part is None:
        return
    measured.values["rest_motion"] = rest.motion(measured.hold.of(evidence.stream.signals["position"])[part])
    if evidence.command is not None:
        measured.values["rest_drive"] = command_peak(measured.hold.of(evidence.command)[part])
    elif evidence.measured is not None:
        measured.values["rest_drive"] = drive_peak(measured.hold.of(evidence.measured)[part])
