"""Measured channel as a reference, resampled from the log's times to the controller's samples.

Sample k is at the time from_s + k T after the log's first sample, where T is the controller's
period. The last replayed sample is at or before `to_s`; without `to_s`, it is at or before the
log's end.

held     reference, current and voltage: sample k is the latest logged value. A value that is logged
         up to T/2 after sample k is still used, so that jitter of the log's times neither doubles
         nor drops a value.
linear   other channels, such as a measured position: sample k is interpolated between the logged
         values.

logs/clocks/resampling.py lists the held channels.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.quantity import Axis, si_unit
from frictool.documents.scenario import Replay
from frictool.errors import LogError
from frictool.logs.clocks.resampling import HELD
from frictool.logs.log import Log
from frictool.simulate.reference import samples_of
from frictool.typing import Vector

JITTER = 0.5  # largest delay of a logged value, in periods of the controller
GAP = 1.5  # shortest gap between logged samples, in periods of the log


def reference_from_log(replay: Replay, log: Log, axis: Axis, period: float) -> Vector:
    """Return the reference (n,) [rad | m] at the controller's samples.

    `replay.shift` is added to all values. After the replayed section, the last value is kept for
    `replay.hold_s`.

    Raises LogError if the log lacks the channel, if the channel is not a position or not finite, or
    if the log ends before `replay.from_s` or `replay.to_s`.
    """
    stream = log.main
    (values,) = log.require(stream, replay.channel)
    unit = si_unit("position", axis)
    if stream.units.get(replay.channel) != unit:
        was = stream.units.get(replay.channel)
        raise LogError(
            log.source,
            f"has {replay.channel} in {was!r}; allowed as a reference: a channel in {unit}, "
            f"because the axis is {axis}",
        )
    time = stream.time - stream.time[0]
    end = float(time[-1]) if replay.to_s is None else replay.to_s
    if replay.from_s >= time[-1] or end > time[-1] + 0.5 * stream.period:
        raise LogError(
            log.source,
            (
                f"has a duration of {float(time[-1]):g} s, but the scenario replays "
                f"{replay.from_s:g} s to {end:g} s of this log; choose from_s and to_s within it"
            ),
        )
    instants: Vector = replay.from_s + period * np.arange(
        int((end - replay.from_s) / period + 1e-9) + 1, dtype=np.float64
    )
    reference: Vector
    if replay.channel in HELD:
        reference = _latest_logged(time, values, instants, JITTER * period)
    else:
        reference = np.asarray(np.interp(instants, time, values), dtype=np.float64)
    if not np.all(np.isfinite(reference)):
        first = float(instants[int(np.argmin(np.isfinite(reference)))])
        raise LogError(
            log.source,
            f"has no number for {replay.channel} at {first:g} s; choose from_s and to_s so that "
            "every replayed sample is a number",
        )
    reference = reference + (replay.shift.value if replay.shift is not None else 0.0)
    return np.concatenate(
        [reference, np.full(samples_of(replay.hold_s or 0.0, period), reference[-1])]
    )


def _latest_logged(time: Vector, values: Vector, instants: Vector, late: float) -> Vector:
    latest: Vector = values[np.maximum(np.searchsorted(time, instants + late, side="right") - 1, 0)]
    return latest


def gaps_of(replay: Replay, log: Log) -> list[str]:
    """Return a warning in a list if samples of the replayed section are missing, else []."""
    stream = log.main
    time = stream.time - stream.time[0]
    inside = time[
        (time >= replay.from_s) & (time <= (np.inf if replay.to_s is None else replay.to_s))
    ]
    steps = np.diff(inside)
    wide = steps > GAP * stream.period
    if not wide.any():
        return []
    longest = int(np.argmax(steps))
    where = f"the longest of {steps[longest]:.4g} s at {inside[longest]:.4g} s"
    count = int(wide.sum())
    return [
        f"the replayed log has {count} gap{'s' * (count > 1)}, {where}; in a gap the reference is "
        "held or interpolated"
    ]
