"""Choice of the identification methods that suit a log.

With a bench, each method is tried on the log (`method_trials.py`). Without a bench, the choice is
based on signals, sampling and motion only; a chosen method can then still refuse the log.
"""

from __future__ import annotations

from frictool.errors import LogError
from frictool.identify.methods import METHODS
from frictool.identify.motion_record import (
    MotionRecord,
    make_record,
    velocity_count,
    velocity_record,
)
from frictool.logs.quality.survey import POSITION, StreamSurvey

THE_LOG = "the log"  # name of the examined log in messages
BREAKAWAY, VELOCITY = "breakaway", "velocity"
DRIVES = ("effort", "current", "voltage")
# largest encoder step with which differences of the position show the direction of motion; the step
# is relative to the distance that the axis moves in one sample at top speed
COARSEST = 0.1


def applicable_methods(
    stream: StreamSurvey, kind: str | None, *, known_offset: bool = False
) -> dict[str, str | None]:
    """Return for each method the reason why a log does not suit the method, or None.

    The key `breakaway` stands for the evaluation of breakaway ramps. `stream` contains statistics
    of the log's signals. `kind` is the kind of test that was detected in the log, such as "ramp" or
    "rest"; None if no kind was detected. If `known_offset` is True, the bench states the offset, so
    that motion in one direction suffices.
    """
    record = None
    why = _nothing_to_use(stream, kind)
    if why is None:
        try:
            record = _record_of(stream)
        except LogError as error:
            why = f"the log {str(error).removeprefix(f'{THE_LOG}: ')}"
    blind = None if POSITION in stream.signals else "the log has no position"
    sliding = _no_sliding(stream, kind, known_offset)
    out = {
        name: why
        or (None if row.velocity else blind)
        or sliding
        or _absent(stream, row.channel)
        or (_too_rough(stream) if row.differentiates else None)
        or (None if record is None else _of_opening(stream, row.why_not([record])))
        for name, row in METHODS.items()
    }
    ramps = (
        None
        if kind == "ramp"
        else f"the log is not a ramp of the effort from rest (detected: {kind or 'nothing'})"
    )
    return {**out, BREAKAWAY: why or blind or ramps}


def _nothing_to_use(stream: StreamSurvey, kind: str | None) -> str | None:
    if POSITION not in stream.signals and VELOCITY not in stream.signals:
        return "the log has neither position nor velocity"
    if not any(name in stream.signals for name in DRIVES):
        return f"the log has no drive signal ({', '.join(DRIVES)})"
    if kind == "rest":
        return "the position does not change"
    if stream.base.samples < 3:
        return f"the log has only {stream.base.samples} samples"
    return None


def _record_of(stream: StreamSurvey) -> MotionRecord:
    opening = stream.opening
    drive = next(opening.signals[name] for name in DRIVES if name in opening.signals)
    position = opening.signals.get(POSITION)
    if position is None:
        return velocity_record(THE_LOG, opening.time, opening.signals[VELOCITY], drive, lag=0.0)
    count = stream.signals[POSITION].step or velocity_count(position)
    return make_record(THE_LOG, opening.time, position, drive, count, lag=0.0)


def _of_opening(stream: StreamSurvey, reason: str | None) -> str | None:
    examined = stream.opening.time.size
    if reason is None or examined >= stream.base.samples:
        return reason
    return f"in the first {examined} samples: {reason}"


def _no_sliding(stream: StreamSurvey, kind: str | None, known_offset: bool = False) -> str | None:
    if kind == "ramp":
        return "the axis rests for most of the time; record a log of motion"
    if known_offset:
        return None
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
