"""Steps of a position that no axis makes: counts that were skipped, a counter that wraps, a counter
that an index pulse resets.

A step is a jump where it is longer than the allowance, twice what the top speed covers in its
interval and two counts more (a servo may be faster than its specification). Where no top speed is
known, it is one where it stands alone: ten times its neighbours, and three times what all but one
step in a hundred of the block are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.logs.log import Vector

SPEEDING = 2.0  # of the top speed
SLACK_COUNTS = 2.0
WRAP_BITS = range(8, 33)  # as encoder.wrap_bits allows
ALONE = 10.0  # times the steps beside it
RARE = 3.0  # times the step that ORDINARY of all steps do not exceed
ORDINARY = 0.99
JUMPS = "the position jumps"  # first words of the warning of jumps
FEWEST_WRAPS = 2  # jumps of one length before they are called wraps; one may be lost counts
FEWEST_RESETS = 3  # jumps to one value before it is called an index's


def allowance(top_speed: float, intervals: Vector, resolution: float) -> Vector:
    """The longest steps (n,) in counts within `intervals` (n,) in s; top speed in rad/s | m/s,
    resolution in rad | m of a count."""
    return np.asarray(SPEEDING * top_speed * intervals / resolution + SLACK_COUNTS)


def lone(steps: Vector) -> NDArray[np.bool_]:
    """True (n,) where a step of counts (n,) is so much longer than those beside it that no motion
    explains it."""
    size = np.abs(steps)
    if size.size < 3 or size.max() <= ALONE * SLACK_COUNTS:
        return np.zeros(size.size, dtype=np.bool_)
    beside = np.maximum(np.append(size[1:], size[-2]), np.insert(size[:-1], 0, size[1]))
    alone = np.asarray(size > ALONE * np.maximum(beside, SLACK_COUNTS))
    return alone & (size > RARE * float(np.quantile(size, ORDINARY))) if alone.any() else alone


@dataclass
class PositionJumps:
    """The jumps of one position, gathered block after block, all in counts but for the time of the
    first in s."""

    count: int = 0
    first_s: float = math.nan
    first_counts: float = math.nan
    shortest: float = math.inf
    longest: float = 0.0
    lowest_landing: float = math.inf
    highest_landing: float = -math.inf
    slack: float = SLACK_COUNTS
    unwrapped: bool = False  # the wraps of the counter have been undone before

    def take(self, time: Vector, steps: Vector, landings: Vector, slack: float) -> None:
        """Adds jumps (m,): when, how far, to which count of the counter; `slack`: what motion may
        have added to a step."""
        if not steps.size:
            return
        if not self.count:
            self.first_s, self.first_counts = float(time[0]), float(abs(steps[0]))
        self.count += int(steps.size)
        size = np.abs(steps)
        self.shortest, self.longest = (
            min(self.shortest, float(size.min())),
            max(self.longest, float(size.max())),
        )
        self.lowest_landing = min(self.lowest_landing, float(landings.min()))
        self.highest_landing = max(self.highest_landing, float(landings.max()))
        self.slack = max(self.slack, slack)

    @property
    def wrap_bits(self) -> int | None:
        """Return the bits of a counter that wraps: several jumps are as long as its range and land
        within it, up to the slack."""
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
        """The count to which every jump returns, within the slack, where there are enough to
        tell."""
        if (
            self.count < FEWEST_RESETS
            or self.highest_landing - self.lowest_landing > 2.0 * self.slack
        ):
            return None
        return 0.5 * (self.lowest_landing + self.highest_landing)

    def text(self) -> str | None:
        """One line: how many, the first, and what it may be; None where there is no jump."""
        if not self.count:
            return None
        when = "once, at" if self.count == 1 else f"{self.count} times, the first at"
        return (
            f"{JUMPS} {when} {self.first_s:.6g} s, by {self.first_counts:.0f} counts; {self.hint()}"
        )

    def hint(self) -> str:
        """What the jumps may be, and what to try."""
        bits, index = None if self.unwrapped else self.wrap_bits, self.index
        if bits is not None:
            return f"does its counter wrap? then set encoder.wrap_bits, here to {bits}"
        if index is not None:
            return f"each returns to about {index:.0f}: does an index pulse reset the counter? then set encoder.index_reset: true"
        return "are counts lost? " + (
            "is mechanics.top_speed right?"
            if self.unwrapped
            else "does the sensor wrap (encoder.wrap)?"
        )
