"""Detection of positions that wrap: the sensor shows the position modulo a period (one turn, or the
range of a counter).

At a wrap the position goes from one end of the period to the other while the axis moves on at one
speed. Jumps that repeat themselves with one size, across which the axis moves on, and a range of
the position within that size show the period (`repeated_jumps.py`). A wrap is sure

    natural period    2^b counts of the encoder and, on a rotary axis, half a turn, one turn and 2^b
                      turns: if it occurs three times, or
                      once on a slow axis; one turn: if it occurs once
    other period      if the drive cannot move the axis that far in one sample, and it occurs three
                      times; on a slow axis, twice, or
                      once from one end of plus and minus half a period to the other

Slow means less than a hundredth of the period in the steps beside. A glitch goes there and back, a
lost count has another length, and a fast axis leaves the range.
"""

from __future__ import annotations

from dataclasses import dataclass

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.logs.log import Vector
from frictool.logs.quality.jumps import JUMPS
from frictool.logs.quality.repeated_jumps import RepeatedJump, RepeatedJumps
from frictool.logs.quality.wrap_line import BITS, TURN, WrapLine

ROUNDING = 1e-9  # relative: tolerance of a period that is known exactly
TURNS = (0.5, *(2.0**power for power in range(17)))
SEVERAL = 3  # this number of wraps is sure, however fast the axis
TWICE = 2  # this number is sure on a slow axis
NATURAL_SLACK = 1e-3  # relative difference of a natural period from the bounds of a jump


@dataclass(frozen=True)
class Wrap:
    """Wrap of a position: its period [rad | m], its number of occurrences, and time [s] and
    positions before and after the first.

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
        return f"the position wraps {self._jump} while the axis moves on; write under encoder in the bench: {self.line}"

    @property
    def question(self) -> str:
        """Return the text of a jump that may be a wrap."""
        return f"{JUMPS} {self._jump}; if the sensor wraps, write under encoder in the bench: {self.line}; else samples are lost"

    @property
    def _jump(self) -> str:
        when = "once, at" if self.count == 1 else f"{self.count} times, first at"
        return f"{when} {self.time:.6g} s, from {self.before:.6g} to {self.after:.6g} {self.unit}"


class WrapSearch:
    """Search for wraps in a position [rad | m] of one axis, block after block.

    counted: the position was read as whole counts of the encoder, so that `wrap_bits` mends a wrap
    of 2^b counts.
    """

    def __init__(self, bench: Bench, counted: bool = False) -> None:
        periods = [bench.encoder.resolution * 2.0**bits for bits in BITS]
        if bench.axis == "rotary":
            periods += [TURN * turns for turns in TURNS]
        self._natural = sorted(periods)
        self._jumps, self._line = RepeatedJumps(bench), WrapLine(bench, counted)
        self._unit = si_unit("position", bench.axis)

    def take(self, time: Vector, position: Vector) -> None:
        """Add samples (n,) that follow those before: s, and rad or m."""
        self._jumps.take(time, position)

    def finish(self) -> None:
        """Judge the last steps too; call it after the last samples."""
        self._jumps.finish()

    def found(self) -> Wrap | None:
        """Return the wrap of the steps judged so far, or None."""
        jump = self._jumps.found()
        return self._wrap(jump) if jump is not None and self._is_sure(jump) else None

    def possible(self) -> Wrap | None:
        """Return a jump of the steps judged so far that may be a wrap or may be lost samples, or
        None."""
        jump = self._jumps.found()
        return None if jump is None or self._is_sure(jump) else self._wrap(jump)

    def _is_sure(self, jump: RepeatedJump) -> bool:
        natural = self._natural_period(jump)
        if natural is not None:
            return jump.forward >= SEVERAL or jump.slow or natural == TURN
        return not jump.movable and (
            jump.forward >= SEVERAL or (jump.slow and (jump.forward >= TWICE or jump.centred))
        )

    def _natural_period(self, jump: RepeatedJump) -> float | None:
        """Return the natural period within the bounds of a jump; None if a round number lies below
        it and above the range."""
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
            low, high = natural * (1.0 - ROUNDING), natural * (1.0 + ROUNDING)
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
