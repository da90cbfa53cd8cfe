"""Jumps of a position that no motion explains: lost counts, counter overflow, index reset.

A step is the change of the position from one sample to the next. Its limit is two counts plus twice
the distance that the axis covers at top speed. A step is a jump if it exceeds this limit, and
differs from the steps before and after it by more than half of the limit. Twice the distance allows
for a servo that is faster than specified. In a motion that is still faster, successive steps are
nearly equal, and no step is a jump. If the top speed is unknown, a step is a jump if it meets three
conditions. The step is longer than 20 counts. The step is more than ten times as long as the steps
before and after it. The step is more than three times as long as the 99 % quantile of the steps in
the block.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.typing import Vector

SPEEDING = 2.0  # factor on the top speed
SLACK_COUNTS = 2.0  # counts added to the allowed step
WRAP_BITS = range(8, 33)  # bits that encoder.wrap_bits allows
ALONE = 10.0  # least ratio of an isolated step to its neighbours
RARE = 3.0  # least ratio of an isolated step to the quantile of all steps at level ORDINARY
ORDINARY = 0.99  # quantile level
JUMPS = "the position jumps"  # first words of a warning about jumps
FEWEST_WRAPS = 2  # least number of equal jumps that are wraps; a single jump may be lost counts
FEWEST_RESETS = 3  # least number of jumps to one value that are index resets


def allowance(top_speed: float, intervals: Vector, resolution: float) -> Vector:
    """Return the longest step (n,) in counts that motion can cause in each interval.

    top_speed: top speed of the axis in rad/s or m/s.
    intervals: times (n,) between successive samples in s.
    resolution: size of one count in rad or m.
    """
    return np.asarray(SPEEDING * top_speed * intervals / resolution + SLACK_COUNTS)


def abrupt_jumps(steps: Vector, limit: Vector) -> NDArray[np.bool_]:
    """Return a mask (n,) that is True at each jump of an axis whose top speed is known.

    - steps: differences (n,) of successive samples, counts
    - limit: longest steps (n,) that motion can cause (`allowance`), counts
    """
    changes = np.abs(np.diff(steps))
    before, after = np.append(np.inf, changes), np.append(changes, np.inf)
    return np.asarray((np.abs(steps) > limit) & (np.minimum(before, after) > limit / SPEEDING))


def isolated_jumps(steps: Vector) -> NDArray[np.bool_]:
    """Return a mask (n,) that is True at each jump; the top speed of the axis is not used.

    steps: differences (n,) of successive samples in counts.
    """
    size = np.abs(steps)
    if size.size < 3 or size.max() <= ALONE * SLACK_COUNTS:
        return np.zeros(size.size, dtype=np.bool_)
    neighbours = np.maximum(np.append(size[1:], size[-2]), np.insert(size[:-1], 0, size[1]))
    isolated = np.asarray(size > ALONE * np.maximum(neighbours, SLACK_COUNTS))
    return (
        isolated & (size > RARE * float(np.quantile(size, ORDINARY)))
        if isolated.any()
        else isolated
    )


@dataclass
class PositionJumps:
    """Jumps of one position signal, collected block after block.

    count: number of jumps.
    first_s, first_counts: time in s and length in counts of the first jump.
    shortest, longest: absolute lengths of the shortest and the longest jump in counts.
    lowest_landing, highest_landing: smallest and largest counter value after a jump.
    slack: largest part of a jump that may be motion of the axis, in counts.
    unwrapped: True if the wraps of the counter have already been removed.
    """

    count: int = 0
    first_s: float = math.nan
    first_counts: float = math.nan
    shortest: float = math.inf
    longest: float = 0.0
    lowest_landing: float = math.inf
    highest_landing: float = -math.inf
    slack: float = SLACK_COUNTS
    unwrapped: bool = False

    def take(self, time: Vector, steps: Vector, landings: Vector, slack: float) -> None:
        """Add m jumps.

        time: times (m,) of the jumps in s.
        steps: lengths (m,) of the jumps in counts.
        landings: counter values (m,) after the jumps.
        slack: largest part of a jump that may be motion of the axis, in counts.
        """
        if not steps.size:
            return
        if not self.count:
            self.first_s = float(time[0])
            self.first_counts = float(abs(steps[0]))
        self.count += int(steps.size)
        size = np.abs(steps)
        self.shortest = min(self.shortest, float(size.min()))
        self.longest = max(self.longest, float(size.max()))
        self.lowest_landing = min(self.lowest_landing, float(landings.min()))
        self.highest_landing = max(self.highest_landing, float(landings.max()))
        self.slack = max(self.slack, slack)

    @property
    def wrap_bits(self) -> int | None:
        """Return the number of bits of the counter if the jumps are counter overflows, else None.

        The jumps are overflows under two conditions. There are several jumps, and all are as long
        as the counter's range, within `slack`. The counter values after the jumps span at most this
        range, within `slack`.
        """
        if (
            self.count < FEWEST_WRAPS
            or self.highest_landing - self.lowest_landing > self.longest + self.slack
        ):
            return None
        bits = round(math.log2(max(self.longest, 1.0)))
        near = max(abs(self.shortest - 2.0**bits), abs(self.longest - 2.0**bits))
        return bits if bits in WRAP_BITS and near <= self.slack else None

    @property
    def index(self) -> float | None:
        """Return the counter value at which all jumps end, within `slack`.

        The result is None if the jumps end at different values, or if there are too few jumps.
        """
        if (
            self.count < FEWEST_RESETS
            or self.highest_landing - self.lowest_landing > 2.0 * self.slack
        ):
            return None
        return 0.5 * (self.lowest_landing + self.highest_landing)

    def text(self) -> str | None:
        """Return the number, the first and the likely cause of the jumps; None without jumps."""
        if not self.count:
            return None
        when = "once, at" if self.count == 1 else f"{self.count} times, first at"
        return (
            f"{JUMPS} {when} {self.first_s:.6g} s, by {self.first_counts:.0f} counts; {self.hint()}"
        )

    def hint(self) -> str:
        """Return the likely cause of the jumps, with the key of bench.yaml that may help."""
        bits = None if self.unwrapped else self.wrap_bits
        index = self.index
        if bits is not None:
            return f"does its counter wrap? then set encoder.wrap_bits, here to {bits}"
        if index is not None:
            return (
                f"each jump ends at about {index:.0f}: does an index pulse reset the counter? "
                "then set encoder.index_reset: true"
            )
        return "are counts lost? " + (
            "is mechanics.top_speed right?"
            if self.unwrapped
            else "does the sensor wrap (encoder.wrap)?"
        )
