"""Positions that wrap: a sensor that shows the position modulo a period (one turn, or the range of a counter).

At a wrap the position goes from one end of the period to the other while the axis moves on at one speed. A step s is taken for a wrap of
period P where all of this holds:

    P / 2 < |s| < P        and the rest u = s - P sign(s) has the other sign, as the axis moves on across the end
    u is like the steps    two before it and two after it (these without the period, too), which are short
    the position's range   is not larger than P

and where most steps longer than P / 2 are such steps. One such step of a turn is enough; of another period one, if the steps beside it are
shorter than P / 100, else three. A glitch goes there and back, a lost count has another length, and a fast axis leaves
the range. Only natural periods are tried: 2^b counts of the encoder and, on a rotary axis, half a turn, one turn and 2^b turns.
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
BESIDE = 2  # steps before and after a step that it is compared with
ALIKE = 0.5  # of the longest of them: by so much the step may lie outside their range
FASTEST = 0.2  # of the period: steps beside a wrap are shorter
SLOW = 0.01  # of the period: with such steps beside it, one wrap is sure
SEVERAL = 3  # wraps are sure, whatever the period
RANGE_SLACK = 0.01  # of the period: by so much the position's range may be longer
STEP_SLACK = 1e-3  # of the period: a difference so small is motion or noise
MOSTLY = 0.9  # of the steps longer than half a period


@dataclass(frozen=True)
class Wrap:
    """A wrap that was found: its period [rad | m], how often, and the first: when [s], from and to which position.

    line: what to write under `encoder` of the bench.
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
        """The finding, and the line that mends it."""
        when = "once, at" if self.count == 1 else f"{self.count} times, first at"
        jump = f"from {self.before:.6g} to {self.after:.6g} {self.unit} while the axis moves on"
        return f"the position wraps {when} {self.time:.6g} s: it jumps {jump}; write under encoder in the bench: {self.line}"


class Wraps:
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
            self._judge(self._position.size - 1 - BESIDE)

    def finish(self) -> None:
        """Judge the last steps too: no samples follow."""
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
        dropped = max(0, end - BESIDE)
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
    """Steps of one period: how many are longer than half of it, how many of them are wraps, and are sure; the first wrap."""

    def __init__(self, period: float, noise: float) -> None:
        self.long = self.wraps = self.sure = 0
        self.first = (math.nan, math.nan, math.nan)  # time, position before and after
        self._period, self._noise = period, noise

    def judge(self, time: Vector, position: Vector, steps: Vector, judged: slice) -> None:
        """Count the wraps among the steps (n,) in `judged`; the first and the last BESIDE steps of a log are none."""
        size, rest = np.abs(steps), steps - self._period * np.rint(steps / self._period)
        padded = np.pad(rest, BESIDE, constant_values=np.nan)
        beside = np.array([padded[at : at + rest.size] for at in range(2 * BESIDE + 1) if at != BESIDE])
        low, high, fastest = beside.min(axis=0), beside.max(axis=0), np.abs(beside).max(axis=0)
        allowed = ALIKE * fastest + self._noise + STEP_SLACK * self._period
        long = size > 0.5 * self._period
        wraps = long & (size < self._period) & (fastest < FASTEST * self._period) & (rest >= low - allowed) & (rest <= high + allowed)
        if wraps[judged].any() and not self.wraps:
            place = (judged.start or 0) + int(np.argmax(wraps[judged]))
            self.first = float(time[place + 1]), float(position[place]), float(position[place + 1])
        self.long += int(long[judged].sum())
        self.wraps += int(wraps[judged].sum())
        self.sure += int((wraps & (fastest < SLOW * self._period))[judged].sum())
