"""How the clocks of two instruments run against each other.

    both clocks date the same messages    the received time is the sent one, an offset, a drift and
                                          a delay that is never negative: the
                                          line below all points that lies closest to them, an edge
                                          of their lower convex hull
    both instruments measure one signal   in each of several windows the lag at which the two are
                                          most alike, first by cross-correlation,
                                          then what is left of it by least squares, y(t) - x(t) =
                                          -lag x'(t); the lags lie on a line (Theil and Sen's)

One offset of two whole records, with its interval, is clock_offset.py's; here a window needs its
lag only, in a fraction of the time.

An offset of x s says that what one clock calls t the other calls t + x; a drift of d that it gains
d s in a second.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from frictool.logs.canonical.mcap_layout import NS
from frictool.logs.log import Stream, Vector
from frictool.logs.quality.opening_samples import LONGEST
from frictool.logs.table import Nanoseconds

WINDOWS = 12
FEWEST_SAMPLES = 64  # of a window
LONGEST_LAG = 0.25  # of a window
ALIKE = 0.8  # least correlation of a window that tells a lag
SMOOTH = 64  # of a window: a moving mean over one part in so many
PASSES = 4
FEWEST_MESSAGES = 100
CLEAR = (
    3.0  # times the delays beyond the shortest: a drift over the whole time that is less is none
)
FEWEST = 3  # windows that tell a drift; one or two tell an offset


LagOf = Callable[[Vector, Vector], tuple[float, float]]


@dataclass(frozen=True)
class ClockDrift:
    """offset in s, at the middle of what was looked at; drift in s/s, None where too little tells
    it; windows: how many were used.

    spread: the largest distance of a window's lag from the line, s; of messages, the mean delay
    beyond the shortest.
    """

    offset: float
    drift: float | None
    windows: int
    spread: float


def of_messages(sent: Nanoseconds, received: Nanoseconds) -> ClockDrift | None:
    """The receiver's clock against the sender's, (n,) ns each, of messages in order; None where
    there are fewer than 2 sent times."""
    middle, first = (
        int((int(sent[0]) + int(sent[-1])) // 2) if sent.size else 0,
        int(received[0] - sent[0]) if sent.size else 0,
    )
    x, y = (sent - middle).astype(np.float64), (received - sent - first).astype(np.float64)
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
    left, right = hull[edge - 1], hull[edge]
    slope = float((y[right] - y[left]) / (x[right] - x[left]))
    below = float(y[left] - slope * x[left])
    return ClockDrift(
        (first + below) / NS, slope, int(sent.size), float(np.mean(y - slope * x - below)) / NS
    )


class ClockPair:
    """The messages that two clocks have dated, the first LONGEST of them, block after block."""

    def __init__(self) -> None:
        self._sent: list[Nanoseconds] = []
        self._received: list[Nanoseconds] = []

    def take(self, sent: Nanoseconds, received: Nanoseconds) -> None:
        """Adds messages (n,): when they were sent by the one clock and received by the other, in
        ns."""
        if sum(part.size for part in self._sent) < LONGEST:
            self._sent.append(sent)
            self._received.append(received)

    def finding(self, clock: str | None, period: float) -> str | None:
        """One line where the clocks drift apart by more than a period [s], and by more than the
        delays could feign."""
        sent = np.concatenate(self._sent) if self._sent else np.empty(0, np.int64)
        found = (
            of_messages(sent, np.concatenate(self._received))
            if sent.size >= FEWEST_MESSAGES
            else None
        )
        if found is None or found.drift is None:
            return None
        apart = found.drift * float(np.ptp(sent)) / NS
        if abs(apart) <= max(period, CLEAR * found.spread):
            return None
        runs = f"the recorder's clock gains {1e6 * found.drift:.4g} us in a second on {clock}, {apart:.4g} s over these messages"
        return f"{runs}; the log is dated by {clock}"


def of_streams(one: Stream, other: Stream, name: str) -> ClockDrift | None:
    """The clock of `other` against that of `one` by a signal that both have; None where they are
    not alike for long enough."""
    period = max(one.period, other.period)
    low, high = max(one.time[0], other.time[0]), min(one.time[-1], other.time[-1])
    if not high - low > FEWEST_SAMPLES * period:
        return None
    grid = np.arange(low, high, period)
    ours = np.interp(grid, one.time, one.signals[name])
    since = grid - 0.5 * (grid[0] + grid[-1])
    found: ClockDrift | None = None
    for number in range(PASSES):
        ahead = (
            np.zeros(grid.size) if found is None else found.offset + (found.drift or 0.0) * since
        )
        theirs = np.interp(grid + ahead, other.time, other.signals[name])
        found = _line(grid, ahead, ours, theirs, _small_lag if number else _lag)
        if found is None:
            return None
    return found


def _line(
    grid: Vector, ahead: Vector, ours: Vector, theirs: Vector, lag_of: LagOf
) -> ClockDrift | None:
    """The line through the lags of the windows, where `theirs` (n,) was taken `ahead` (n,) s after
    the times of `ours` (n,)."""
    period, rows = float(grid[1] - grid[0]), max(FEWEST_SAMPLES, grid.size // WINDOWS)
    mean = np.full(
        max(1, rows // SMOOTH), 1.0 / max(1, rows // SMOOTH)
    )  # against noise, in both alike, so that it shifts nothing
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
    """By how many samples `other` (n,) comes after `one` (n,), and the correlation there."""
    one, other = one - one.mean(), other - other.mean()
    scale = float(np.linalg.norm(one) * np.linalg.norm(other))
    if scale == 0.0:
        return 0.0, 0.0
    size, most = 2 * one.size, int(LONGEST_LAG * one.size)
    product = np.fft.irfft(np.conj(np.fft.rfft(one, size)) * np.fft.rfft(other, size), size)
    around = np.concatenate((product[-most:], product[: most + 1])) / scale
    # fewer samples overlap at a lag: without this every maximum would lie too near to 0
    around *= one.size / (one.size - np.abs(np.arange(-most, most + 1)))
    best = int(np.argmax(around))
    return float(best - most), float(around[best])


def _small_lag(one: Vector, other: Vector) -> tuple[float, float]:
    """As `_lag`, of signals that nearly agree, to a fraction of a sample; each may have a scale and
    an offset of its own."""
    spread = float(np.std(one)) * float(np.std(other))
    if spread == 0.0:
        return 0.0, 0.0
    one, other = (one - one.mean()) / np.std(one), (other - other.mean()) / np.std(other)
    slope = 0.5 * np.gradient(one + other)
    return -float(np.sum(slope * (other - one)) / np.sum(slope**2)), float(np.mean(one * other))


def _slope(at: Vector, lags: Vector) -> float:
    """The median of the slopes of all pairs."""
    first, second = np.triu_indices(at.size, 1)
    return float(np.median((lags[second] - lags[first]) / (at[second] - at[first])))
