"""Check of a record against the bench: impossible values, and jumps of the encoder counter."""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.errors import LogError
from frictool.identify.motion_record import MotionRecord
from frictool.logs.quality.jumps import JUMPS, PositionJumps, abrupt_jumps, allowance

MOST_COUNTS = 2.0**53  # largest encoder count; doubles represent every integer up to it
# largest distance from the median position, relative to the travel; the bench states the travel
# only roughly
MOST_TRAVELS = 10.0
MOST_EFFORT = 10.0  # largest effort, relative to the effort at the actuator's limit


def implausible(record: MotionRecord, bench: Bench) -> list[str]:
    """Return warnings about jumps of the position; raise LogError for impossible values.

    Raises
    ------
    LogError
        If a position exceeds 2^53 encoder counts, if its distance from the median position exceeds
        MOST_TRAVELS times the travel, or if an effort exceeds MOST_EFFORT times the effort at the
        drive's limit. The message states the time.
    """
    length, effort = si_unit("position", bench.axis), si_unit("effort", bench.axis)
    counts = MOST_COUNTS * record.resolution
    _refuse(
        record,
        np.abs(record.position) > counts,
        record.position,
        length,
        f"a position of at most 2^53 encoder counts, {counts:.3g} {length}",
    )
    travel = bench.mechanics.travel
    if travel is not None:
        reach = MOST_TRAVELS * (travel.high - travel.low)
        away = np.abs(record.position - np.median(record.position)) > reach
        _refuse(
            record,
            away,
            record.position,
            length,
            f"a position within {MOST_TRAVELS:g} times the travel ({reach:.4g} {length}) of the "
            "median position; check the unit in columns.position",
        )
    most = MOST_EFFORT * bench.actuator.limit.value * bench.actuator.constant.value
    beyond = np.abs(record.effort) > most
    _refuse(
        record,
        beyond,
        record.effort,
        effort,
        f"at most {MOST_EFFORT:g} times the effort at the drive's limit, {most:.4g} {effort}",
    )
    return _skipped_counts(record, bench)


def repeats_plausibility_warning(warning: str, bench: Bench) -> bool:
    """Return True if `warning` is about position jumps of which `implausible` also warns."""
    return bench.mechanics.top_speed is not None and warning.startswith(JUMPS)


def _refuse(
    record: MotionRecord, bad: np.ndarray, values: np.ndarray, unit: str, allowed: str
) -> None:
    if bad.any():
        first = int(np.argmax(bad))
        raise LogError(
            record.name,
            f"found {values[first]:.4g} {unit} at {record.time[first]:.6g} s; allowed: {allowed}",
        )


def _skipped_counts(record: MotionRecord, bench: Bench) -> list[str]:
    top_speed = bench.mechanics.top_speed
    if top_speed is None:
        return []
    steps = np.diff(record.position) / record.resolution
    limit = allowance(top_speed.value, np.full(steps.size, record.period), record.resolution)
    inside = np.diff(record.piece) == 0
    long = abrupt_jumps(steps, limit) & inside
    jumps = PositionJumps()
    jumps.take(
        record.time[1:][long],
        steps[long],
        record.position[1:][long] / record.resolution,
        float(limit.max()),
    )
    text = jumps.text()
    if text is None and np.any((np.abs(steps) > limit) & inside):
        fastest = float(np.max(np.abs(steps[inside]))) * record.resolution / record.period
        text = (
            f"the speed reaches {fastest / top_speed.value:.3g} times mechanics.top_speed; check "
            "top_speed, the encoder's counts per turn and the unit of the position"
        )
    return [f"{record.name}: {text}"] if text else []
