"""Detection of positions that wrap: the sensor shows the position modulo a period.

The period is, for example, one turn or the range of a counter. At a wrap, the position jumps from
one end of the period to the other while the axis continues at constant speed. The period P is the
size of jumps that repeat while the axis continues to move. The position must stay within a range of
this size (repeated_jumps.py).

Natural periods are 2^b counts of the encoder and, on a rotary axis, half a turn and 2^b turns, with
a whole number b. A wrap is certain in these cases:

    natural period    the jump occurs three times. On a slow axis, or if the period is one turn, one
                      jump is enough
    other period      the drive cannot move the axis by the jump in one sample, and the jump occurs
                      three times. On a slow axis, two jumps are enough, or one jump if all jumps
                      lead from one end of the range [-P/2, P/2] to the other

If the motion is smaller than the noise, a wrap is certain under three conditions. The period is
natural. The drive cannot move the axis by the jump in one sample. At least three jumps connect the
ends of the range [0, P] or [-P/2, P/2].

An axis is slow if it moves by less than P/100 in the steps before and after the jump.
"""

from __future__ import annotations

from dataclasses import dataclass

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.logs.quality.jumps import JUMPS
from frictool.logs.quality.repeated_jumps import RepeatedJump, RepeatedJumps
from frictool.logs.quality.wrap_line import BITS, TURN, WrapLine
from frictool.typing import Vector

ROUNDING = 1e-9  # relative tolerance of a period that is known exactly
TURNS = (0.5, *(2.0**power for power in range(17)))  # natural periods in turns
SEVERAL = 3  # number of jumps that makes a wrap certain at any speed of the axis
TWICE = 2  # number of jumps that makes a wrap certain on a slow axis
NATURAL_SLACK = 1e-3  # a natural period may lie outside the bounds of P by this relative distance


@dataclass(frozen=True)
class Wrap:
    """Wrap of a position.

    period: period in rad or m.
    count: number of wraps.
    time: time of the first wrap in s.
    before, after: positions before and after the first wrap, in `unit`.
    line: line to add to the section `encoder` of `bench.yaml`.
    unit: unit of `before` and `after`.
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
        """Return the message that the position wraps, with the line to add to bench.yaml."""
        return f"the position wraps {self._jump}; write under encoder in bench.yaml: {self.line}"

    @property
    def question(self) -> str:
        """Return the message that a jump of the position may be a wrap."""
        return (
            f"{JUMPS} {self._jump}; if the sensor wraps, write under encoder in bench.yaml: "
            f"{self.line}; otherwise samples are missing"
        )

    @property
    def _jump(self) -> str:
        when = "once, at" if self.count == 1 else f"{self.count} times, first at"
        return f"{when} {self.time:.6g} s, from {self.before:.6g} to {self.after:.6g} {self.unit}"


class WrapSearch:
    """Search for wraps in a position, block after block.

    counted: True if the position was read in whole counts of the encoder. `wrap_bits` can remove a
        wrap only in this case.
    """

    def __init__(self, bench: Bench, counted: bool = False) -> None:
        periods = [bench.encoder.resolution * 2.0**bits for bits in BITS]
        if bench.axis == "rotary":
            periods += [TURN * turns for turns in TURNS]
        self._natural = sorted(periods)
        self._jumps = RepeatedJumps(bench)
        self._line = WrapLine(bench, counted)
        self._unit = si_unit("position", bench.axis)

    def take(self, time: Vector, position: Vector) -> None:
        """Add the next samples (n,): time in s, position in rad or m."""
        self._jumps.take(time, position)

    def finish(self) -> None:
        """Search the last samples; `take` must not be called afterwards."""
        self._jumps.finish()

    def result(self) -> Wrap | None:
        """Return the wrap of the position if the samples so far make it certain; else None."""
        jump = self._jumps.result()
        if jump is None:
            return self._noisy()
        return self._wrap(jump) if self._is_sure(jump) else None

    def _noisy(self) -> Wrap | None:
        for period in self._natural:
            for low in (0.0, -0.5 * period):
                jump = self._jumps.between(low, low + period)
                if jump is not None and jump.count >= SEVERAL and not jump.movable:
                    return self._wrap(jump)
        return None

    def possible(self) -> Wrap | None:
        """Return a repeated jump that may be a wrap or an effect of lost samples; else None."""
        jump = self._jumps.result()
        return None if jump is None or self._is_sure(jump) else self._wrap(jump)

    def _is_sure(self, jump: RepeatedJump) -> bool:
        natural = self._natural_period(jump)
        if natural is not None:
            return jump.forward >= SEVERAL or jump.slow or natural == TURN
        return not jump.movable and (
            jump.forward >= SEVERAL or (jump.slow and (jump.forward >= TWICE or jump.centred))
        )

    def _natural_period(self, jump: RepeatedJump) -> float | None:
        """Return the natural period, such as a turn, that fits a jump.

        The result is None if no natural period fits, or if a shorter period that is a round number
        in the log's unit also fits.
        """
        slack = NATURAL_SLACK * jump.high
        natural = next(
            (period for period in self._natural if jump.low - slack <= period <= jump.high + slack),
            None,
        )
        if natural is None or natural == TURN or self._line.counted:
            return natural
        return (
            None
            if self._line.is_round(max(jump.low, jump.reach), natural - 2.0 * slack)
            else natural
        )

    def _wrap(self, jump: RepeatedJump) -> Wrap:
        natural = self._natural_period(jump)
        low, high = jump.low, jump.high
        if natural is not None:
            low = natural * (1.0 - ROUNDING)
            high = natural * (1.0 + ROUNDING)
        elif not self._line.counted and self._line.is_round(low, high):
            low = high = self._line.round(low, high)
        time, before, after = jump.first
        return Wrap(
            0.5 * (low + high),
            jump.count,
            time,
            before,
            after,
            self._line.of(low, high),
            self._unit,
        )
