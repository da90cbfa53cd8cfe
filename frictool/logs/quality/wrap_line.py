"""Line of `bench.yaml` that states the period at which a position wraps.

The period is written in the unit of the log, or in turns if this gives fewer digits.
"""

from __future__ import annotations

import math

from frictool.documents.bench import Bench
from frictool.documents.quantity import factor_to_si, si_unit

BITS = range(8, 33)  # bits of a counter that encoder.wrap_bits allows
TURN = 2.0 * math.pi  # rad
DIGITS = 12  # maximum number of digits of a period
ROUND = 2  # maximum number of digits of a number that counts as round
COUNT, ANGLE, WHOLE = "count", "deg", "turn"


class WrapLine:
    """Writer of the key `wrap` or `wrap_bits` for the section `encoder` of `bench.yaml`.

    counted: True if the position was read in whole counts of the encoder. Only then is the
        key `wrap_bits` possible.
    """

    def __init__(self, bench: Bench, counted: bool) -> None:
        self._rotary = bench.axis == "rotary"
        self._resolution = bench.encoder.resolution
        self.counted = counted
        self._unit = si_unit("position", bench.axis)
        column = bench.columns.get("position")
        if column is not None and column.unit != COUNT:
            self._unit = column.unit
        self._factor = factor_to_si(self._unit, "position", bench.axis)

    def of(self, low: float, high: float) -> str:
        """Return the line of bench.yaml for a wrap period between `low` and `high` [rad or m]."""
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
        """Return True if a round number of the log's unit lies between two bounds [rad or m]."""
        return low < high and shortest(low / self._factor, high / self._factor)[0] <= ROUND

    def round(self, low: float, high: float) -> float:
        """Return the number between two bounds that has the fewest digits in the log's unit.

        low, high: bounds in rad or m. The result is also in rad or m.
        """
        return float(shortest(low / self._factor, high / self._factor)[1]) * self._factor


def shortest(low: float, high: float) -> tuple[int, str]:
    """Return (number of digits, text) of the shortest decimal number between two bounds.

    low, high: positive bounds. The number has at most DIGITS digits.

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
