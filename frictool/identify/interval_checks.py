"""Checks that a parameter's interval is informative: physically possible and narrow enough."""

from __future__ import annotations

import math

from frictool.adapters.parameter_intervals import relative
from frictool.documents.quantity import Quantity
from frictool.identify.fit_result import Interval

POSITIVE = ("inertia", "breakaway", "stribeck_velocity")
NEVER_NEGATIVE = (*POSITIVE, "viscous", "coulomb")
LARGEST_FACTOR = 10.0  # largest ratio of the upper to the lower end of an interval


def too_vague(name: str, interval: Interval) -> str | None:
    """Return why the interval of a positive parameter is too wide, or None."""
    if name not in POSITIVE:
        return None
    if interval.low <= 0.0:
        return f"the log's interval [{interval.low:.4g}, {interval.high:.4g}] reaches zero"
    return _factor(interval) if interval.high > LARGEST_FACTOR * interval.low else None


def why_uninformative(name: str, interval: Interval, known: Quantity | None) -> str | None:
    """Return why an interval is not usable; None if the interval is usable.

    An interval is not usable if it is impossible, too wide, or no narrower than the interval in
    bench.yaml. An interval that does not overlap the interval in bench.yaml is usable even if it is
    wider, because the value in bench.yaml would not explain the log.

    Viscous and Coulomb friction can be 0. The part of their intervals above 0 is compared with the
    interval in bench.yaml. For friction, the ratio of the interval's ends is limited in two cases
    only: if the interval is wider than the interval in bench.yaml and does not overlap it, or if
    the bench states a value without an interval.
    """
    shown = f"[{interval.low:.4g}, {interval.high:.4g}]"
    if not interval.half_width < float("inf"):
        return "the motion does not repeat often enough to compute the uncertainty"
    if name in NEVER_NEGATIVE and interval.value < 0.0:
        hint = (
            "; check that position and drive have the same positive direction"
            if interval.high < 0.0
            else ""
        )
        return f"the log gives a negative value, {interval.value:.4g} in {shown}{hint}"
    vague = too_vague(name, interval)
    if vague is not None or known is None:
        return vague
    friction = name in NEVER_NEGATIVE and name not in POSITIVE
    if known.low is None or known.high is None:
        if friction and interval.high > LARGEST_FACTOR * max(interval.low, known.value):
            return (
                f"the upper end of the log's interval {shown} exceeds {LARGEST_FACTOR:g} times the "
                f"lower end and {LARGEST_FACTOR:g} times the bench's value, {known.value:.4g}"
            )
        return None
    low = max(interval.low, 0.0) if friction else interval.low
    if interval.high - low < known.high - known.low:
        return None
    if not contradicts(interval, known):
        return (
            f"the log's interval of {name} {shown} is no narrower than the bench's range "
            f"[{known.low:.4g}, {known.high:.4g}]"
        )
    return _factor(interval) if friction and interval.high > LARGEST_FACTOR * low else None


def _factor(interval: Interval) -> str:
    ratio = interval.high / interval.low if interval.low > 0.0 else float("inf")
    return (
        f"the log's interval [{interval.low:.4g}, {interval.high:.4g}] spans a factor of "
        f"{ratio:.3g}; allowed: at most {LARGEST_FACTOR:g}"
    )


def without_negative(name: str, interval: Interval, known: Quantity | None) -> Interval:
    """Return the interval of a friction parameter with a negative value replaced by 0.

    The interval is unchanged in three cases: the value is not negative; the whole interval is
    negative; the interval overlaps the interval in bench.yaml.
    """
    nearly_none = (
        name in NEVER_NEGATIVE
        and name not in POSITIVE
        and interval.value < 0.0 <= interval.high < float("inf")
    )
    return (
        Interval(0.0, 0.0, interval.high)
        if nearly_none and contradicts(interval, known)
        else interval
    )


def narrowed(interval: Interval, known: Quantity | None, constant: Quantity) -> Interval | None:
    """Return the intersection of the logs' interval and the range in bench.yaml.

    The intersection has the confidence of `interval`, because the range in bench.yaml certainly
    contains the true value. The value of the result is the value of `interval`, limited first to
    the range in bench.yaml and then to the intersection.

    Parameters
    ----------
    interval
        Interval from the logs, computed with the nominal actuator constant.
    known
        Value of the bench; None if the bench does not state the parameter.
    constant
        Actuator constant of the bench. The range in bench.yaml does not depend on this constant.

    Returns
    -------
    Interval | None
        None if the bench has no range, if the interval does not narrow this range, or if the two do
        not overlap.
    """
    if known is None or known.low is None or known.high is None:
        return None
    range_low, range_high = relative(known.low, known.high, constant)
    low, high = max(interval.low, range_low), min(interval.high, range_high)
    narrower = high - low < range_high - range_low
    if not math.isfinite(interval.half_width) or low > high or not narrower:
        return None
    value = min(max(interval.value, known.low), known.high)
    return Interval(min(max(value, low), high), low, high)


def contradicts(interval: Interval, known: Quantity | None) -> bool:
    """Return True if `interval` and the interval in bench.yaml, `known`, do not overlap."""
    if known is None or known.low is None or known.high is None:
        return False
    return interval.low > known.high or interval.high < known.low


def outside(interval: Interval, known: Quantity | None) -> str:
    """Return a text for a message if the intervals in bench.yaml and `interval` do not overlap.

    The text is "" if they overlap, or if `interval` is wholly negative.
    """
    if known is None or interval.high < 0.0 or not contradicts(interval, known):
        return ""
    return (
        f"; the interval lies outside the bench's [{known.low:.4g}, {known.high:.4g}], whose value "
        "is used"
    )


def below_coulomb(breakaway: Interval, coulomb: Interval) -> str | None:
    """Return a message if a breakaway is below Coulomb friction, which is impossible, else None."""
    if breakaway.high >= coulomb.low:
        return None
    return (
        f"the log's interval [{breakaway.low:.4g}, {breakaway.high:.4g}] is below Coulomb "
        f"friction [{coulomb.low:.4g}, {coulomb.high:.4g}]; allowed: at least Coulomb friction"
    )
