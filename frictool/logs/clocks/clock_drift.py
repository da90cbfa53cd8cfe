"""Offset and drift between the clocks of two instruments.

    both clocks stamp the same messages   received time = sent time + offset + drift t + delay; the
                                          delay is never negative. The closest line below all points
                                          gives offset and drift. This line is an edge of the lower
                                          convex hull of the points.
    both instruments measure one signal   Each of several windows gives the lag of the second record
                                          y behind the first record x: the lag with the highest
                                          cross-correlation, refined by least squares of y(t) - x(t)
                                          = -lag x'(t). A Theil-Sen line through the lags gives
                                          offset and drift.

clock_offset.py estimates a constant offset between two whole records, with its confidence interval.

With an offset of b seconds, the second clock shows t + b when the first shows t. With a drift of d,
the second clock gains d seconds per second.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from frictool.logs.canonical.mcap_layout import NS
from frictool.logs.log import Stream
from frictool.logs.quality.opening_samples import LONGEST
from frictool.logs.raw_table import Nanoseconds
from frictool.typing import Vector

WINDOWS = 12  # number of windows of a long record
FEWEST_SAMPLES = 64  # least number of samples of a window
LONGEST_LAG = 0.25  # largest lag, relative to the length of a window
ALIKE = 0.8  # least correlation of a window whose lag is used
SMOOTH = 64  # length of a window, relative to the length of the moving mean
PASSES = 4  # number of refinements of offset and drift
FEWEST_MESSAGES = 100  # least number of messages for a warning
CLEAR = 3.0  # least total drift, relative to the mean delay minus the shortest delay
FEWEST = 3  # least number of windows for a drift; one or two windows give only an offset


LagOf = Callable[[Vector, Vector], tuple[float, float]]


@dataclass(frozen=True)
class ClockDrift:
    """Offset and drift of a second clock relative to a first clock.

    offset: second clock minus first clock in s, at the middle of the evaluated time.
    drift: change of this difference per second [s/s]; None if there are too few windows.
    windows: number of windows or messages used.
    spread: for windows, the largest distance in s of a lag from the fitted line; for messages, the
        mean delay minus the shortest delay, in s.
    """

    offset: float
    drift: float | None
    windows: int
    spread: float


def of_messages(sent: Nanoseconds, received: Nanoseconds) -> ClockDrift | None:
    """Return offset and drift of the receiver's clock relative to the sender's clock.

    sent, received: times (n,) in ns of the messages, in order.

    The result is None if all messages were sent at the same time.
    """
    middle = int((int(sent[0]) + int(sent[-1])) // 2) if sent.size else 0
    first = int(received[0] - sent[0]) if sent.size else 0
    x = (sent - middle).astype(np.float64)
    y = (received - sent - first).astype(np.float64)
    hull: list[int] = []
    for k in np.lexsort((y, x)).tolist():
        if hull and x[k] == x[hull[-1]]:
            continue
        while len(hull) > 1 and (y[hull[-1]] - y[hull[-2]]) * (x[k] - x[hull[-2]]) >= (
            y[k] - y[hull[-2]]
        ) * (x[hull[-1]] - x[hull[-2]]):
            hull.pop()
        hull.append(k)
    if len(hull) < 2:
        return None
    edge = min(max(int(np.searchsorted(x[hull], x.mean())), 1), len(hull) - 1)
    left = hull[edge - 1]
    right = hull[edge]
    slope = float((y[right] - y[left]) / (x[right] - x[left]))
    below = float(y[left] - slope * x[left])
    return ClockDrift(
        (first + below) / NS, slope, int(sent.size), float(np.mean(y - slope * x - below)) / NS
    )


class ClockPair:
    """Collector of the first messages with the times of two clocks, until LONGEST are kept."""

    def __init__(self) -> None:
        self._sent: list[Nanoseconds] = []
        self._received: list[Nanoseconds] = []

    def take(self, sent: Nanoseconds, received: Nanoseconds) -> None:
        """Add messages (n,) with the times in ns at which they were sent and received."""
        if sum(part.size for part in self._sent) < LONGEST:
            self._sent.append(sent)
            self._received.append(received)

    def finding(self, clock: str | None, period: float) -> str | None:
        """Return a warning if the clocks drift apart, else None.

        clock: name of the sender's clock.
        period: sample period in s. There is no warning if the clocks drift apart by less than this
            period during the whole log.

        There is also no warning if varying delays of the messages can explain the drift.
        """
        sent = np.concatenate(self._sent) if self._sent else np.empty(0, np.int64)
        drift = (
            of_messages(sent, np.concatenate(self._received))
            if sent.size >= FEWEST_MESSAGES
            else None
        )
        if drift is None or drift.drift is None:
            return None
        apart = drift.drift * float(np.ptp(sent)) / NS
        if abs(apart) <= max(period, CLEAR * drift.spread):
            return None
        runs = (
            f"the recorder's clock gains {1e6 * drift.drift:.4g} us per second relative to "
            f"{clock}, {apart:.4g} s during the log"
        )
        return f"{runs}; the log has the times of {clock}"


def of_streams(one: Stream, other: Stream, name: str) -> ClockDrift | None:
    """Return offset and drift of the clock of `other` relative to the clock of `one`.

    The signal `name`, which both streams contain, is compared. The result is None if the time in
    which both records overlap and correlate is too short.
    """
    period = max(one.period, other.period)
    low, high = max(one.time[0], other.time[0]), min(one.time[-1], other.time[-1])
    if not high - low > FEWEST_SAMPLES * period:
        return None
    grid = np.arange(low, high, period)
    ours = np.interp(grid, one.time, one.signals[name])
    since = grid - 0.5 * (grid[0] + grid[-1])
    drift: ClockDrift | None = None
    for number in range(PASSES):
        ahead = (
            np.zeros(grid.size) if drift is None else drift.offset + (drift.drift or 0.0) * since
        )
        theirs = np.interp(grid + ahead, other.time, other.signals[name])
        drift = _line(grid, ahead, ours, theirs, _small_lag if number else _lag)
        if drift is None:
            return None
    return drift


def _line(
    grid: Vector, ahead: Vector, ours: Vector, theirs: Vector, lag_of: LagOf
) -> ClockDrift | None:
    period = float(grid[1] - grid[0])
    rows = max(FEWEST_SAMPLES, grid.size // WINDOWS)
    # noise filter; the same for both signals, so that it shifts neither
    mean = np.full(max(1, rows // SMOOTH), 1.0 / max(1, rows // SMOOTH))
    ours, theirs = np.convolve(ours, mean, "same"), np.convolve(theirs, mean, "same")
    used = []
    for start in range(0, grid.size - rows + 1, rows):
        window = slice(start, start + rows)
        lag, alike = lag_of(ours[window], theirs[window])
        if alike >= ALIKE:
            used.append((float(grid[window].mean()), lag * period + float(ahead[window].mean())))
    if not used:
        return None
    at, lags = np.array(used).T
    slope = _slope(at, lags) if at.size >= FEWEST else None
    residual = lags - (slope or 0.0) * (at - 0.5 * (grid[0] + grid[-1]))
    offset = float(np.median(residual))
    return ClockDrift(offset, slope, int(at.size), float(np.max(np.abs(residual - offset))))


def _lag(one: Vector, other: Vector) -> tuple[float, float]:
    """Return (lag of `other` behind `one` in samples, correlation at this lag); signals (n,)."""
    one, other = one - one.mean(), other - other.mean()
    scale = float(np.linalg.norm(one) * np.linalg.norm(other))
    if scale == 0.0:
        return 0.0, 0.0
    size = 2 * one.size
    most = int(LONGEST_LAG * one.size)
    product = np.fft.irfft(np.conj(np.fft.rfft(one, size)) * np.fft.rfft(other, size), size)
    around = np.concatenate((product[-most:], product[: most + 1])) / scale
    # fewer samples overlap at a larger lag: without this correction, the best lag would be too
    # small
    around *= one.size / (one.size - np.abs(np.arange(-most, most + 1)))
    best = int(np.argmax(around))
    return float(best - most), float(around[best])


def _small_lag(one: Vector, other: Vector) -> tuple[float, float]:
    spread = float(np.std(one)) * float(np.std(other))
    if spread == 0.0:
        return 0.0, 0.0
    one, other = (one - one.mean()) / np.std(one), (other - other.mean()) / np.std(other)
    slope = 0.5 * np.gradient(one + other)
    return -float(np.sum(slope * (other - one)) / np.sum(slope**2)), float(np.mean(one * other))


def _slope(at: Vector, lags: Vector) -> float:
    first, second = np.triu_indices(at.size, 1)
    return float(np.median((lags[second] - lags[first]) / (at[second] - at[first])))
