"""What a log does not say of the rig that it was recorded on."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.documents.bench import Bench


@dataclass(frozen=True)
class Rig:
    """From a bench, as far as one is known.

    resolution: the sensor's step [rad or m], 0 where none is known. drive_limit [A or V]. backlash: its full width [rad or m];
    backlash_unsure: by how much it may be wider or narrower. known: whether there is a bench at all.
    """

    resolution: float = 0.0
    drive_limit: float | None = None
    backlash: float | None = None
    backlash_unsure: float = 0.0
    known: bool = False

    @staticmethod
    def of(bench: Bench | None) -> Rig:
        """Of a bench, or of none."""
        if bench is None:
            return Rig()
        backlash = bench.mechanics.backlash
        width, unsure = None, 0.0
        if backlash is not None:
            low, high = backlash.interval
            width, unsure = backlash.value, max(high - backlash.value, backlash.value - low)
        return Rig(bench.encoder.resolution, bench.actuator.limit.value, width, unsure, True)
