"""Metrics of a whole stream, the only ones for a smooth reference without holds."""

from __future__ import annotations

from frictool.documents.spec import Spec
from frictool.metrics.drive_rms import drive_rms
from frictool.metrics.tracking_error import tracking_error_peak, tracking_error_rms
from frictool.metrics.velocity_error import velocity_error_peak, velocity_error_rms
from frictool.report.evidence import StreamEvidence
from frictool.report.hold_metrics import no_drive, peak, saturation
from frictool.report.plotted_velocity import used_velocity

WHOLE = slice(None)
OF_THE_DRIVE = ("drive_peak", "drive_rms", "saturation_time")
OF_THE_SPEED = ("velocity_error_rms", "velocity_error_peak")
OF_THE_TRACK = ("tracking_error_peak", "tracking_error_rms")


def stream_metrics(spec: Spec, evidence: StreamEvidence) -> tuple[dict[str, float], dict[str, str]]:
    """Return the values of STREAM_METRICS in SI, and reasons for missing ones, by name."""
    values: dict[str, float] = {}
    missing: dict[str, str] = {}
    drive, signals = evidence.drive, evidence.stream.signals
    if drive is None:
        missing.update(dict.fromkeys(OF_THE_DRIVE, no_drive(spec, evidence)))
    else:
        values["drive_peak"] = peak(evidence, WHOLE)
        values["drive_rms"] = drive_rms(evidence.stream.time, drive)
        if evidence.drive_limit is None:
            missing["saturation_time"] = evidence.gaps["drive_limit"]
        else:
            values["saturation_time"] = saturation(evidence, WHOLE)
    gaps = [evidence.gaps[name] for name in ("position", "reference") if name in evidence.gaps]
    if gaps:
        missing.update(dict.fromkeys(OF_THE_TRACK, gaps[0]))
    else:
        values["tracking_error_peak"] = tracking_error_peak(
            signals["reference"], signals["position"]
        )
        values["tracking_error_rms"] = tracking_error_rms(signals["reference"], signals["position"])
    used = used_velocity(evidence.stream, evidence.simulated)
    if isinstance(used, str):
        missing.update(dict.fromkeys(OF_THE_SPEED, used))
    else:
        values["velocity_error_rms"] = velocity_error_rms(*used)
        values["velocity_error_peak"] = velocity_error_peak(*used)
    return values, missing
