"""Warnings about an identified model.

A model is doubtful if it contradicts the bench, if values from bench.yaml in place of fitted values
increase the force error, or if it leaves much of the effort unexplained.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import msgspec
import numpy as np

from frictool.adapters.axis_model import load_law
from frictool.documents.bench import Bench
from frictool.documents.logged_positions import leaves
from frictool.documents.name_list import listed
from frictool.documents.quantity import Quantity, Span, drive_dimension, si_unit
from frictool.identify.breakaway.breakaway import Breakaway
from frictool.identify.breakaway.onset_friction import lower_group
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit
from frictool.identify.interval_checks import contradicts
from frictool.identify.methods import DEFAULT, METHODS
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.slip_fit import stroke_samples

# force error or relative residual above which the program warns of noise or an incomplete model
DOUBTFUL_FORCE_ERROR = 0.2
# a warning is given if the force error with the bench's values exceeds this multiple of the force
# error with the log's values
WORSE = 1.5
# least ratio of the identified values to the values in bench.yaml (or its inverse) that suggests a
# mistaken unit (mA for A); largest quotient of two such ratios if the unit is mistaken
OTHER_UNIT = 100.0
SPREAD = 30.0
# a gear ratio missing in position and effort scales each parameter by this power of the ratio
GEARED = {"inertia": 2.0, "viscous": 2.0, "coulomb": 1.0}
MOST_OF_TRAVEL = 0.5  # least share of the travel for ramps that represent the whole travel
GRID_POINTS = 101  # positions at which the slope of the load is evaluated
LONGEST_VALUES = 60  # most characters that a warning uses for the replaced values


def contradiction_warnings(identified: Mapping[str, Interval], bench: Bench) -> list[str]:
    """Return a warning for each parameter whose interval does not overlap the bench's range.

    The first warning states a common cause, if there is one. If all these parameters are too large
    or too small by about the same large factor, the unit of the drive signal may be wrong. If one
    factor explains the contradictions of inertia, viscous and Coulomb friction, the drive constant
    or a gear ratio may be wrong.
    """
    out = []
    ratios = dict[str, float]()
    for name, interval in identified.items():
        known: Quantity | None = getattr(bench.mechanics, name, None)
        if known is not None and contradicts(interval, known):
            shown = (
                f"the log's interval [{interval.low:.4g}, {interval.high:.4g}] lies wholly "
                "outside the bench's"
            )
            out.append(
                f"{name}: {shown} [{known.low:.4g}, {known.high:.4g}]; the log's value is "
                "used; correct the bench, or leave out logs of another rig"
            )
            if name != "offset" and known.value * interval.value > 0.0:
                ratios[name] = interval.value / known.value
    return (_other_unit(ratios, bench) or _common_factor(identified, bench)) + out


def short_stroke_warnings(fit: SlidingFit, records: Sequence[MotionRecord]) -> list[str]:
    """Return a warning if the smoothing window is longer than half of a record's median stroke.

    Such a window smooths away changes of the acceleration within a stroke.
    """
    window = fit.details.get("window", 0)
    length = min((size for one in records if (size := stroke_samples(one))), default=math.inf)
    if 2 * window <= length:
        return []
    return [
        f"strokes of {length:.0f} samples are shorter than two smoothing windows ({window} samples "
        "each): the intervals may be too narrow; sample faster, or record longer strokes"
    ]


def load_warnings(ramp: Breakaway | None, bench: Bench) -> list[str]:
    """Return a warning if a load explains the ramps no worse than friction over position does."""
    if ramp is None or ramp.load_slope is None:
        return []
    unit = si_unit("stiffness", bench.axis)
    terms = "spring" if bench.axis == "linear" else "spring] or [offset, gravity"
    return [
        f"breakaway over position: a load of {ramp.load_slope:.3g} {unit} explains these ramps "
        f"equally well; declare load.terms: [offset, {terms}], or add a log of sliding"
    ]


def asymmetry_warnings(ramp: Breakaway | None, fit: SlidingFit | None, bench: Bench) -> list[str]:
    """Return a warning if the breakaway differs between directions, but friction in slip does not.

    The cause may be an offset that differs between the logs of ramps and of sliding.
    """
    law = None if ramp is None else ramp.by_position
    backward = None if fit is None or fit.laws is None else fit.laws.backward
    if law is None or law.common or (backward is not None and backward.coulomb is not None):
        return []
    if law.forward.low <= law.backward.high and law.backward.low <= law.forward.high:
        return []
    unit = si_unit("effort", bench.axis)
    half = 0.5 * abs(law.forward.value - law.backward.value)
    return [
        f"breakaway: forward {law.forward.value:.3g}, backward {law.backward.value:.3g} {unit}: "
        f"friction differs, or the offset differs by {half:.2g} {unit} between ramps and strokes; "
        "log both without restart"
    ]


def rejected_onset_warnings(ramp: Breakaway | None) -> list[str]:
    """Return a warning if motions in the ramps were left out, because they are not breakaways."""
    if ramp is None:
        return []
    warnings = []
    if ramp.rejected:
        warnings.append(
            f"breakaway: {ramp.rejected} motions that begin at efforts far below Coulomb friction "
            "are left out; look for backlash, or an elastic drive train"
        )
    if ramp.after_reversals:
        warnings.append(
            f"breakaway: {ramp.after_reversals} onsets directly after reversals are left out: they "
            "need far less effort than later ones; if there is backlash, state mechanics.backlash"
        )
    return warnings


def reversal_notes(ramp: Breakaway | None, bench: Bench) -> tuple[str, ...]:
    """Return a note if most breakaways may be inside a backlash that the bench does not state."""
    if ramp is None or bench.mechanics.backlash is not None:
        return ()
    if 2 * ramp.reversed_onsets <= ramp.onsets:
        return ()
    return (
        f"{ramp.reversed_onsets} of {ramp.onsets} breakaways directly follow a reversal; with "
        "backlash, these show only the motor: ramp several times in each direction, or state "
        "mechanics.backlash",
    )


def mixed_onset_warnings(ramp: Breakaway | None, bench: Bench) -> list[str]:
    """Return a warning for each direction whose mean breakaway mixes two groups of onsets."""
    if ramp is None or ramp.by_position is not None or ramp.rising is not None:
        return []
    unit = si_unit("effort", bench.axis)
    warnings = []
    for side, way in (("forward", 1.0), ("backward", -1.0)):
        friction = ramp.friction[ramp.direction == way]
        low = lower_group(friction, ramp.position[ramp.direction == way], math.inf)
        if np.any(low) and float(np.mean(friction[~low])) > ramp.interval.high:
            warnings.append(
                f"breakaway {side}: {np.sum(low)} of {low.size} onsets need at most "
                f"{np.max(friction[low]):.3g} {unit}, the others at least "
                f"{np.min(friction[~low]):.3g}; check the ramps for a second cause (backlash?)"
            )
    return warnings


def cover_travel(ramp: Breakaway, records: Sequence[MotionRecord]) -> bool:
    """Return whether the ramps cover at least MOST_OF_TRAVEL of the travel of the records."""
    travel = max((float(np.ptp(record.position)) for record in records), default=0.0)
    return float(np.ptp(ramp.position)) >= MOST_OF_TRAVEL * travel


def unstable_load_warnings(
    fit: SlidingFit, records: Sequence[MotionRecord], bench: Bench
) -> list[str]:
    """Return a warning if the sum of spring and gravity falls at all positions of the logs."""
    load = None if fit.laws is None else fit.laws.load
    logged = logged_positions(records, bench)
    if load is None or logged is None:
        return []
    smooth = msgspec.structs.replace(load, ripple=None, harmonics=())
    slope = np.diff(load_law(smooth).at(np.linspace(logged.low, logged.high, GRID_POINTS)))
    if not np.all(slope < 0.0):
        return []
    mean = float(np.sum(slope)) / (logged.high - logged.low)
    unit = si_unit("stiffness", bench.axis)
    return [
        f"the load falls by {-mean:.3g} {unit} at all logged positions, as at the top of an "
        "inverted pendulum; if the axis is no pendulum, record longer strokes, or declare "
        "load.terms: [offset]"
    ]


def extrapolated_spring_warnings(fit: SlidingFit, logged: Span | None, bench: Bench) -> list[str]:
    """Return a warning if a spring is extrapolated over much of the bench's travel.

    `logged` contains the positions of the logs. Beyond these positions, a spring may become
    stiffer, whereas gravity and ripples are known functions of the position.
    """
    load = None if fit.laws is None else fit.laws.load
    travel = bench.mechanics.travel
    if load is None or load.stiffness is None or travel is None or logged is None:
        return []
    if not leaves(logged, travel.low, travel.high):
        return []
    unit = logged.unit
    return [
        f"spring: the logs cover {logged.low:.3g} to {logged.high:.3g} {unit} of the travel, "
        f"{travel.low:.3g} to {travel.high:.3g} {unit}; elsewhere, the load is extrapolated; "
        "record strokes there"
    ]


def logged_positions(records: Sequence[MotionRecord], bench: Bench) -> Span | None:
    """Return the range of the measured positions of all records; None if there are none."""
    positions = [one.position for one in records if one.velocity is None]
    if not positions:
        return None
    low = min(float(one.min()) for one in positions)
    high = max(float(one.max()) for one in positions)
    return Span(low, high, si_unit("position", bench.axis))


def local_ramp_warnings(
    ramp: Breakaway | None, fit: SlidingFit | None, records: Sequence[MotionRecord], bench: Bench
) -> list[str]:
    """Return a warning if the breakaway is known at the positions of the ramps only.

    The warning is given if the ramps cover less than MOST_OF_TRAVEL of the travel of the logs of
    sliding. If the breakaway is constant, these logs must also show friction or a load over
    position that the model lacks. A ripple causes no warning; it widens the interval of the
    breakaway.
    """
    if ramp is None or fit is None or cover_travel(ramp, records):
        return []
    low, high = float(ramp.position.min()), float(ramp.position.max())
    length, unit = si_unit("position", bench.axis), si_unit("effort", bench.axis)
    if ramp.by_position is not None:
        return [
            f"friction over position: the ramps cover {low:.3g} to {high:.3g} {length} only, less "
            "than half of the strokes' range; no friction map is fitted; record ramps over the "
            "travel"
        ]
    missing = [
        one
        for one in fit.explanations
        if one.name == "friction_over_position"
        or (one.state == "left" and one.name in ("spring", "gravity"))
    ]
    if not missing:
        return []
    return [
        f"breakaway: measured from {low:.3g} to {high:.3g} {length} only, but the logs of sliding "
        f"show {missing[0].what} ({missing[0].effort:.2g} {unit} rms); record ramps over the travel"
    ]


def _other_unit(ratios: Mapping[str, float], bench: Bench) -> list[str]:
    if len(ratios) < 2:
        return []
    low, high = min(ratios.values()), max(ratios.values())
    if high > SPREAD * low or 1.0 / OTHER_UNIT < math.sqrt(low * high) < OTHER_UNIT:
        return []
    factor = f"{low:.2g} to {high:.2g} times the bench's values"
    drive = bench.actuator.drive
    unit = si_unit(drive, bench.axis)
    return [
        f"{', '.join(ratios)} are {factor}: check the unit in columns.{drive} (m{unit} or {unit}), "
        "and actuator.constant"
    ]


def _common_factor(identified: Mapping[str, Interval], bench: Bench) -> list[str]:
    if not all(
        name in identified and contradicts(identified[name], getattr(bench.mechanics, name))
        for name in GEARED
    ):
        return []
    names = listed(list(GEARED))
    factor = _factor(identified, bench, dict.fromkeys(GEARED, 1.0))
    if factor is not None:
        drive, constant = bench.actuator.drive, bench.actuator.constant.value
        unit = si_unit(drive_dimension(drive, constant=True), bench.axis)
        return [
            f"{names} are all {factor:.3g} times the bench's values: actuator.constant is probably "
            f"{constant / factor:.3g} {unit} (found: {constant:.3g}), or columns.{drive} is wrong"
        ]
    ratio = _factor(identified, bench, GEARED)
    if ratio is None:
        return []
    return [
        f"{names} differ from the bench's values by a gear ratio of {max(ratio, 1 / ratio):.3g} "
        "(inertia and viscous by its square): refer position, drive and bench to the same shaft"
    ]


def _factor(
    identified: Mapping[str, Interval], bench: Bench, powers: Mapping[str, float]
) -> float | None:
    """Return the factor that explains the contradictions of all parameters, or None.

    powers: exponent for each parameter. For every parameter, factor^exponent times a value in the
    range of bench.yaml lies in the identified interval.
    """
    low, high, logarithm = 0.0, math.inf, 0.0
    for name, power in powers.items():
        interval: Interval = identified[name]
        known: Quantity = getattr(bench.mechanics, name)
        least, most = known.interval
        if interval.value <= 0.0 or known.value <= 0.0:
            return None
        low = max(low, (max(interval.low, 0.0) / most) ** (1.0 / power))
        if least > 0.0:
            high = min(high, (interval.high / least) ** (1.0 / power))
        logarithm += math.log(interval.value / known.value) / (power * len(powers))
    return None if low > high else min(max(math.exp(logarithm), low), high)


def replacement_warnings(
    free: SlidingFit, final: SlidingFit, identified: Mapping[str, Interval]
) -> list[str]:
    """Return a warning if bench values in place of fitted values increase the force error.

    - free: fit in which no parameter was fixed
    - final: fit of the model, in which refused parameters have values within the ranges in
      bench.yaml
    - identified: identified parameters of the model
    """
    replaced = [name for name in SLIDING if name in free.parameters and name not in identified]
    if (
        not replaced
        or not free.force_error
        or final.force_error is None
        or final.force_error <= WORSE * free.force_error
    ):
        return []
    values = listed(
        [f"{name} [{(one := free.parameters[name]).low:.4g}, {one.high:.4g}]" for name in replaced],
        LONGEST_VALUES,
    )
    return [
        f"values within the bench's ranges replace {values}, and raise the force error from "
        f"{100 * free.force_error:.3g} % to {100 * final.force_error:.3g} %; correct the bench, or "
        "record another log"
    ]


def doubt_warnings(fit: SlidingFit, method: str) -> list[str]:
    """Return a warning if the model or the method leaves much of the effort unexplained."""
    shown = "force error"
    left = fit.force_error or 0.0
    if left <= DOUBTFUL_FORCE_ERROR:
        shown = "residual of the method's equations"
        left = fit.residual
    if left <= DOUBTFUL_FORCE_ERROR:
        return []
    advice = (
        "run frictool validate"
        if method == DEFAULT
        else "run frictool validate, or use --method auto"
    )
    hidden = "; the intervals do not include this error" if METHODS[method].comparison else ""
    return [
        f"{shown} {100 * left:.3g} %, above {100 * DOUBTFUL_FORCE_ERROR:g} %: the effort is noisy, "
        f"or the model lacks an effect of the axis{hidden}; {advice}"
    ]
