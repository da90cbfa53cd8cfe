"""Survey of the signals of a log and their sensors, stream by stream, in bounded memory.

    pass 1   times, range, distinct values (quantisation), zero-order hold, first samples
    pass 2   flat tops, samples at a limit, velocities and jumps, from the results of pass 1

The first samples stay in memory. They show the kind of test, and the signs of effort and motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.canonical.sample_chunks import join_blocks
from frictool.logs.clocks.sample_intervals import SampleIntervals
from frictool.logs.log import Stream
from frictool.logs.quality.jumps import PositionJumps, isolated_jumps
from frictool.logs.quality.opening_samples import OpeningSamples
from frictool.logs.quality.quantisation import DistinctValues
from frictool.logs.quality.saturation import FlatTop, FlatTopDetector
from frictool.logs.quality.time_base import TimeBase
from frictool.logs.quality.velocity_range import VelocityRange
from frictool.logs.quality.zero_order_hold import HoldDetector
from frictool.logs.raw_table import BLOCK_ROWS
from frictool.logs.stream_source import SampleBlock
from frictool.typing import Vector

POSITION, REFERENCE = "position", "reference"
# not checked for flat tops, because they rest at the ends of a stroke
UNSATURATED = (POSITION, REFERENCE)
AT_LIMIT = 0.98  # a noisy signal above this share of its limit is treated as at the limit
Pieces = Callable[[], Iterator[SampleBlock]]


@dataclass
class SignalSurvey:
    """Survey of one signal; all values are in `unit`.

    low, high: smallest and largest value.
    levels: number of distinct values, counted up to a limit.
    step: quantisation step; None if the values are not multiples of a step.
    hold: number of samples for which the signal keeps a value; None without zero-order hold.
    flat: flat tops of the signal (saturation.py).
    at_limit: number of samples at the limit that bench.yaml sets for the signal; None if there is
        no limit.
    """

    name: str
    unit: str
    low: float = np.inf
    high: float = -np.inf
    levels: int = 0
    step: float | None = None
    hold: int | None = None
    flat: tuple[FlatTop, ...] = ()
    at_limit: int | None = None


@dataclass
class StreamSurvey:
    """Survey of one stream.

    base: sample rate, jitter and gaps.
    signals: survey of each signal, by the name of the signal.
    opening: first samples of the stream.
    velocity: lowest and highest velocity, computed from the position, in rad/s or m/s.
    window: number of samples between two positions from which a velocity is computed.
    jumps: jumps of the position.
    """

    topic: str
    base: TimeBase
    signals: dict[str, SignalSurvey]
    opening: Stream
    velocity: tuple[float, float] | None = None
    window: int | None = None
    jumps: PositionJumps = field(default_factory=PositionJumps)


def survey(head: StreamHeader, pieces: Pieces, limits: Mapping[str, float]) -> StreamSurvey:
    """Return the survey of one stream.

    pieces: function that returns an iterator over all samples. It is called twice.
    limits: largest absolute value that bench.yaml allows for a signal, by the signal's name.
    """
    signals = {
        name: SignalSurvey(name, unit) for name, unit in zip(head.fields, head.units, strict=True)
    }
    intervals = SampleIntervals()
    levels = {name: DistinctValues() for name in signals}
    holds = {name: HoldDetector() for name in signals}
    opening = OpeningSamples(head)
    for piece in _blocks(pieces()):
        opening.take(piece)
        intervals.add(piece.time)
        for name, values in zip(head.fields, piece.values, strict=True):
            one = signals[name]
            one.low = min(one.low, float(values.min()))
            one.high = max(one.high, float(values.max()))
            levels[name].take(values)
            holds[name].take(values)
    for name, one in signals.items():
        one.levels, one.step = levels[name].count, levels[name].step
        one.hold = holds[name].samples(one.step)
    stream = StreamSurvey(head.topic, intervals.base(), signals, opening.stream)
    _second_pass(head, pieces, stream, limits)
    return stream


def _second_pass(
    head: StreamHeader, pieces: Pieces, report: StreamSurvey, limits: Mapping[str, float]
) -> None:
    tops = {
        name: FlatTopDetector(one.low, one.high, one.step)
        for name, one in report.signals.items()
        if name not in UNSATURATED
    }
    position = report.signals.get(POSITION)
    speed = VelocityRange(None if position is None else position.step)
    before = np.empty(0), np.empty(0)
    for piece in _blocks(pieces()):
        values = dict(zip(head.fields, piece.values, strict=True))
        for name, one in tops.items():
            one.take(values[name])
        for name in limits.keys() & values.keys():
            signal = report.signals[name]
            signal.at_limit = (signal.at_limit or 0) + int(
                np.sum(np.abs(values[name]) >= AT_LIMIT * limits[name])
            )
        if position is not None:
            time = piece.time / NS
            place = values[POSITION]
            speed.take(time, place)
            _jumps(
                report.jumps, np.append(before[0], time), np.append(before[1], place), position.step
            )
            before = time[-1:], place[-1:]
    for name, one in tops.items():
        report.signals[name].flat = one.result()
    if position is not None:
        report.velocity, report.window = speed.range, speed.window


def _jumps(jumps: PositionJumps, time: Vector, position: Vector, step: float | None) -> None:
    if step is not None and position.size > 2:
        steps = np.diff(position) / step
        isolated = isolated_jumps(steps)
        jumps.take(
            time[1:][isolated],
            steps[isolated],
            position[1:][isolated] / step,
            float(np.abs(steps[~isolated]).max(initial=0.0)) + 2.0,
        )


def _blocks(pieces: Iterator[SampleBlock]) -> Iterator[SampleBlock]:
    """Yield the samples in blocks of BLOCK_ROWS.

    Equal blocks make the result of the survey independent of the file's chunks.
    """
    waiting: list[SampleBlock] = []
    rows = 0
    for piece in pieces:
        waiting.append(piece)
        rows += piece.time.size
        while rows >= BLOCK_ROWS:
            whole = join_blocks(waiting)
            yield whole.part(0, BLOCK_ROWS)
            rows -= BLOCK_ROWS
            waiting = [whole.part(BLOCK_ROWS, BLOCK_ROWS + rows)]
    if rows:
        yield join_blocks(waiting)


def in_memory(stream: Stream) -> tuple[StreamHeader, Pieces]:
    """Return header and samples of a stream in memory, as arguments for `survey`."""
    samples = SampleBlock(
        np.rint(stream.time * NS).astype(np.int64), tuple(stream.signals.values())
    )
    return StreamHeader(
        stream.topic, tuple(stream.signals), tuple(stream.units[name] for name in stream.signals)
    ), lambda: iter((samples,))


def row(report: StreamSurvey, one: SignalSurvey, column: str | None) -> dict[str, Any]:
    """Return the survey of one signal as a dictionary for JSON output.

    column: raw column from which the signal was made; None if unknown.
    """
    base = report.base
    return {
        "name": one.name,
        "source": report.topic,
        "column": column,
        "unit": one.unit,
        "samples": base.samples,
        "rate_hz": base.rate_hz,
        "rate_spread_hz": base.jitter_s * base.rate_hz**2,
        "jitter_s": base.jitter_s,
        "gaps": base.gaps,
        "longest_gap_s": base.longest_gap_s,
        "low": one.low,
        "high": one.high,
        "step": one.step,
        "held_s": None if one.hold is None else one.hold / base.rate_hz,
        "at_limit": one.at_limit,
        "flat_tops": [
            {"at": top.at, "samples": top.samples, "longest_s": top.longest / base.rate_hz}
            for top in one.flat
        ],
    }
