"""Detection of two records of the same log; the samples are compared, not the names."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictool.errors import LogError
from frictool.identify.motion_record import MotionRecord

# largest difference of the efforts of two copies of a log, relative to the largest effort; the
# copies can be rounded differently
SAME_EFFORT = 1e-9


def refuse_duplicates(records: Sequence[MotionRecord]) -> None:
    """Raise LogError if two records contain the same log.

    A log that counts twice would narrow every interval without adding information.
    """
    for index, one in enumerate(records):
        for other in records[:index]:
            if _same_log(one, other):
                raise LogError(one.name, f"is the same log as {other.name}; give each log once")


def _same_log(one: MotionRecord, other: MotionRecord) -> bool:
    if one.position.size != other.position.size or not np.array_equal(one.position, other.position):
        return False
    return float(np.max(np.abs(one.effort - other.effort))) <= SAME_EFFORT * float(
        np.max(np.abs(one.effort))
    )
