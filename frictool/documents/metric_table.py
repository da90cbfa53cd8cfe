"""Table of the metrics of a verdict, and of the keys of a specification that limit them.

The following are generated from the records of this table: the fields of `spec.yaml`; the units,
headings and definitions of a report; docs/metrics.md; and the columns of a campaign. The columns of
a page are in the order of the records; the keys of a specification are in the order of `rank`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec

from frictool.documents.bench import PositiveNumber
from frictool.documents.quantity import (
    SI_UNITS,
    NonNegativeLength,
    PositiveLength,
    PositiveTime,
    positive,
    si_unit,
)

if TYPE_CHECKING:
    from frictool.documents.spec import Spec

# dimension of a metric that SI_UNITS lacks -> unit; {drive} stands for the unit of the drive
OTHER_UNITS = {
    "percent": "%",
    "count": "",
    "ratio": "",
    "drive": "{drive}",
    "drive squared": "{drive}^2",
}
NonNegative = Annotated[float, msgspec.Meta(ge=0)]
MOTION, DRIVE = "Motion", "Drive, load and rest"  # tables of the page


class Rest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Requirement that the axis is at rest after some seconds of constant reference.

    Motion within the sensor's step and a drive up to `drive` are allowed.

    - `after_s`: Time after which the axis must be at rest, counted from the start of the constant
      reference.
    - `drive`: Largest drive at rest [A | V].
    """

    # thesis 5.4.1
    after_s: PositiveNumber
    drive: NonNegative = 0.0


