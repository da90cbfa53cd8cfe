"""Unwrapping of positions and references that a sensor shows modulo a period, block by block.

At a wrap, the shown value y jumps by about the period P, although the position x changes by less
than P/2. A step of y does not determine the step of x, because steps of x that differ by a multiple
of P look equal in y. The shortest possible step of x is assumed:

    x[k] = y[k] - P n[k],   n[k] = n[k-1] + round((y[k] - y[k-1]) / P)

The period is `encoder.wrap` or, for a position that is not in counts, the range of a counter of
`encoder.wrap_bits` bits. If a position wraps although bench.yaml has neither key, LogError is
raised (quality/wrap_detection.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.quality.wrap_detection import WrapSearch
from frictool.typing import Vector

POSITION, REFERENCE = "position", "reference"
SLACK = 0.01  # tolerance of the range of the values, relative to the period


class PeriodicSignal:
    """Unwrapping of one signal with the period `period`, which is in the unit of the signal."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._last: float | None = None
        self._turns = 0.0
        self._low = math.inf
        self._high = -math.inf

    def follow(self, shown: Vector) -> Vector:
        """Return the next samples `shown` (n,) without wraps.

        Raises ValueError if the values cover more than one period and a step exceeds half a period,
        because the period is then wrong.
        """
        if not shown.size:
            return shown
        steps = np.diff(shown, prepend=shown[0] if self._last is None else self._last)
        turns = self._turns + np.cumsum(np.rint(steps / self._period))
        self._low = min(self._low, float(shown.min()))
        self._high = max(self._high, float(shown.max()))
        if turns.any() and self._high - self._low > (1.0 + SLACK) * self._period:
            raise ValueError(
                f"found values from {self._low:.6g} to {self._high:.6g}, "
                f"a range above one period of {self._period:.6g}"
            )
        self._last, self._turns = float(shown[-1]), float(turns[-1])
        return shown - self._period * turns


class Unwrapping:
    """Unwrapping of the position and the reference of one stream.

    source: name of the file for messages.
    bench: bench with the keys `encoder.wrap` and `encoder.wrap_bits`.
    columns: name of each channel's column in the file.
    count: size of one count of the position in rad or m; None if the position is not in counts.
    """

    def __init__(
        self, source: str, bench: Bench, columns: Mapping[str, str], count: float | None
    ) -> None:
        self._source, self._bench, self._columns = source, bench, columns
        encoder = bench.encoder
        periods: dict[str, float] = {}
        if encoder.period is not None:
            periods = {name: encoder.period for name in (POSITION, REFERENCE) if name in columns}
            if count is not None and encoder.wrap is not None:
                periods[POSITION] = encoder.wrap.value / abs(count)
            elif count is not None:  # encoder.py removes the wraps of a counter with wrap_bits
                periods.pop(POSITION, None)
        self._periodic = {name: PeriodicSignal(period) for name, period in periods.items()}
        self._wraps = WrapSearch(
            bench, count is not None and math.isclose(abs(count), encoder.resolution)
        )

    def follow(self, channel: str, shown: Vector) -> Vector:
        """Return the next samples (n,) of a channel without wraps.

        shown: raw values (n,): counts if the position is in counts, else rad or m.

        Raises LogError if the values cover more than one period, because the period is then wrong.
        """
        if channel not in self._periodic:
            return shown
        try:
            return self._periodic[channel].follow(shown)
        except ValueError as error:
            key = "wrap" if self._bench.encoder.wrap is not None else "wrap_bits"
            allowed = f"values within the period encoder.{key} of bench {self._bench.name!r}"
            raise LogError(
                self._source, f"column {self._columns[channel]!r}: {error}; allowed: {allowed}"
            ) from None

    def check(self, time: Vector, position: Vector) -> None:
        """Raise LogError if the next positions contain a wrap that bench.yaml does not declare.

        time: times (n,) in s.
        position: positions (n,) in rad or m.
        """
        self._wraps.take(time, position)
        self._refuse()

    def finish(self) -> None:
        """Check the last samples of the position, as `check` does."""
        self._wraps.finish()
        self._refuse()

    @property
    def question(self) -> str | None:
        """Return a warning about a jump that may be a wrap; None if there is no such jump."""
        wrap = self._wraps.possible()
        return None if wrap is None else wrap.question

    def _refuse(self) -> None:
        wrap = self._wraps.result()
        if wrap is not None:
            raise LogError(self._source, f"column {self._columns[POSITION]!r}: {wrap.text}")
