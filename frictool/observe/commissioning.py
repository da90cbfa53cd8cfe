"""Wear estimate of a unit at commissioning, and the ratio of a later one to it.

Errors that both estimates share cancel in the ratio. Two such errors are a wrong actuator constant,
which scales both estimates alike (wear/constant_error.py), and a friction that differs from the
model's by a factor. Both estimates also share the error of the model's shape over position and
speed (the floor of an interval). This error is kept in both intervals, so that the ratio's interval
is rather too wide.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from frictool.errors import InputFileError
from frictool.observe.interval_estimate import EstimateRange, WearEstimate


@dataclass(frozen=True)
class Commissioning:
    """Wear of a unit at commissioning, and the name of the file that contains the wear."""

    wear: EstimateRange
    source: str

    def ratio(self, estimate: WearEstimate) -> EstimateRange:
        """Return the wear of `estimate` relative to the wear at commissioning."""
        return estimate.wear.over(self.wear)


def commissioning_of_estimate(estimate: WearEstimate, source: str) -> Commissioning:
    """Return the commissioning from a unit's first log; raise InputFileError if it has no wear."""
    if not estimate.moves or not estimate.wear.low > 0.0:
        raise InputFileError(
            source,
            (
                f"gives no wear for comparison: {estimate.moves} moves; a commissioning log "
                "needs some"
            ),
        )
    return Commissioning(estimate.wear, source)


def read_commissioning(path: Path) -> Commissioning:
    """Return the commissioning from the JSON of an `observe run`.

    Raises InputFileError if the file cannot be read or is something else.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        wear = EstimateRange(*(float(content["wear"][key]) for key in ("value", "low", "high")))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputFileError(
            path, f"is no --json of `frictool observe run`: {type(error).__name__} {error}"
        ) from None
    if not 0.0 < wear.low <= wear.value <= wear.high:
        raise InputFileError(
            path,
            f"wear is {wear.value:g} in [{wear.low:g}, {wear.high:g}]; "
            "allowed: 0 < low <= value <= high",
        )
    return Commissioning(wear, str(path))
