"""Facts of the rig of a log that its judgement needs."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from frictool.documents.bench import Bench
from frictool.logs.log import Log
from frictool.verify.rig_facts import RECORD, facts_of_text


@dataclass(frozen=True)
class RigFacts:
    """From a bench, as far as one is known.

    resolution: the sensor's step [rad or m], 0 where none is known. drive_limit [A or V]. backlash:
    its full width [rad or m]; backlash_unsure: by how much it may be wider or narrower. known:
    whether there is a bench at all.
    """

    resolution: float = 0.0
    drive_limit: float | None = None
    backlash: float | None = None
    backlash_unsure: float = 0.0
    known: bool = False

    @staticmethod
    def of(bench: Bench | None) -> RigFacts:
        """Of a bench, or of none."""
        if bench is None:
            return RigFacts()
        backlash = bench.mechanics.backlash
        width, unsure = None, 0.0
        if backlash is not None:
            low, high = backlash.interval
            width, unsure = backlash.value, max(high - backlash.value, backlash.value - low)
        return RigFacts(bench.encoder.resolution, bench.actuator.limit.value, width, unsure, True)

    def played(self, log: Log) -> RigFacts:
        """Return the rig with the encoder and the limit with which a log was simulated; the lower
        of two limits acts."""
        facts = facts_of_text(log.metadata.get(RECORD, {}))
        limits = [
            limit
            for limit in (self.drive_limit, facts.get("drive_limit"))
            if limit is not None and math.isfinite(limit)
        ]
        return replace(
            self,
            resolution=facts.get("encoder_step", self.resolution),
            drive_limit=min(limits, default=None),
        )
