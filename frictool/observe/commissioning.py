"""A unit's estimate at commissioning, and the ratio of a later one to it: what both share is not in
it.

Shared is the actuator's constant, which scales both alike (wear/constant_error.py), and a friction
that is not the model's, as long as it keeps its shape. What the model's shape over position and
speed leaves (the floor of an interval) is shared too; its part in either interval is not taken out,
so that the ratio's interval is rather too wide.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from frictool.errors import InputFileError
from frictool.observe.estimate import EstimateRange, WearEstimate


@dataclass(frozen=True)
class Commissioning:
    """The wear that a unit had, and where that is from."""

    wear: EstimateRange
    source: str

    def ratio(self, estimate: WearEstimate) -> EstimateRange:
        """Of the wear now to the wear then."""
        return estimate.wear.over(self.wear)


def commissioning_of_estimate(estimate: WearEstimate, source: str) -> Commissioning:
    """From the estimate of the unit's first log. Raises InputFileError where it tells no wear."""
    if not estimate.moves or not estimate.wear.low > 0.0:
        raise InputFileError(
            source,
            f"tells no wear to compare with: {estimate.moves} moves; a commissioning log needs some",
        )
    return Commissioning(estimate.wear, source)


def read_commissioning(path: Path) -> Commissioning:
    """From the --json of the run along the unit's first log. Raises InputFileError where it is
    none."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        wear = EstimateRange(*(float(found["wear"][key]) for key in ("value", "low", "high")))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputFileError(
            path, f"is no --json of `frictool observe run`: {type(error).__name__} {error}"
        ) from None
    if not 0.0 < wear.low <= wear.value <= wear.high:
        raise InputFileError(
            path,
            f"wear is {wear.value:g} in [{wear.low:g}, {wear.high:g}]; allowed: 0 < low <= value <= high",
        )
    return Commissioning(wear, str(path))
