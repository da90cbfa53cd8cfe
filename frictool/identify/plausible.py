"""Whether a record can be one of the bench's axis at all: values that no axis reaches, and counts that it cannot have skipped."""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.errors import LogError
from frictool.identify.record import Record

MOST_COUNTS = 2.0**53  # from 0: beyond, not even whole numbers are told apart
MOST_TRAVELS = 10.0  # from the middle: a travel is known roughly, and the zero of an encoder not at all
MOST_EFFORT = 10.0  # of what the actuator gives at its limit
SKIPPED = 2.0  # of what top speed covers in a period: a servo may be faster than its specification
SLACK_COUNTS = 2.0
WRAP_BITS = range(8, 33)  # as encoder.wrap_bits allows


def implausible(record: Record, bench: Bench) -> list[str]:
    """What is odd about the record's counts: warnings.

    Raises LogError with the time of the first position that no encoder or travel gives, or effort that no actuator gives.
    """
    length, effort = si_unit("position", bench.axis), si_unit("effort", bench.axis)
    counts = MOST_COUNTS * record.resolution
    _refuse(
        record, np.abs(record.position) > counts, record.position, length, f"an encoder shows at most 2^53 counts, {counts:.3g} {length}"
    )
    travel = bench.mechanics.travel
    if travel is not None:
        reach = MOST_TRAVELS * (travel.high - travel.low)
        away = np.abs(record.position - np.median(record.position)) > reach
        _refuse(
            record, away, record.position, length, f"within {MOST_TRAVELS:g} times the bench's travel, {reach:.4g} {length}, of the others"
        )
    most = MOST_EFFORT * bench.actuator.limit.value * bench.actuator.constant.value
    beyond = np.abs(record.effort) > most
    _refuse(record, beyond, record.effort, effort, f"at most {MOST_EFFORT:g} times the actuator's at its limit, {most:.4g} {effort}")
    return _skipped_counts(record, bench)


def _refuse(record: Record, bad: np.ndarray, values: np.ndarray, unit: str, allowed: str) -> None:
    if bad.any():
        first = int(np.argmax(bad))
        raise LogError(record.name, f"found {values[first]:.4g} {unit} at {record.time[first]:.6g} s; allowed: {allowed}")


def _skipped_counts(record: Record, bench: Bench) -> list[str]:
    """A warning where the position jumps by more than top speed covers in a period, as a counter does that wraps."""
    top_speed = bench.mechanics.top_speed
    if top_speed is None:
        return []
    jumps = np.abs(np.diff(record.position))
    allowance = SKIPPED * top_speed.value * record.period + SLACK_COUNTS * record.resolution
    skipped = np.flatnonzero((jumps > allowance) & (np.diff(record.piece) == 0))
    if skipped.size == 0:
        return []
    first = int(skipped[0])
    counts, slack = float(jumps[first]) / record.resolution, allowance / record.resolution
    bits = round(math.log2(counts))
    wraps = bits in WRAP_BITS and abs(counts - 2.0**bits) <= slack
    hint = (
        f"does its counter wrap? then set encoder.wrap_bits, here to {bits}"
        if wraps
        else "are counts lost? does its counter wrap (encoder.wrap_bits)?"
    )
    speed = f"{jumps[first] / record.period:.4g} {si_unit('velocity', bench.axis)} at a top speed of {top_speed.value:.4g}"
    place = f"the first at {record.time[first + 1]:.6g} s, by {counts:.0f} counts, {speed}"
    return [f"{record.name}: the position jumps {skipped.size} times, {place}; {hint}"]
