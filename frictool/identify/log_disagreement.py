"""Warnings about logs that disagree about a parameter.

If logs disagree, the common model fits no log well. Either the interval from all logs is much wider
than the interval from one log, or it is so narrow that it lies outside the interval from one log.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit, UnusableLogs
from frictool.identify.fixed_parameter_refit import refit
from frictool.identify.methods import METHODS, REFERENCE, IdentificationSettings
from frictool.identify.motion_record import MotionRecord

WIDER = 4.0  # largest width of an interval from all logs, relative to the width from one log
OTHERS_DIFFER = "although the logs agree on this parameter; they may differ in another parameter"
MOST_LOGS = 20  # largest number of compared logs; the first logs are used


def pooling_warnings(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    fit: SlidingFit,
    identified: Mapping[str, Interval],
) -> list[str]:
    """Return a warning for each parameter about which the logs disagree.

    The interval from all logs should be narrower than the interval from a single log. A warning is
    returned if the interval from all logs is more than WIDER times as wide as the narrowest
    interval from a single log, or if the interval from a single log does not overlap the interval
    of the model (`identified`). `fit` is the fit of all logs without fixed parameters. Each log is
    also fitted alone with the same method and load terms. If the method is output error, least
    squares replace it, because a search for each log would take long.
    """
    if len(records) < 2:
        return []
    searched = fit.method is not None and METHODS[fit.method].known_terms is not None
    alike = replace(fit, method=REFERENCE) if searched else fit
    try:
        pooled = (
            refit(records, bench, settings, alike, fit.fixed) if searched or fit.dropped else fit
        )
    except UnusableLogs:
        return []
    alone = {}
    for record in records[:MOST_LOGS]:
        try:
            single = refit([record], bench, settings, alike, fit.fixed)
            alone[Path(record.name).name] = _comparable(single)
        except UnusableLogs:
            continue
    together = _comparable(pooled)
    out = []
    for name in SLIDING:
        intervals = {
            log: one[name]
            for log, one in alone.items()
            if name in one and one[name].half_width > 0.0
        }
        if name not in together or not intervals:
            continue
        best = min(intervals, key=lambda log: intervals[log].half_width)
        ratio = together[name].half_width / intervals[best].half_width
        if ratio > WIDER:
            out.append(
                f"{name}: the interval from all logs is {ratio:.3g} times as wide as that of "
                f"{best} alone, {_reason(intervals)}; use --each log"
            )
        elif name in identified:
            out += _outside(name, identified[name], intervals)
    return out


def _comparable(fit: SlidingFit) -> dict[str, Interval]:
    """Return the parameters of a fit; an inertia that encoder noise decreases is left out.

    The decrease differs from log to log, and the intervals of the fit do not include it.
    """
    kept = fit.attenuation == 0.0
    return {name: one for name, one in fit.parameters.items() if kept or name != "inertia"}


def _outside(name: str, common: Interval, intervals: Mapping[str, Interval]) -> list[str]:
    """Return a warning if the interval of a log does not overlap the common interval."""
    distance = {
        log: max(one.low - common.high, common.low - one.high) for log, one in intervals.items()
    }
    log = max(distance, key=lambda each: distance[each])
    if distance[log] <= 0.0:
        return []
    alone = intervals[log]
    return [
        f"{name}: the interval from all logs, [{common.low:.4g}, {common.high:.4g}], contradicts "
        f"{log} alone, [{alone.low:.4g}, {alone.high:.4g}]: the logs differ, perhaps in "
        "temperature; use --each log"
    ]


def _reason(intervals: Mapping[str, Interval]) -> str:
    highest = max(intervals, key=lambda log: intervals[log].low)
    lowest = min(intervals, key=lambda log: intervals[log].high)
    if intervals[highest].low <= intervals[lowest].high:
        return OTHERS_DIFFER
    values = ", ".join(
        f"{log} [{intervals[log].low:.4g}, {intervals[log].high:.4g}]" for log in (lowest, highest)
    )
    return f"because the logs disagree ({values})"
