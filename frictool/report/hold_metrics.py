"""Metrics of each hold of a stream.

Each metric of metric_table.py is in `values`, in `bounds`, or in `missing` with a reason.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from frictool.documents.spec import Spec
from frictool.metrics import rest_motion
from frictool.metrics.drive_peak import command_peak, drive_peak
from frictool.metrics.drive_rms import drive_rms
from frictool.metrics.energy import energy
from frictool.metrics.final_value import final_value
from frictool.metrics.limit_cycle import limit_cycle
from frictool.metrics.oscillations import oscillations
from frictool.metrics.overshoot import overshoot_percent
from frictool.metrics.reference_holds import Hold
from frictool.metrics.response_time import response_time_95
from frictool.metrics.reversals import reversals
from frictool.metrics.rise_time import rise_time
from frictool.metrics.saturation_time import commanded_saturation, measured_saturation
from frictool.metrics.static_error import static_error
from frictool.report.evidence import StreamEvidence
from frictool.typing import Vector

NO_STEP = "no step leads to this hold"
OF_A_STEP = (
    "response_time_95",
    "rise_time",
    "overshoot",
    "reversals",
    "oscillations",
    "energy",
    "load_overshoot",
)


@dataclass(frozen=True)
class HoldMetrics:
    """Metrics of one hold.

    `values`: metric -> value in SI (overshoot in %). `bounds`: metric -> (low, high). `missing`:
    metric -> reason. `number` counts holds from 1.
    """

    hold: Hold
    number: int
    start_s: float
    values: dict[str, float] = field(default_factory=dict)
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)

    @property
    def is_step(self) -> bool:
        """Return True if a step led to this hold."""
        return self.hold.origin is not None


def measure_holds(spec: Spec, evidence: StreamEvidence, whole: bool = True) -> list[HoldMetrics]:
    """Return the metrics of every hold.

    `whole`: include all metrics; else mainly those that the specification needs.
    """
    time = evidence.stream.time
    out = []
    for number, hold in enumerate(evidence.holds, start=1):
        measured = HoldMetrics(hold, number, float(time[hold.start]))
        _measure_position(spec, evidence, measured)
        if whole or spec.limit_cycle is not None:
            _measure_cycle(evidence, measured)
        if whole or spec.saturation_time_s is not None or spec.energy is not None:
            _measure_drive(spec, evidence, measured)
        if whole or spec.load_static_error is not None:
            _measure_load(spec, evidence, measured)
        _measure_rest(spec, evidence, measured)
        if hold.origin is None:
            measured.missing.update(dict.fromkeys(OF_A_STEP, NO_STEP))
        out.append(measured)
    return out


def cut_short(spec: Spec, time: Vector) -> str:
    """Return the reason why a hold is too short for a final value, or an empty text.

    `time` (n,): time of the hold [s].
    """
    held, asked = float(time[-1] - time[0]), spec.response_time_95_s
    return (
        f"held for {held:.3g} s only, less than the response time allowed"
        if asked is not None and held < asked
        else ""
    )


def _measure_position(spec: Spec, evidence: StreamEvidence, measured: HoldMetrics) -> None:
    hold = measured.hold
    time, position = hold.of(evidence.stream.time), hold.of(evidence.stream.signals["position"])
    cut = cut_short(spec, time)
    if cut:
        measured.missing.update(
            dict.fromkeys(("static_error", "response_time_95", "rise_time"), cut)
        )
    else:
        measured.values["static_error"] = static_error(position, hold.target)
    if hold.origin is None:
        return
    ends = (hold.origin, hold.target)
    if not cut:
        measured.values["response_time_95"] = response_time_95(
            time, position, *ends, evidence.resolution
        )
        measured.values["rise_time"] = rise_time(time, position, *ends)
    measured.values["overshoot"] = overshoot_percent(position, *ends, evidence.resolution)
    measured.values["reversals"] = float(reversals(position, *ends, evidence.resolution))
    measured.values["oscillations"] = float(oscillations(position, *ends, evidence.resolution))


def _measure_cycle(evidence: StreamEvidence, measured: HoldMetrics) -> None:
    hold = measured.hold
    cycle = limit_cycle(
        hold.of(evidence.stream.time),
        hold.of(evidence.stream.signals["position"]),
        evidence.resolution,
    )
    if cycle.amplitude is None:
        measured.missing.update(limit_cycle_amplitude=cycle.reason, limit_cycle_period=cycle.reason)
        return
    measured.values["limit_cycle_amplitude"] = cycle.amplitude
    if cycle.period is None:
        measured.missing["limit_cycle_period"] = "there is no limit cycle"
    else:
        measured.values["limit_cycle_period"] = cycle.period


def peak(evidence: StreamEvidence, part: slice) -> float:
    """Return the larger of the command's peak and the measured drive's peak less its noise floor.

    The stream needs at least one of them.
    """
    peaks = [] if evidence.command is None else [command_peak(evidence.command[part])]
    peaks += [] if evidence.measured is None else [drive_peak(evidence.measured[part])]
    return max(peaks)


def saturation(evidence: StreamEvidence, part: slice) -> float:
    """Return the time at the drive's limit [s].

    It is that of the command if present, else that of the measured drive. The stream needs a known
    limit and at least one of them.
    """
    assert evidence.drive_limit is not None
    time = evidence.stream.time[part]
    if evidence.command is not None:
        return commanded_saturation(time, evidence.command[part], evidence.drive_limit)
    assert evidence.measured is not None
    return measured_saturation(
        time, evidence.measured[part], evidence.drive_limit, evidence.drive_noise
    )


def _measure_drive(spec: Spec, evidence: StreamEvidence, measured: HoldMetrics) -> None:
    drive, part = evidence.drive, slice(measured.hold.start, measured.hold.stop)
    if drive is None:
        gap = no_drive(spec, evidence)
        measured.missing.update(
            dict.fromkeys(("drive_peak", "drive_rms", "energy", "saturation_time"), gap)
        )
        return
    time = evidence.stream.time[part]
    measured.values["drive_peak"] = peak(evidence, part)
    measured.values["drive_rms"] = drive_rms(time, drive[part])
    if evidence.drive_limit is None:
        measured.missing["saturation_time"] = evidence.gaps["drive_limit"]
    else:
        measured.values["saturation_time"] = saturation(evidence, part)
    window = energy_window(spec)
    if window is None:
        measured.missing["energy"] = (
            "the specification has neither energy.window_s nor response_time_95_s"
        )
    elif measured.is_step:
        value = energy(time, drive[part], window)
        if value is None:
            measured.missing["energy"] = f"held for less than the window of {window:g} s"
        else:
            measured.values["energy"] = value


def energy_window(spec: Spec) -> float | None:
    """Return t_int of table 5.3 [s], as specified or else the allowed response time."""
    return spec.energy.window_s if spec.energy is not None else spec.response_time_95_s


def no_drive(spec: Spec, evidence: StreamEvidence) -> str:
    """Return the reason why a stream has no drive."""
    return f"{evidence.gaps[spec.drive]} and no usable command"


def _measure_load(spec: Spec, evidence: StreamEvidence, measured: HoldMetrics) -> None:
    """Measure the load: exact if the log has its position, else as bounds."""
    hold, names = measured.hold, ("load_static_error", "load_overshoot")
    if evidence.load is None:
        measured.missing.update(dict.fromkeys(names, evidence.gaps["load_position"]))
        return
    low, high = (hold.of(load) for load in evidence.load)
    found: dict[str, tuple[float, float]] = {}
    cut = cut_short(spec, hold.of(evidence.stream.time))
    if cut:
        measured.missing["load_static_error"] = cut
    else:
        ends = (final_value(low), final_value(high))
        errors = [abs(hold.target - end) for end in ends]
        found["load_static_error"] = (
            0.0 if ends[0] <= hold.target <= ends[1] else min(errors),
            max(errors),
        )
    if hold.origin is not None:
        both = sorted(overshoot_percent(load, hold.origin, hold.target) for load in (low, high))
        found["load_overshoot"] = (both[0], both[1])
    for name, (least, most) in found.items():
        if evidence.load_is_bounded:
            measured.bounds[name] = (least, most)
        else:
            measured.values[name] = most


def _measure_rest(spec: Spec, evidence: StreamEvidence, measured: HoldMetrics) -> None:
    part = (
        None
        if spec.rest is None
        else rest_motion.late_samples(measured.hold.of(evidence.stream.time), spec.rest.after_s)
    )
    if spec.rest is None or part is None:
        reason = (
            "the specification asks for no rest"
            if spec.rest is None
            else f"not held beyond {spec.rest.after_s:g} s"
        )
        measured.missing.update(rest_motion=reason, rest_drive=reason)
        return
    measured.values["rest_motion"] = rest_motion.peak_to_peak(
        measured.hold.of(evidence.stream.signals["position"])[part]
    )
    if evidence.command is not None:
        measured.values["rest_drive"] = command_peak(measured.hold.of(evidence.command)[part])
    elif evidence.measured is not None:
        measured.values["rest_drive"] = drive_peak(measured.hold.of(evidence.measured)[part])
    else:
        measured.missing["rest_drive"] = no_drive(spec, evidence)


def finite_or_none(value: float) -> float | None:
    """Return None for an infinite value, for JSON."""
    return value if math.isfinite(value) else None
