"""Two records that are one log, by what they hold and not by their names."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictool.errors import LogError
from frictool.identify.motion_record import MotionRecord

SAME_EFFORT = 1e-9  # relative to the largest: two files of one log may round differently


def refuse_duplicates(records: Sequence[MotionRecord]) -> None:
    """Raises LogError where two records are one log: counted twice, it would narrow every interval
    and tell nothing more."""
    for place, one in enumerate(records):
        for other in records[:place]:
            if _same_log(one, other):
                raise LogError(one.name, f"is the same log as {other.name}; give each log once")


def _same_log(one: MotionRecord, other: MotionRecord) -> bool:
    if one.position.size != other.position.size or not np.array_equal(one.position, other.position):
        return False
    return float(np.max(np.abs(one.effort - other.effort))) <= SAME_EFFORT * float(
        np.max(np.abs(one.effort))
    )
