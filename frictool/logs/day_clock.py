"""Times of day without a date, continued after midnight.

If a time is more than half a day earlier than the previous time, midnight has passed.
"""

from __future__ import annotations

import numpy as np

from frictool.logs.canonical.mcap_layout import NS
from frictool.logs.raw_table import Nanoseconds

DAY = 86_400 * NS  # ns per day


class DayClock:
    """Converter of the times of day in a file to times that continue to increase after midnight.

    Times with a date, counted in ns from 1970-01-01, are returned unchanged.
    """

    def __init__(self) -> None:
        self._last: int | None = None  # last stamp as in the file
        self._days = 0

    def onward(self, stamps: Nanoseconds) -> Nanoseconds:
        """Return `stamps` (n,) [ns] plus one day for each midnight passed since the first row."""
        if not stamps.size or (self._last is None and not 0 <= stamps[0] < DAY):
            return stamps
        steps = np.diff(stamps, prepend=stamps[0] if self._last is None else self._last)
        days = np.full(stamps.size, self._days)
        for index in np.flatnonzero(np.abs(steps) > DAY // 2).tolist():
            days[index:] += 1 if steps[index] < 0 else -int(days[index] > 0)
        self._last, self._days = int(stamps[-1]), int(days[-1])
        onward: Nanoseconds = stamps + days * DAY
        return onward