class Energy(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Limit of the drive's mean square over the first seconds of a step.

    - `window_s`: Duration after the step over which the mean is taken.
    - `limit`: Largest mean square of the drive [A^2 | V^2].
    """

    # the energy of table 5.3
    window_s: PositiveNumber
    limit: PositiveNumber


class Settling(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Limit of the time after a profile until the axis stays at its target.

    - `within`: Position error up to which the axis counts as settled.
    - `limit`: Longest time from the end of the profile until the error stays within `within`.
    """

    within: PositiveLength
    limit: PositiveTime


@dataclass(frozen=True, eq=False)
class Metric:
    """Metric of a hold, of a whole stream or of a closed loop, and the requirement that limits it.

    A hold is a phase of constant reference.

    - name: name in JSON, JUnit and tables of values
    - title: name in texts and on pages, heading of its column
    - dimension: key of SI_UNITS (documents/quantity.py) or OTHER_UNITS, which determines the unit
    - definition: text without a final full stop, for the page and docs/metrics.md
    - scope: measured object: a hold, a whole stream or a closed loop
    - compute: function of `frictool/metrics/`, as module.function. Its parameters have the names of
      properties of MeasuredPart (report/metric_samples.py). The function returns either a value, or
      two bounds of the value, or the reason why the value is unknown
    - needs: keys of NEEDS (report/metric_samples.py) without which the value is unknown
    - table: heading of the page's table that contains the metric
    - key: key of a specification that limits the metric or that the metric needs; "" if there is no
      such key
    - limit: type of the key's value: a number if the key's name contains the unit (`rise_time_s`),
      a quantity (`positive(dimension)`), or a record (`Energy`, `Settling`); None if another metric
      has the key
    - meaning: meaning of the key, for the schema
    - requirement: name of the requirement in a verdict, if it differs from `name`; the title of the
      requirement is derived from it
    - rank: position of the key in a specification; by default, the key is the last key

    Raises ValueError for an unknown dimension.
    """

    name: str
    title: str
    dimension: str
    definition: str
    scope: Literal["hold", "stream", "loop"] = "hold"
    compute: str = ""
    needs: tuple[str, ...] = ()
    table: str = DRIVE
    key: str = ""
    limit: Any = None
    meaning: str = ""
    requirement: str = ""
    rank: int = 100

    def __post_init__(self) -> None:
        check_known(self.name, "dimension", (self.dimension,), {*SI_UNITS, *OTHER_UNITS})

    def unit(self, spec: Spec) -> str:
        """Return the SI unit for the axis and drive of a specification; empty for a pure number."""
        if self.dimension in SI_UNITS:
            return si_unit(self.dimension, spec.axis)
        return OTHER_UNITS[self.dimension].format(drive=si_unit(spec.drive, spec.axis))

    @property
    def requirement_name(self) -> str:
        """Return the name of the requirement in a verdict."""
        return self.requirement or self.name


def check_known(metric: str, field: str, names: Iterable[str], allowed: Collection[str]) -> None:
    """Raise ValueError if one of `names` is not in `allowed`.

    `metric`, `field`: name of the metric and of its field, for the message.
    """
    for name in names:
        if name not in allowed:
            listed = ", ".join(sorted(allowed))
            raise ValueError(f"metric {metric}: {field} {name!r}; allowed: {listed}")


METRICS = (
    Metric(
        "response_time_95",
        "response 95 %",
        "time",
        "time from the step until the position enters a zone around its final value and stays in "
        "it until the end of the hold. The zone is 5 % of the amplitude to each side, and at least "
        "one sensor step. The time is infinite if the position leaves the zone in the last tenth "
        "of the hold, or if the final value misses the reference by more than half of the step",
        compute="response_time.response_time_95",
        needs=("step", "response_time"),
        table=MOTION,
        key="response_time_95_s",
        limit=PositiveNumber,
        meaning=(
            "Largest time from a step of the reference until the position stays near its final "
            "value, within 5 % of the step."
        ),
        rank=1,
    ),
    Metric(
        "rise_time",
        "rise 10-90 %",
        "time",
        "time between the first passages through 10 and 90 % of the distance from the position "
        "at the step to the final value, interpolated between samples. The time is infinite if the "
        "final value misses the reference by more than half of the step, and 0 if the distance "
        "is less than 1 % of the amplitude",
        compute="rise_time.rise_time",
        needs=("step", "response_time"),
        table=MOTION,
        key="rise_time_s",
        limit=PositiveNumber,
        meaning="Largest time from 10 % to 90 % of a step.",
        rank=2,
    ),
    Metric(
        "overshoot",
        "overshoot",
        "percent",
        "largest excess beyond the reference in the direction of the step, relative to the "
        "amplitude. An excess of at most one sensor step (rounding of a counter) is treated as 0",
        compute="overshoot.overshoot_percent",
        needs=("step",),
        table=MOTION,
        key="overshoot_percent",
        limit=NonNegative,
        meaning="Largest overshoot, relative to the step.",
        rank=3,
    ),
    Metric(
        "static_error",
        "static error",
        "position",
        "distance between reference and final value of every hold, even without a step; the "
        "largest distance if the axis still moves",
        compute="static_error.static_error",
        needs=("response_time",),
        table=MOTION,
        key="static_error",
        limit=positive("position"),
        meaning="Largest error at the end of a hold.",
        rank=4,
    ),
    Metric(
        "reversals",
        "reversals",
        "count",
        "number of turning points after the first entry into the 95 % zone. A turning point "
        "counts if the position then moves back by more than two sensor steps and by more than "
        "1 % of the amplitude",
        compute="reversals.reversals",
        needs=("step",),
        table=MOTION,
    ),
    Metric(
        "oscillations",
        "oscillations",
        "count",
        "half of the number of reversals, rounded up",
        compute="oscillations.oscillations",
        needs=("step",),
        table=MOTION,
        key="oscillations",
        limit=Annotated[int, msgspec.Meta(ge=0)],
        meaning="Largest number of oscillations after a step.",
        rank=6,
    ),
    Metric(
        "limit_cycle_amplitude",
        "limit cycle",
        "position",
        "half of the peak-to-peak value of a sustained oscillation over its last period; 0 "
        "without an oscillation, no value if the hold is undecided",
        compute="limit_cycle.limit_cycle_amplitude",
        table=MOTION,
        key="limit_cycle",
        limit=NonNegativeLength,
        meaning="Largest amplitude of a limit cycle: half of the peak-to-peak value.",
        requirement="limit_cycle",
        rank=7,
    ),
    Metric(
        "limit_cycle_period",
        "its period",
        "time",
        "mean time between turning points on the same side",
        compute="limit_cycle.limit_cycle_period",
        table=MOTION,
    ),
    Metric(
        "drive_peak",
        "peak drive",
        "drive",
        "the larger of two values: the largest absolute command, if the log has one, and the "
        "largest absolute measured drive minus its noise floor",
        compute="drive_peak.larger_peak",
        needs=("drive",),
    ),
    Metric(
        "drive_rms",
        "rms drive",
        "drive",
        "root mean square of the drive i including its noise, sqrt(sum i² dt/sum dt), where dt is "
        "the time from a sample to the next sample",
        compute="drive_rms.drive_rms",
        needs=("drive",),
    ),
    Metric(
        "energy",
        "energy",
        "drive squared",
        "mean square of the drive i over the time t_int after the step, (T_e/t_int) sum i² with "
        "the sample period T_e. t_int is energy.window_s of the specification; without this key "
        "it is response_time_95_s",
        compute="energy.energy",
        needs=("step", "drive", "energy_window"),
        key="energy",
        limit=Energy,
        meaning="Limit of the drive's mean square.",
        rank=13,
    ),
    Metric(
        "saturation_time",
        "time at limit",
        "time",
        "time for which the command is within 0.1 % of the drive's limit in the bench; without a "
        "command, time for which the measured drive is within 1 % of that limit, or within two "
        "standard deviations of its noise. A smaller limit due to the winding's voltage is "
        "ignored",
        compute="saturation_time.saturation_time",
        needs=("drive", "drive_limit"),
        key="saturation_time_s",
        limit=NonNegative,
        meaning="Longest time with the drive at its limit, in one hold.",
        rank=11,
    ),
    Metric(
        "load_static_error",
        "load's static error",
        "position",
        "static error of the mechanical position behind the backlash",
        compute="load_position_bounds.load_static_error",
        needs=("load_position", "response_time"),
        key="load_static_error",
        limit=positive("position"),
        meaning="Largest static error of the mechanical position behind the backlash.",
        rank=5,
    ),
    Metric(
        "load_overshoot",
        "load's overshoot",
        "percent",
        "overshoot of the mechanical position behind the backlash, with a sensor step of 0",
        compute="load_position_bounds.load_overshoot",
        needs=("step", "load_position"),
    ),
    Metric(
        "rest_motion",
        "motion at rest",
        "position",
        "peak-to-peak value of the position after the first rest.after_s seconds of the hold",
        compute="rest_motion.peak_to_peak",
        needs=("rest",),
        key="rest",
    ),
    Metric(
        "rest_drive",
        "drive at rest",
        "drive",
        "largest absolute command after the first rest.after_s seconds of the hold; without a "
        "command, largest absolute measured drive minus its noise floor",
        compute="drive_peak.rest_drive",
        needs=("rest", "drive"),
        key="rest",
        limit=Rest,
        meaning="Condition of rest.",
        requirement="rest",
        rank=12,
    ),
    Metric(
        "drive_peak",
        "peak drive",
        "drive",
        "as for a hold, over the whole log",
        scope="stream",
        compute="drive_peak.larger_peak",
        needs=("drive",),
        key="drive_peak",
        limit=positive("drive"),
        meaning="Largest magnitude of the drive.",
        rank=9,
    ),
    Metric(
        "drive_rms",
        "rms drive",
        "drive",
        "as for a hold, over the whole log",
        scope="stream",
        compute="drive_rms.drive_rms",
        needs=("drive",),
        key="drive_rms",
        limit=positive("drive"),
        meaning="Largest rms of the drive over a whole log.",
        rank=10,
    ),
    Metric(
        "saturation_time",
        "time at limit",
        "time",
        "as for a hold, over the whole log",
        scope="stream",
        compute="saturation_time.saturation_time",
        needs=("drive", "drive_limit"),
    ),
    Metric(
        "tracking_error_peak",
        "largest error",
        "position",
        "largest distance of the position from the reference, at rest or in motion. If the log "
        "has a profile, the profile replaces the reference",
        scope="stream",
        compute="tracking_error.tracking_error_peak",
        needs=("tracking",),
        key="tracking_error_peak",
        limit=positive("position"),
        meaning="Largest distance from a moving reference, or from the controller's profile.",
        rank=14,
    ),
    Metric(
        "tracking_error_rms",
        "rms error",
        "position",
        "rms distance of the position from the reference or the profile",
        scope="stream",
        compute="tracking_error.tracking_error_rms",
        needs=("tracking",),
        key="tracking_error_rms",
        limit=positive("position"),
        meaning="Largest rms distance from a moving reference, or from the controller's profile.",
        rank=15,
    ),
    Metric(
        "settling_after_profile",
        "settling after a profile",
        "time",
        "longest time from the end of a motion of the reference (or profile) until the error stays "
        "within settling_after_profile.within (at least one sensor step) up to the next motion. "
        "The time is infinite if the error is larger just before the next motion",
        scope="stream",
        compute="settling_after_profile.settling_after_profile",
        needs=("tracking", "settling"),
        key="settling_after_profile",
        limit=Settling,
        meaning="Limit of the time from the end of a profile until the axis stays at its target.",
        rank=16,
    ),
    Metric(
        "velocity_error_rms",
        "rms error of the speed used",
        "velocity",
        "rms difference between the speed that the controller used and the true speed, in "
        "simulated records",
        scope="stream",
        compute="velocity_error.velocity_error_rms",
        needs=("used_velocity",),
    ),
    Metric(
        "velocity_error_peak",
        "its largest",
        "velocity",
        "largest difference between the speed that the controller used and the true speed",
        scope="stream",
        compute="velocity_error.velocity_error_peak",
        needs=("used_velocity",),
    ),
    Metric(
        "modulus_margin",
        "modulus margin",
        "ratio",
        "smallest distance between the point -1 and the Nyquist curve of the sampled loop with the "
        "bench's delay",
        scope="loop",
        key="modulus_margin",
        limit=Annotated[float, msgspec.Meta(gt=0, lt=1)],
        meaning="Smallest distance of the loop's Nyquist curve from -1.",
        rank=8,
    ),
)
HOLD_METRICS = {metric.name: metric for metric in METRICS if metric.scope == "hold"}
STREAM_METRICS = {metric.name: metric for metric in METRICS if metric.scope == "stream"}

# key of a specification -> metric that it limits, in the order of the keys
REQUIREMENTS = {
    metric.key: metric
    for metric in sorted(METRICS, key=lambda metric: metric.rank)
    if metric.limit is not None
}

# name of a requirement -> its title in texts and on pages
_TITLES = {
    metric.requirement_name: metric.requirement.replace("_", " ") or metric.title
    for metric in REQUIREMENTS.values()
}


def requirement_title(name: str) -> str:
    """Return the title of a requirement for texts and pages.

    The title of an unknown requirement consists of the words of its name.

    >>> requirement_title("drive_peak")
    'peak drive'
    """
    return _TITLES.get(name) or name.replace("_", " ")
