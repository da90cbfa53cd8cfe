"""Conversion of an encoder's counter to unbounded counts, block after block.

    n        value of the counter, modulo 2^b if it has b bits, signed or unsigned
    wrap     d[k] = n[k] - n[k-1],  d <- d - 2^b round(d / 2^b): from sample to sample, the position
             is assumed to change by less than half the range of the counter

    index    a pulse sets the counter to a fixed value once per revolution: counts = n + start. At
             each pulse, `start` changes by a whole number of revolutions. This restores the counts
             lost since the previous pulse.

If the step d still exceeds the longest step that motion can cause (quality/jumps.py), the counter
has skipped counts. The sign of the skipped counts is unknown. Therefore the step is left as it is
and counted as a jump.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.logs.quality.jumps import PositionJumps, abrupt_jumps, allowance, isolated_jumps
from frictool.typing import Vector

# numbers of bits to which a logger may sign-extend a negative count, stored as unsigned
EXTENDED = (16, 24, 32)


def outside(raw: Vector, bits: int) -> int | None:
    """Return the index of the first value outside the range of a counter; None if there is none.

    raw: values (n,) of a counter of `bits` bits. Signed, unsigned and sign-extended values are
        allowed.
    """
    modulus = 2.0**bits
    fits = (raw >= -modulus / 2.0) & (raw < modulus)
    for register in EXTENDED:
        fits |= (raw >= 2.0**register - modulus / 2.0) & (raw < 2.0**register)
    bad = np.flatnonzero(~fits)
    return int(bad[0]) if bad.size else None


def folded(raw: Vector, bits: int, signed: bool) -> Vector:
    """Return the counts `raw` (n,), shifted into the range of a counter of `bits` bits.

    The shift is a multiple of 2^bits. The range is [-2^(bits-1), 2^(bits-1)) if `signed`, else [0,
    2^bits).
    """
    low = -(2.0 ** (bits - 1)) if signed else 0.0
    return np.asarray(np.mod(raw - low, 2.0**bits) + low)


class EncoderCounter:
    """Converter of counter values to unbounded counts, for the samples of one stream.

    jumps: steps that are too long for the top speed of the axis, other than wraps and resets.
    resets: number of resets by index pulses.
    lost: number of counts that the counter lost and the index pulses restored.
    """

    def __init__(self, bench: Bench) -> None:
        self._bits = bench.encoder.wrap_bits
        self._signed = bench.encoder.signed
        self._index_reset = bench.encoder.index_reset
        self._revolution = bench.encoder.counts_per_revolution
        self._resolution = bench.encoder.resolution
        self._period = bench.sample_period_s
        self._top_speed = (
            None if bench.mechanics.top_speed is None else bench.mechanics.top_speed.value
        )
        self._raw: float | None = None  # counter value of the last sample
        self._time = self._counts = self._step = 0.0
        self._index: float | None = None  # counter value set by index pulses
        self._start: float | None = None  # counts minus counter value at the last pulse
        self.jumps = PositionJumps(unwrapped=bench.encoder.period is not None)
        self.resets = 0
        self.lost = 0.0

    def follow(self, time: Vector, raw: Vector) -> Vector:
        """Return the unbounded counts (n,) of the next samples.

        time: times (n,) in s, increasing.
        raw: finite counter values (n,) within the range of the counter (`outside`).
        """
        if raw.size == 0:
            return raw.copy()
        if self._bits is not None and self._signed is not None:
            raw = folded(raw, self._bits, self._signed)
        if self._raw is None:
            self._raw = self._counts = float(raw[0])
            self._time = float(time[0]) - self._period
        steps = np.diff(raw, prepend=self._raw)
        if self._bits is not None:
            steps -= 2.0**self._bits * np.rint(steps / 2.0**self._bits)
        limit, long = self._too_long(steps, np.diff(time, prepend=self._time))
        if self._index_reset:
            long = self._reset(steps, raw, limit, long)
        self.jumps.take(time[long], steps[long], raw[long], float(limit.max()))
        counts: Vector = self._counts + np.cumsum(steps)
        self._raw = float(raw[-1])
        self._time = float(time[-1])
        self._counts = float(counts[-1])
        self._step = float(steps[-1])
        return counts

    def _too_long(self, steps: Vector, intervals: Vector) -> tuple[Vector, NDArray[np.bool_]]:
        if self._top_speed is not None:
            limit = allowance(self._top_speed, intervals, self._resolution)
            return limit, abrupt_jumps(steps, limit)
        isolated = isolated_jumps(steps)
        slack = float(np.abs(steps[~isolated]).max(initial=0.0)) + 2.0
        return np.full(steps.size, slack), isolated

    def _reset(
        self, steps: Vector, raw: Vector, limit: Vector, long: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        indices = np.flatnonzero(long)
        if indices.size == 0:
            return long
        if self._index is None:  # counter value at which most jumps end
            landings, slack = raw[indices], limit[indices]
            self._index = float(
                landings[np.argmax(np.sum(np.abs(landings[:, None] - landings) <= slack, axis=0))]
            )
        left = long.copy()
        # counts at the sample before the index `after`
        counts = self._counts
        after = 0
        for index in indices.tolist():
            if abs(raw[index] - self._index) > limit[index]:
                continue
            counts += float(steps[after:index].sum())
            expected = float(steps[index - 1]) if index else self._step
            start = counts + expected - float(raw[index])
            if self._start is not None and self._revolution is not None:
                whole = self._start + self._revolution * round(
                    (start - self._start) / self._revolution
                )
                self.lost += abs(start - whole) if abs(start - whole) > limit[index] else 0.0
                start = whole
            steps[index] = start + raw[index] - counts
            self._start = start
            after = index
            left[index] = False
            self.resets += 1
        return left

    def findings(self) -> tuple[str, ...]:
        """Return warnings about jumps and lost counts, one line each."""
        odd = []
        if self.lost:
            odd.append(
                f"the encoder lost {self.lost:.0f} counts; {self.resets} index pulses restored them"
            )
        jumps = self.jumps.text()
        return (*odd, jumps) if jumps else tuple(odd)
