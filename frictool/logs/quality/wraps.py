"""Detection of positions that wrap: the sensor shows the position modulo a period (one turn, or the range of a counter).

At a wrap the position goes from one end of the period to the other while the axis moves on at one speed. A step s is a wrap of
period P if all of this holds:

    P / 2 < |s| < P        and the rest u = s - P sign(s) has the other sign, as the axis moves on across the end
    u is like the steps    two before it and two after it (these without the period, too), which are short
    the position's range   is not larger than P

and if most steps longer than P / 2 are such steps. For a period of one turn, one such step is enough. For another period, one is enough if
the neighbouring steps are shorter than P / 100; else three are needed. A glitch goes there and back, a lost count has another length, and
a fast axis leaves the range. Only natural periods are tried: 2^b counts of the encoder and, on a rotary axis,
half a turn, one turn and 2^b turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictool.documents.bench import Bench
from frictool.logs.log import Vector

TURN = 2.0 * math.pi  # rad
BITS = range(8, 33)  # of a counter, as encoder.wrap_bits allows
TURNS = (0.5, *(2.0**power for power in range(17)))
NEIGHBOURS = 2  # number of steps before and after a step with which it is compared
ALIKE = 0.5  # tolerance of their range, relative to the longest of them
FASTEST = 0.2  # of the period: bound of the steps next to a wrap
SLOW = 0.01  # of the period: one wrap between steps below this bound is sure
SEVERAL = 3  # this number of wraps is sure, whatever the period
RANGE_SLACK = 0.01  # of the period: tolerance of the position's range
STEP_SLACK = 1e-3  # of the period: a smaller difference is motion or noise
MOSTLY = 0.9  # least share of wraps among the steps longer than half a period


@dataclass(frozen=True)
class Wrap:
    """Wrap of a position: its period [rad | m], its number of occurrences, and time [s] and positions before and after the first.

    line: the line to write under `encoder` of the bench.
    """

    period: float
    count: int
    time: float
    before: float
    after: float
    line: str
    unit: str

    @property
    def text(self) -> str:
        """Return the text of the wrap, with the line to write into the bench."""
        when = "once, at" if self.count == 1 else f"{self.count} times, first at"
        jump = f"from {self.before:.6g} to {self.after:.6g} {self.unit} while the axis moves on"
        return f"the position wraps {when} {self.time:.6g} s: it jumps {jump}; write under encoder in the bench: {self.line}"


class WrapSearch:
    """Search for wraps in a position [rad | m] of one axis, block after block.

    counted: the position was read as whole counts of the encoder, so that `wrap_bits` mends a wrap of 2^b counts.
    """

    def __init__(self, bench: Bench, counted: bool = False) -> None:
        self._linear, self._resolution, self._counted = bench.axis == "linear", bench.encoder.resolution, counted
        periods = [self._resolution * 2.0**bits for bits in BITS]
        if not self._linear:
            periods += [TURN * turns for turns in TURNS]
        self._candidates = {period: _Candidate(period, 2.0 * self._resolution) for period in sorted(periods)}
        self._time: Vector = np.empty(0)
        self._position: Vector = np.empty(0)
        self._judged = 0  # steps at the start of the samples kept that have been judged
        self._low, self._high = math.inf, -math.inf

    def take(self, time: Vector, position: Vector) -> None:
        """Add samples (n,) that follow those before: s, and rad or m."""
        if position.size:
            self._low, self._high = min(self._low, float(position.min())), max(self._high, float(position.max()))
            self._time, self._position = np.append(self._time, time), np.append(self._position, position)
            self._judge(self._position.size - 1 - NEIGHBOURS)

    def finish(self) -> None:
        """Judge the last steps too; call it after the last samples."""
        self._judge(self._position.size - 1)

    def found(self) -> Wrap | None:
        """Return the wrap of the steps judged so far, or None."""
        for period, one in self._candidates.items():
            enough = one.sure or one.wraps >= (1 if period == TURN else SEVERAL)
            if enough and one.wraps >= MOSTLY * one.long and self._fits(period):
                time, before, after = one.first
                return Wrap(period, one.wraps, time, before, after, self._line(period), "m" if self._linear else "rad")
        return None

    def _fits(self, period: float) -> bool:
        return self._high - self._low <= period * (1.0 + RANGE_SLACK)

    def _judge(self, end: int) -> None:
        """Judge the steps before `end` that have not been judged, and keep the samples that later steps need."""
        if end <= self._judged:
            return
        steps = np.diff(self._position)
        longest = float(np.abs(steps[self._judged : end]).max())
        for period, one in self._candidates.items():
            if longest > 0.5 * period and self._fits(period):
                one.judge(self._time, self._position, steps, slice(self._judged, end))
        dropped = max(0, end - NEIGHBOURS)
        self._time, self._position, self._judged = self._time[dropped:], self._position[dropped:], end - dropped

    def _line(self, period: float) -> str:
        bits = math.log2(period / self._resolution)
        whole = round(bits) if abs(bits - round(bits)) < 1e-9 and round(bits) in BITS else None
        if self._counted and whole is not None:
            return f"wrap_bits: {whole}"
        turns = period / TURN
        if not self._linear and any(math.isclose(turns, one, rel_tol=1e-9) for one in TURNS):
            return f"wrap: {{value: {turns:g}, unit: turn}}"
        return f"wrap: {{value: {period:.12g}, unit: {'m' if self._linear else 'rad'}}}"


class _Candidate:
    """Counts for one period: steps longer than half of it, wraps and sure wraps among them; the first wrap."""

    def __init__(self, period: float, noise: float) -> None:
        self.long = self.wraps = self.sure = 0
        self.first = (math.nan, math.nan, math.nan)  # time, position before and after
        self._period, self._noise = period, noise

    def judge(self, time: Vector, position: Vector, steps: Vector, judged: slice) -> None:
        """Count the wraps among the steps (n,) in `judged`; the first and the last NEIGHBOURS steps of a log never count."""
        size, rest = np.abs(steps), steps - self._period * np.rint(steps / self._period)
        padded = np.pad(rest, NEIGHBOURS, constant_values=np.nan)
        beside = np.array([padded[at : at + rest.size] for at in range(2 * NEIGHBOURS + 1) if at != NEIGHBOURS])
        low, high, fastest = beside.min(axis=0), beside.max(axis=0), np.abs(beside).max(axis=0)
        allowed = ALIKE * fastest + self._noise + STEP_SLACK * self._period
        long = (size > 0.5 * self._period) & np.isfinite(fastest)
        wraps = long & (size < self._period) & (fastest < FASTEST * self._period) & (rest >= low - allowed) & (rest <= high + allowed)
        if wraps[judged].any() and not self.wraps:
            place = (judged.start or 0) + int(np.argmax(wraps[judged]))
            self.first = float(time[place + 1]), float(position[place]), float(position[place + 1])
        self.long += int(long[judged].sum())
        self.wraps += int(wraps[judged].sum())
        self.sure += int((wraps & (fastest < SLOW * self._period))[judged].sum())
