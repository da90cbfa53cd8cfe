"""Table of all metrics: title, dimension and definition.

A report's JSON view, its page and the documentation show exactly the metrics of this table.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec

Dimension = Literal["time", "percent", "position", "velocity", "count", "drive", "drive squared"]


@dataclass(frozen=True)
class Metric:
    """Metric of a hold or a stream.

    `title`: column heading of the page. `definition`: text below the column.
    """

    name: str
    title: str
    dimension: Dimension
    definition: str

    def unit(self, spec: Spec) -> str:
        """Return the SI unit for the specification's kind of axis and drive; empty for a count."""
        if self.dimension in ("position", "velocity", "time"):
            return si_unit(self.dimension, spec.axis)
        drive = si_unit(spec.drive, spec.axis)
        return {"percent": "%", "count": "", "drive": drive, "drive squared": f"{drive}^2"}[
            self.dimension
        ]


_HOLD = (
    Metric(
        "response_time_95",
        "response 95 %",
        "time",
        "from the step until the position stays within 5 % of the step around its "
        "final value (mean of the last tenth of the hold)",
    ),
    Metric(
        "rise_time",
        "rise 10-90 %",
        "time",
        "from 10 to 90 % of the way from where the axis stood at the step to its final value",
    ),
    Metric(
        "overshoot",
        "overshoot",
        "percent",
        "beyond the reference in the direction of the step; up to one sensor step counts as none",
    ),
    Metric(
        "static_error", "static error", "position", "distance of the final value from the reference"
    ),
    Metric(
        "reversals",
        "reversals",
        "count",
        "turns of the motion after it has reached the 5 % zone, each back by more than "
        "two sensor steps and 1 % of the step",
    ),
    Metric("oscillations", "oscillations", "count", "half the reversals, rounded up"),
    Metric(
        "limit_cycle_amplitude",
        "limit cycle",
        "position",
        "half the peak-to-peak value of an oscillation that lasts beyond the first "
        "third of a hold; absent (0) only after 15 s",
    ),
    Metric("limit_cycle_period", "its period", "time", "mean time between its turns of one side"),
    Metric(
        "drive_peak",
        "peak drive",
        "drive",
        "of the command, or of the measured drive less its noise floor, whichever is larger",
    ),
    Metric(
        "drive_rms",
        "rms drive",
        "drive",
        "root mean square of the measured drive, of the command where none was measured",
    ),
    Metric(
        "energy",
        "energy",
        "drive squared",
        "(T_e/t_int) sum i² over [0, t_int] after the step: the mean square of the drive",
    ),
    Metric(
        "saturation_time",
        "at limit",
        "time",
        "time for which the command (or else the measured drive, within 1 %) is at the "
        "drive's limit",
    ),
    Metric(
        "load_static_error",
        "load's static error",
        "position",
        "of the mechanical position behind the backlash; from its bounds where the log "
        "has only the motor's",
    ),
    Metric(
        "load_overshoot",
        "load's overshoot",
        "percent",
        "of the mechanical position behind the backlash, beyond the reference",
    ),
    Metric("rest_motion", "motion at rest", "position", "peak to peak in the rest of a long hold"),
    Metric(
        "rest_drive",
        "drive at rest",
        "drive",
        "largest command, or measured drive less its noise floor, in the rest of a long hold",
    ),
)
_STREAM = (
    Metric("drive_peak", "peak drive", "drive", "over the whole record"),
    Metric("drive_rms", "rms drive", "drive", "over the whole record"),
    Metric("saturation_time", "at limit", "time", "over the whole record"),
    Metric(
        "tracking_error_peak",
        "largest error",
        "position",
        "largest distance of the position from the reference, moving or held",
    ),
    Metric(
        "tracking_error_rms",
        "rms error",
        "position",
        "root mean square of reference - position over the whole record",
    ),
    Metric(
        "velocity_error_rms",
        "rms error of the speed used",
        "velocity",
        "root mean square of what the controller took for the speed less the true one, "
        "over the whole of a simulated record",
    ),
    Metric("velocity_error_peak", "its largest", "velocity", "largest distance of the two"),
)
HOLD_METRICS = {metric.name: metric for metric in _HOLD}
STREAM_METRICS = {metric.name: metric for metric in _STREAM}
