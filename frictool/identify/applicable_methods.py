"""Choice of the identification methods that suit a log, by its signals, sampling and motion.

A chosen method may still refuse the log; the message of this method then states the reason.
"""

from __future__ import annotations

import numpy as np

from frictool.identify.methods import METHODS
from frictool.identify.motion_record import JITTER, MOST_BROKEN
from frictool.logs.quality.survey import POSITION, StreamSurvey

BREAKAWAY, VELOCITY = "breakaway", "velocity"
DRIVES = ("effort", "current", "voltage")
# largest encoder step, relative to the distance per sample at top speed, at which differences of
# the position show the direction of motion
COARSEST = 0.1


def applicable_methods(stream: StreamSurvey, kind: str | None) -> dict[str, str | None]:
    """Return for each method the reason why the method does not suit a log, or None.

    The key `breakaway` stands for the evaluation of breakaway ramps. `stream` contains statistics
    of the log's signals. `kind` is the detected kind of test, such as "ramp" or "rest".
    """
    why = _nothing_to_use(stream, kind)
    blind = None if POSITION in stream.signals else "the log has no position"
    sliding = _no_sliding(stream, kind)
    out = {
        name: why
        or (None if row.velocity else blind)
        or sliding
        or _absent(stream, row.channel)
        or (_too_rough(stream) if row.differentiates else None)
        for name, row in METHODS.items()
    }
    ramps = (
        None
        if kind == "ramp"
        else f"the log is not a ramp of the effort from rest ({kind or 'unknown'})"
    )
    return {**out, BREAKAWAY: why or blind or ramps}


def _nothing_to_use(stream: StreamSurvey, kind: str | None) -> str | None:
    if POSITION not in stream.signals and VELOCITY not in stream.signals:
        return "the log has neither position nor velocity"
    if not any(name in stream.signals for name in DRIVES):
        return f"the log has none of {', '.join(DRIVES)}"
    if kind == "rest":
        return "the position does not change"
    if stream.base.samples < 3:
        return f"the log has only {stream.base.samples} samples"
    intervals = np.diff(stream.opening.time) * stream.base.rate_hz
    broken = float(np.mean(np.abs(intervals - 1.0) > JITTER))
    if broken > MOST_BROKEN:
        return (
            f"{100 * broken:.0f} % of the sample intervals differ from the period (allowed: "
            f"at most {100 * MOST_BROKEN:g} %); resample first"
        )
    return None


def _no_sliding(stream: StreamSurvey, kind: str | None) -> str | None:
    if kind == "ramp":
        return "the axis rests for most of the time; record a log of motion"
    if stream.velocity is not None and not stream.velocity[0] < 0.0 < stream.velocity[1]:
        return (
            "the axis moves in one direction only, which does not separate Coulomb "
            "friction from an offset"
        )
    return None


def _absent(stream: StreamSurvey, channel: str | None) -> str | None:
    return None if channel is None or channel in stream.signals else f"the log has no {channel}"


def _too_rough(stream: StreamSurvey) -> str | None:
    if stream.base.gaps:
        return f"the log has {stream.base.gaps} gaps, over which this method cannot filter"
    step = stream.signals[POSITION].step
    if step is None or stream.velocity is None:
        return None
    distance = max(map(abs, stream.velocity)) / stream.base.rate_hz
    share = step / distance
    return (
        f"one encoder count is {100 * share:.2g} % of the distance per sample at top speed "
        f"(allowed: at most {100 * COARSEST:g} %)"
        if share > COARSEST
        else None
    )
