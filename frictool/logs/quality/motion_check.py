"""Check of a log's velocity against its position, and of the position against the encoder.

The velocity must be the change of the position over time. Its integral y is therefore compared with
the position x. Noise, encoder counts and the lag of a filter cause errors of both. If these errors
are not correlated, the ratio of y to x lies between two slopes (Frisch 1934):

    cov(x, y) / var x    regression of y on x; errors of x lower it
    var y / cov(x, y)    inverse of the regression of x on y; errors of y raise it

The log is divided into PARTS parts in which the axis moves equally far. Each part also contains the
REST points before and after it. Both slopes are computed in each part; their medians over the parts
are hardly affected by jumps of the position.
"""

from __future__ import annotations

import math

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.logs.log import Stream
from frictool.logs.quality.opening_samples import LONGEST
from frictool.logs.quality.quantisation import step_doubt
from frictool.typing import Vector

CLEAR = math.sqrt(2.0)  # least ratio, or inverse of the ratio, for a warning
PARTS = 8
MOST_POINTS = 512  # largest number of points, at equal distances in the log, at which y is compared
REST = 8  # number of points added before and after a part, because a filter delays the velocity
LEAST_CORRELATION = 0.9


def motion_doubts(stream: Stream, bench: Bench | None) -> tuple[str, ...]:
    """Return warnings about the scales of velocity and position, from the first samples."""
    signals = {name: values[:LONGEST] for name, values in stream.signals.items()}
    opening = Stream(stream.topic, stream.time[:LONGEST], signals, stream.units)
    if "position" not in signals:
        return ()
    steps = None if bench is None else step_doubt(signals["position"], bench)
    return tuple(text for text in (_scale_doubt(opening), steps) if text)


def _scale_doubt(stream: Stream) -> str | None:
    """Return a warning if the velocity is not the change of the position over time, else None."""
    signals, units = stream.signals, stream.units
    # without a bench, a log has the units of its file
    if "velocity" not in signals or units["velocity"] != f"{units['position']}/s":
        return None
    low, high = velocity_ratio(stream.time, signals["position"], signals["velocity"])
    if not (low > CLEAR or high < 1.0 / CLEAR):
        return None
    ratio = f"{math.sqrt(low * high):.3g}"
    return (
        f"the velocity is {ratio} times the change of the position over time: divide "
        f"columns.velocity.scale by {ratio} (a gear ratio or a unit?), or correct position or time"
    )


def velocity_ratio(time: Vector, position: Vector, velocity: Vector) -> tuple[float, float]:
    """Return bounds of the ratio of the velocity to the change of the position over time.

    time, position, velocity: samples (n,).

    The bounds are 0 and infinity if position and integral of the velocity are hardly correlated.
    """
    every = max(1, position.size // MOST_POINTS)
    x = position[::every]
    y = scipy.integrate.cumulative_trapezoid(velocity, time, initial=0.0)[::every]
    path = np.cumsum(np.abs(np.diff(x, prepend=x[0])))
    edges = path[-1] * np.linspace(0.0, 1.0, PARTS + 1)
    first = np.maximum(np.searchsorted(path, edges[:-1]) - REST, 0)
    last = np.searchsorted(path, edges[1:], side="right") + REST
    slopes = [_slopes(x[low:high], y[low:high]) for low, high in zip(first, last, strict=True)]
    low, high, correlation = np.median(slopes, axis=0).tolist()
    return (low, high) if correlation > LEAST_CORRELATION else (0.0, math.inf)


def _slopes(x: Vector, y: Vector) -> tuple[float, float, float]:
    """Return both slopes and the correlation; the correlation is 0 if it is undefined."""
    x, y = x - np.mean(x), y - np.mean(y)
    xx, xy, yy = float(x @ x), float(x @ y), float(y @ y)
    if not xy > 0.0:
        return 0.0, math.inf, 0.0
    return xy / xx, yy / xy, xy / math.sqrt(xx * yy)
