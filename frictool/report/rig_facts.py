"""Data of a bench or a simulation that the verdict on its logs needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from frictool.documents.bench import Bench
from frictool.logs.log import Log
from frictool.verify.rig_facts import RECORD, facts_of_text


@dataclass(frozen=True)
class RigFacts:
    """Data of a bench that a verdict needs, or unknown values if there is no bench.

    - resolution: step of the sensor, rad | m; 0 if unknown
    - drive_limit: limit of the drive, A | V; None if unknown
    - backlash: full width of the backlash, rad | m; None if unknown
    - backlash_unsure: largest error of `backlash`, rad | m
    - known: True if there is a bench
    """

    resolution: float = 0.0
    drive_limit: float | None = None
    backlash: float | None = None
    backlash_unsure: float = 0.0
    known: bool = False

    @staticmethod
    def of(bench: Bench | None) -> RigFacts:
        """Return the data of a bench; if it is None, return unknown values."""
        if bench is None:
            return RigFacts()
        backlash = bench.mechanics.backlash
        width = None
        unsure = 0.0
        if backlash is not None:
            low, high = backlash.interval
            width = backlash.value
            unsure = max(high - backlash.value, backlash.value - low)
        return RigFacts(bench.encoder.resolution, bench.actuator.limit.value, width, unsure, True)

    def played(self, log: Log) -> RigFacts:
        """Return the bench's data as they apply to a log.

        For a simulated log, settings of the simulation replace data of the bench.
        """
        return self.simulated(facts_of_text(log.metadata.get(RECORD, {})))

    def simulated(self, facts: Mapping[str, float]) -> RigFacts:
        """Return the bench's data with the encoder step of a simulation.

        The drive limit is the lower of the limits of bench and simulation.
        """
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
