"""Comparison of a canonical log with bench.yaml, which may have changed since the log was made.

The units and the sample period of the log are compared with the present bench.yaml. The effort in
the log may have been computed from the drive signal (current or voltage), with the actuator
constant that bench.yaml had during `ingest`. Such an effort is computed again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import CHANNEL_DIMENSIONS, drive_dimension, si_unit
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import COLUMNS, message_path
from frictool.logs.channels.mapping import EFFORT, check_rate
from frictool.logs.clocks.resampling import RESAMPLED
from frictool.logs.log import Log, Stream
from frictool.logs.quality.drive_range import IMPOSSIBLE, beyond_limit
from frictool.logs.quality.jumps import JUMPS
from frictool.logs.quality.motion_check import motion_doubts
from frictool.logs.quality.time_base import time_base
from frictool.logs.quality.wrap_detection import WrapSearch
from frictool.typing import Vector

# an effort is treated as computed up to this relative deviation from a multiple of the drive signal
ROUNDING = 1e-9
SAME_CONSTANT = 1e-6  # relative difference up to which the actuator constant counts as unchanged


def match_bench(log: Log, bench: Bench, *, same_period: bool = False) -> Log:
    """Return the log with the effort recomputed from the actuator constant in bench.yaml.

    Only the effort of the main stream is recomputed, and only if this effort was not measured.
    Warnings about the log and about a changed constant are appended to the warnings of the result.

    Raises LogError in the following cases:

    - a unit does not fit the kind of axis (rotary or linear) of the bench
    - a drive signal is far beyond the drive's limit
    - the position wraps
    - the sample periods of log and bench.yaml differ by more than a factor of 30 or, if
      `same_period` is True, by more than 20 %
    """
    stream = log.main
    _check_units(log, stream, bench)
    doubt = _check_drive(log, stream, bench)
    noted = [
        *log.warnings,
        *([doubt] if doubt else []),
        *_check_wraps(log, stream, bench),
        *motion_doubts(stream, bench),
        *check_rate(log.source, time_base(stream.time), bench.sample_period_s, same=same_period),
    ]
    if effort_is_measured(log, stream, bench):
        return replace(log, warnings=tuple(dict.fromkeys(noted)))
    signals = {name: values for name, values in stream.signals.items() if name != EFFORT}
    drive = signals.get(bench.actuator.drive)
    constant = bench.actuator.constant.value
    if drive is not None:
        signals[EFFORT] = constant * drive
        before = _ratio(drive, stream.signals[EFFORT])
        if np.any(drive) and abs(before / constant - 1.0) > SAME_CONSTANT:
            unit = si_unit(drive_dimension(bench.actuator.drive, constant=True), bench.axis)
            made = (
                f"effort is recomputed from {bench.actuator.drive} with actuator.constant of "
                f"bench.yaml, {constant:.6g} {unit}"
            )
            noted.append(f"{made}; the effort in the log was computed with {before:.6g} {unit}")
    streams = tuple(
        replace(stream, signals=signals) if one is stream else one for one in log.streams
    )
    return replace(log, streams=streams, warnings=tuple(dict.fromkeys(noted)))


def _check_units(log: Log, stream: Stream, bench: Bench) -> None:
    for name, unit in stream.units.items():
        if name not in CHANNEL_DIMENSIONS:
            continue
        wanted = si_unit(CHANNEL_DIMENSIONS[name], bench.axis)
        if unit != wanted:
            mismatch = (
                f"{message_path(stream.topic, name)} is in {unit!r}, but the {bench.axis} axis of "
                f"bench {bench.name!r} needs {wanted!r}"
            )
            raise LogError(log.source, f"{mismatch}; give the bench of this log")


def _check_drive(log: Log, stream: Stream, bench: Bench) -> str | None:
    """Return a warning if a drive signal exceeds SUSPECT times its limit; None if none does.

    Raises LogError if a drive signal exceeds IMPOSSIBLE times the drive's limit.
    """
    notes = log.metadata.get(COLUMNS, {})
    paths = {name: _path_before(log, message_path(stream.topic, name)) for name in stream.signals}
    columns = {
        name: notes[path].rpartition(" [")[0] for name, path in paths.items() if path in notes
    }
    signals = {
        name: values
        for name, values in stream.signals.items()
        if name != EFFORT or effort_is_measured(log, stream, bench)
    }
    impossible = beyond_limit(signals, columns, bench, IMPOSSIBLE)
    if impossible is not None:
        raise LogError(log.source, impossible)
    return beyond_limit(signals, columns, bench)


def _check_wraps(log: Log, stream: Stream, bench: Bench) -> tuple[str, ...]:
    """Return a warning if the position may wrap; raise LogError if it certainly wraps."""
    if "position" not in stream.signals:
        return ()
    wraps = WrapSearch(bench)
    wraps.take(stream.time, stream.signals["position"])
    wraps.finish()
    wrap, question = wraps.result(), wraps.possible()
    if wrap is not None:
        raise LogError(log.source, f"{wrap.text}, and ingest the raw log again")
    return (
        ()
        if question is None or any(JUMPS in text for text in log.warnings)
        else (question.question,)
    )


def effort_is_measured(log: Log, stream: Stream, bench: Bench) -> bool:
    """Return False if the effort was computed from the drive signal, else True.

    The metadata record `columns`, which `ingest` writes, shows whether the effort was computed. If
    this record is missing, the effort is treated as measured unless it is a multiple of the drive
    signal.
    """
    if EFFORT not in stream.signals:
        return True
    columns = log.metadata.get(COLUMNS, {})
    if columns:
        return _path_before(log, message_path(stream.topic, EFFORT)) in columns
    drive = stream.signals.get(bench.actuator.drive)
    effort = stream.signals[EFFORT]
    if drive is None:
        return True
    return float(np.max(np.abs(effort - _ratio(drive, effort) * drive))) > ROUNDING * float(
        np.max(np.abs(effort))
    )


def _path_before(log: Log, path: str) -> str:
    """Return the path that a channel had before `ingest --resample` joined all streams."""
    return log.metadata.get(RESAMPLED, {}).get(path, "").partition(", from ")[2] or path


def _ratio(drive: Vector, effort: Vector) -> float:
    largest = int(np.argmax(np.abs(drive)))
    return float(effort[largest] / drive[largest]) if drive[largest] else 0.0
