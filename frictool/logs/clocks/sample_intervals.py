"""Time base of a stream that is read block by block, without keeping its times.

The intervals are counted in classes; the bounds of a class differ by 0.1 %. The period is the mean
of the intervals in the class that contains the median. If all intervals are equal, the period is
exact.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.logs.canonical.mcap_layout import NS
from frictool.logs.quality.time_base import GAP, TimeBase
from frictool.logs.raw_table import Nanoseconds

WIDTH = math.log1p(1e-3)  # width of a class in ln(interval / ns)
CLASSES = math.ceil(math.log(2.0**63) / WIDTH) + 1


class SampleIntervals:
    """Statistics of the sample intervals of one stream, collected block after block."""

    def __init__(self) -> None:
        self.samples = 0
        self.first_ns = self.last_ns = 0
        self._longest = self._reference = 0
        self._counts = np.zeros(CLASSES)
        self._sums = np.zeros(CLASSES)  # ns, sum of interval - reference
        self._squares = np.zeros(CLASSES)  # ns^2, sum of (interval - reference)^2

    def add(self, time: Nanoseconds) -> None:
        """Add the next times (n,) in ns; all times of a stream must increase strictly."""
        if not time.size:
            return
        intervals = np.diff(time, prepend=self.last_ns) if self.samples else np.diff(time)
        if not self.samples:
            self.first_ns = int(time[0])
        self.samples += int(time.size)
        self.last_ns = int(time[-1])
        if not intervals.size:
            return
        self._reference = self._reference or int(intervals[0])
        shortest, longest = int(intervals.min()), int(intervals.max())
        self._longest = max(self._longest, longest)
        if shortest == longest == self._reference:
            self._counts[int(math.log(longest) / WIDTH)] += intervals.size
            return
        classes = (np.log(intervals) / WIDTH).astype(np.int64)
        beyond = (intervals - self._reference).astype(np.float64)
        lowest = int(classes.min())
        highest = int(classes.max()) + 1
        for kept, weights in (
            (self._counts, None),
            (self._sums, beyond),
            (self._squares, beyond**2),
        ):
            kept[lowest:highest] += np.bincount(classes - lowest, weights, highest - lowest)

    def base(self) -> TimeBase:
        """Return the time base of the samples so far.

        Rate and jitter are NaN if there is only one sample.
        """
        if self.samples < 2:
            return TimeBase(self.samples, math.nan, math.nan, 0, 0.0, 0.0)
        upto = np.cumsum(self._counts)
        # an even number of intervals has two medians
        middle = np.searchsorted(
            upto, [(self.samples - 2) // 2, (self.samples - 1) // 2], side="right"
        )
        period = (self._reference + float((self._sums[middle] / self._counts[middle]).mean())) / NS
        regular = slice(0, int(math.log(GAP * period * NS) / WIDTH) + 1)
        count = float(self._counts[regular].sum())
        mean = float(self._sums[regular].sum()) / count
        jitter = math.sqrt(max(0.0, float(self._squares[regular].sum()) / count - mean**2)) / NS
        gaps = round(self.samples - 1 - count)
        longest = self._longest / NS if gaps else 0.0
        return TimeBase(
            self.samples, 1.0 / period, jitter, gaps, longest, (self.last_ns - self.first_ns) / NS
        )
