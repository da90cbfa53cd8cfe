"""Wear estimate of a unit at commissioning, and the ratio of later estimates to this estimate.

The wear is the friction of the unit divided by the friction of the model. Errors that the two
estimates have in common cancel in the ratio. Examples are a wrong actuator constant
(wear/constant_error.py), and a friction of the new unit that differs from the model by a factor.
FLOOR, the error of the model's friction over position and speed (wear/wear_estimator.py), cancels,
too. Because FLOOR is part of both intervals, the interval of the ratio is too wide.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from frictool.errors import InputFileError
from frictool.observe.wear_estimate import EstimateRange, WearEstimate


@dataclass(frozen=True)
class Commissioning:
    """Wear of a unit at commissioning, and the file from which the wear was read."""

    wear: EstimateRange
    source: str

    def ratio(self, estimate: WearEstimate) -> EstimateRange:
        """Return the wear of `estimate` divided by the wear at commissioning."""
        return estimate.wear.over(self.wear)


def commissioning_of_estimate(estimate: WearEstimate, source: str) -> Commissioning:
    """Return the wear at commissioning from the estimate for a unit's first log.

    Raises InputFileError if the estimate does not determine the wear.
    """
    if not estimate.moves or not estimate.wear.low > 0.0:
        raise InputFileError(
            source,
            f"does not determine the wear in {estimate.moves} moves; use a log with more moves",
        )
    return Commissioning(estimate.wear, source)


def read_commissioning(path: Path) -> Commissioning:
    """Read the wear at commissioning from a file with the JSON output of `observe run`.

    Raises InputFileError if the file cannot be read or has other contents.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        wear = EstimateRange(*(float(content["wear"][key]) for key in ("value", "low", "high")))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputFileError(
            path,
            f"is not output of `frictool observe run --json`: {type(error).__name__} {error}",
        ) from None
    if not 0.0 < wear.low <= wear.value <= wear.high:
        raise InputFileError(
            path,
            f"wear is {wear.value:g} in [{wear.low:g}, {wear.high:g}]; "
            "allowed: 0 < low <= value <= high",
        )
    return Commissioning(wear, str(path))
