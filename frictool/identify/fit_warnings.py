"""Warnings about an identified model.

A model is doubtful if it contradicts the bench, if the values or ranges in bench.yaml increase its
force error, or if it leaves much of the effort unexplained.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from frictool.documents.bench import Bench
from frictool.documents.name_list import listed
from frictool.documents.quantity import Quantity, si_unit
from frictool.identify.breakaway.breakaway import Breakaway
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit
from frictool.identify.interval_checks import contradicts
from frictool.identify.methods import DEFAULT, METHODS
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.slip_fit import stroke_samples

# force error or relative residual above which the program warns of noise or an incomplete model
DOUBTFUL_FORCE_ERROR = 0.2
# least ratio of the force error with the bench's values to that with the log's for a warning
WORSE = 1.5
# least ratio of the parameters to bench.yaml's values that shows a mistaken unit (mA for A), and
# largest factor by which the ratios of the parameters then differ from each other
OTHER_UNIT = 100.0
SPREAD = 30.0
LONGEST_VALUES = 60  # most characters that a warning uses for the replaced values


def contradiction_warnings(identified: Mapping[str, Interval], bench: Bench) -> list[str]:
    """Return a warning for each parameter whose interval does not overlap that in bench.yaml.

    If all these parameters are too large or too small by about the same large factor, the first
    warning says that the unit of the drive signal may be wrong.
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
    return _other_unit(ratios, bench) + out


def short_stroke_warnings(fit: SlidingFit, records: Sequence[MotionRecord]) -> list[str]:
    """Return a warning if the smoothing window is longer than half of a record's median stroke.

    A window then covers most of a stroke, with changes of the acceleration that smoothing distorts.
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
    """Return a warning if a load explains the breakaway over position better than friction."""
    law = None if ramp is None else ramp.by_position
    slope = None if law is None else law.load_slope()
    if slope is None:
        return []
    unit = si_unit("stiffness", bench.axis)
    terms = "spring" if bench.axis == "linear" else "spring] or [offset, gravity"
    return [
        "breakaway over position: it rises in one direction where it falls in the other, as with a "
        f"load of {slope:.3g} {unit}; declare load.terms: [offset, {terms}], and identify again"
    ]


def lag_warnings(bench: Bench) -> list[str]:
    """Return a warning if the bench states a lag of a voltage drive, which identify cannot see."""
    actuator = bench.actuator
    lag = actuator.loop_time_constant_s
    if actuator.drive != "voltage" or actuator.servo is not None or lag == 0.0:
        return []
    return [
        f"actuator.loop_time_constant_s {lag:.3g} s: the logged voltage is taken as the command; "
        "the intervals include a voltage measured behind this lag; if neither is meant, or L/R, "
        "write 0"
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


def replacement_warnings(
    free: SlidingFit, final: SlidingFit, identified: Mapping[str, Interval]
) -> list[str]:
    """Return a warning if the values or ranges in bench.yaml increase the force error.

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
        shown = "residual of the method's own equations"
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
