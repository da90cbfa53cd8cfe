"""Warn of logs that disagree: all together give a much wider interval than one alone, and their
common model fits none of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SLIDING, SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.refit import refit

WIDER = 4.0  # largest width from all logs, relative to that of one log alone
OTHERS_DIFFER = (
    "although the logs agree on it: they differ in another parameter, or the method widens it"
)
MOST_LOGS = 20  # most logs that are compared; the first ones are taken


def pooling_warnings(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings, fit: SlidingFit
) -> list[str]:
    """Return a warning for each parameter whose interval from all logs is more than WIDER times
    that of one log alone.

    fit: the fit of all logs in which no parameter is fixed at a value of the bench; neither is one
    in the fit of a single log, which has the same method and structure. Least squares replace
    output error, which needs a search for each log, for all logs together, too.
    """
    if len(records) < 2:
        return []
    searched = fit.method == "output-error"
    alike = replace(fit, method="least-squares") if searched else fit
    try:
        pooled = refit(records, bench, settings, alike, {}) if searched or fit.dropped else fit
    except UnusableLogs:
        return []
    alone = {}
    for record in records[:MOST_LOGS]:
        try:
            alone[Path(record.name).name] = refit([record], bench, settings, alike, {}).parameters
        except UnusableLogs:
            continue
    out = []
    for name in SLIDING:
        told = {
            log: one[name]
            for log, one in alone.items()
            if name in one and one[name].half_width > 0.0
        }
        if name not in pooled.parameters or not told:
            continue
        best = min(told, key=lambda log: told[log].half_width)
        ratio = pooled.parameters[name].half_width / told[best].half_width
        if ratio > WIDER:
            values = ", ".join(
                f"{log} {one.value:.4g} [{one.low:.4g}, {one.high:.4g}]"
                for log, one in told.items()
            )
            apart = max(one.low for one in told.values()) > min(one.high for one in told.values())
            reason = "because the logs disagree" if apart else OTHERS_DIFFER
            out.append(
                f"{name}: the interval from all logs is {ratio:.3g} times as wide as that of {best} alone, {reason} "
                f"({values}); identify them one by one (--each log), or leave out the log of another state of the machine"
            )
    return out
