"""An encoder's counter to counts without end, block after block.

    n        what the counter shows, modulo 2^b where it has b bits, signed or not
    wrap     d[k] = n[k] - n[k-1],  d <- d - 2^b round(d / 2^b): a real step is less than half the
             range
    index    a pulse sets the counter to one value once a revolution: counts = n + start, and from
             one pulse to the next
             `start` moves by a whole number of revolutions, so that counts lost in between are made
             good

What is left over and longer than the top speed allows are skipped counts; they are counted, not
repaired: nobody knows their sign.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.logs.log import Vector
from frictool.logs.quality.jumps import PositionJumps, allowance, lone

EXTENDED = (
    16,
    24,
    32,
)  # bits of the registers to which a negative count may have been sign-extended before it was read as unsigned


def outside(raw: Vector, bits: int) -> int | None:
    """The first of `raw` (n,) that no counter of so many bits shows, read as signed, as unsigned,
    or sign-extended; None where all fit."""
    modulus = 2.0**bits
    fits = (raw >= -modulus / 2.0) & (raw < modulus)
    for register in EXTENDED:
        fits |= (raw >= 2.0**register - modulus / 2.0) & (raw < 2.0**register)
    bad = np.flatnonzero(~fits)
    return int(bad[0]) if bad.size else None


def folded(raw: Vector, bits: int, signed: bool) -> Vector:
    """Counts (n,) as a counter of so many bits shows them, in [-2^(b-1), 2^(b-1)) where signed,
    else in [0, 2^b)."""
    low = -(2.0 ** (bits - 1)) if signed else 0.0
    return np.asarray(np.mod(raw - low, 2.0**bits) + low)


class EncoderCounter:
    """The counter of a bench's encoder, as far as it has been followed.

    jumps: the steps that are neither a wrap nor a reset, too long for the axis. resets: how often
    an index pulse has set the counter. lost: counts that the index pulses made good.
    """

    def __init__(self, bench: Bench) -> None:
        self._bits, self._signed, self._index_reset = (
            bench.encoder.wrap_bits,
            bench.encoder.signed,
            bench.encoder.index_reset,
        )
        self._revolution = bench.encoder.counts_per_revolution
        self._resolution, self._period = bench.encoder.resolution, bench.sample_period_s
        self._top_speed = (
            None if bench.mechanics.top_speed is None else bench.mechanics.top_speed.value
        )
        self._raw: float | None = None  # of the last sample
        self._time = self._counts = self._step = 0.0
        self._index: float | None = None  # the count to which pulses set the counter
        self._start: float | None = None  # counts minus the counter at the last pulse
        self.jumps, self.resets, self.lost = (
            PositionJumps(unwrapped=bench.encoder.period is not None),
            0,
            0.0,
        )

    def follow(self, time: Vector, raw: Vector) -> Vector:
        """The counts (n,) of the counter's next samples: time (n,) in s, increasing; raw (n,)
        finite and within `outside`."""
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
        self._raw, self._time, self._counts, self._step = (
            float(raw[-1]),
            float(time[-1]),
            float(counts[-1]),
            float(steps[-1]),
        )
        return counts

    def _too_long(self, steps: Vector, intervals: Vector) -> tuple[Vector, NDArray[np.bool_]]:
        """The longest steps (n,) that pass for motion, in counts, and where (n,) a step is
        longer."""
        if self._top_speed is not None:
            limit = allowance(self._top_speed, intervals, self._resolution)
            return limit, np.abs(steps) > limit
        alone = lone(steps)
        slack = float(np.abs(steps[~alone]).max(initial=0.0)) + 2.0
        return np.full(steps.size, slack), alone

    def _reset(
        self, steps: Vector, raw: Vector, limit: Vector, long: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Takes the pulses' jumps out of `steps` (n,), in place; returns where (n,) steps too long
        are left."""
        places = np.flatnonzero(long)
        if places.size == 0:
            return long
        if self._index is None:  # the value to which most jumps return
            landings, slack = raw[places], limit[places]
            self._index = float(
                landings[np.argmax(np.sum(np.abs(landings[:, None] - landings) <= slack, axis=0))]
            )
        left = long.copy()
        counts, after = self._counts, 0  # of the sample before `after`
        for place in places.tolist():
            if abs(raw[place] - self._index) > limit[place]:
                continue
            counts += float(steps[after:place].sum())
            expected = float(steps[place - 1]) if place else self._step
            start = counts + expected - float(raw[place])
            if self._start is not None and self._revolution is not None:
                whole = self._start + self._revolution * round(
                    (start - self._start) / self._revolution
                )
                self.lost += abs(start - whole) if abs(start - whole) > limit[place] else 0.0
                start = whole
            steps[place] = start + raw[place] - counts
            self._start, after, left[place] = start, place, False
            self.resets += 1
        return left

    def findings(self) -> tuple[str, ...]:
        """What is odd about the counter, one line each, for people."""
        odd = []
        if self.lost:
            odd.append(
                f"the encoder lost {self.lost:.0f} counts, which its index pulses made good ({self.resets} of them)"
            )
        jumps = self.jumps.text()
        return (*odd, jumps) if jumps else tuple(odd)
