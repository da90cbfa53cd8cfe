"""The line of a bench that states the period of a position that wraps, in the unit of the log or in
turns, whichever number is shorter."""

from __future__ import annotations

import math

from frictool.documents.bench import Bench
from frictool.documents.quantity import factor_to_si, si_unit

BITS = range(8, 33)  # of a counter, as encoder.wrap_bits allows
TURN = 2.0 * math.pi  # rad
DIGITS = 12  # of a period that no shorter number fits
ROUND = 2  # digits of a round number
COUNT, ANGLE, WHOLE = "count", "deg", "turn"


class WrapLine:
    """Writer of the line `wrap` or `wrap_bits` under `encoder`.

    counted: the position was read as whole counts of the encoder, so that `wrap_bits` mends a wrap
    of 2^b counts.
    """

    def __init__(self, bench: Bench, counted: bool) -> None:
        self._rotary, self._resolution, self.counted = (
            bench.axis == "rotary",
            bench.encoder.resolution,
            counted,
        )
        self._unit = si_unit("position", bench.axis)
        column = bench.columns.get("position")
        if column is not None and column.unit != COUNT:
            self._unit = column.unit
        self._factor = factor_to_si(self._unit, "position", bench.axis)

    def of(self, low: float, high: float) -> str:
        """Return the line of a period between two bounds in rad or m."""
        bits = next((one for one in BITS if low <= self._resolution * 2.0**one <= high), None)
        if self.counted and bits is not None:
            return f"wrap_bits: {bits}"
        digits, value = shortest(low / self._factor, high / self._factor)
        unit = self._unit
        if self.counted:
            digits, counts = shortest(low / self._resolution, high / self._resolution)
            value = f"{float(counts) * self._resolution / self._factor:.{DIGITS}g}"
        if self._rotary and self._unit not in (ANGLE, WHOLE):
            fewer, turns = shortest(low / TURN, high / TURN)
            if fewer < digits:
                value, unit = turns, WHOLE
        return f"wrap: {{value: {value}, unit: {unit}}}"

    def is_round(self, low: float, high: float) -> bool:
        """Return whether a number of two digits in the unit of the log lies between two bounds in
        rad or m."""
        return low < high and shortest(low / self._factor, high / self._factor)[0] <= ROUND

    def round(self, low: float, high: float) -> float:
        """Return that number in rad or m."""
        return float(shortest(low / self._factor, high / self._factor)[1]) * self._factor


def shortest(low: float, high: float) -> tuple[int, str]:
    """Return the number of digits and the text of the shortest positive decimal between two bounds;
    DIGITS at most.

    >>> shortest(24.98, 25.03), shortest(3.13, 3.15)
    ((2, '25'), (3, '3.14'))
    """
    middle = 0.5 * (low + high)
    for digits in range(1, DIGITS):
        text = f"{middle:.{digits}g}"
        if low <= float(text) <= high:
            return (
                digits,
                f"{float(text):.{digits}g}" if "e" not in text else f"{float(text):.{DIGITS}g}",
            )
    return DIGITS, f"{middle:.{DIGITS}g}"
