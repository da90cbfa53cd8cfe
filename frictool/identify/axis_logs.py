"""Logs of one axis, sorted into sliding motion and breakaway ramps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from frictool.adapters.axis_model import load_law
from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.load_terms import LoadTerms
from frictool.identify.breakaway.onset_detection import is_ramp, why_unusable
from frictool.identify.coast_down import drive_was_off
from frictool.identify.constant_effort import without_constant_effort
from frictool.identify.duplicate_logs import refuse_duplicates
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.force_error import SlipRows, motion_rows
from frictool.identify.held_effort import slow_effort_warnings
from frictool.identify.load_kink import LoadKink, load_kink
from frictool.identify.measurement_faults import refuse_unmeasured
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, sensed
from frictool.identify.orientation import undriven
from frictool.identify.record_plausibility import implausible
from frictool.identify.rows.temperature_law import refuse_unknown_temperature
from frictool.identify.rows.temperature_shape import shaped

SLIDING_LOG, RAMP_LOG = "sliding", "ramp"
LOOKS_SLIDING = "looks like sliding motion, but was passed as a log of ramps"


@dataclass(frozen=True)
class AxisLogs:
    """Logs of one axis, the bench of the axis, and the requested method.

    - sliding: records of sliding motion, without the samples whose effort is constant although the
      speed varies (`constant_effort.py`); empty if `unmeasured` states a reason
    - ramps: records of breakaway ramps
    - rows: samples of the sliding records at which the axis slips
    - kinds: kind of each log, `sliding` or `ramp`; the key is the name of the log
    - unmeasured: reason why the effort or the position of a sliding record is not a valid
      measurement; None if all are valid
    - drive_off: True if the drive was off in the sliding records (`coast_down.py`)
    - unused_ramps: reason why a log with ramps is not in `ramps`; None if there is no such log
    - kink: kink (abrupt change) of the load; None unless the samples on one side of a kink were
      removed (`on_one_side`)
    """

    sliding: list[MotionRecord]
    ramps: list[MotionRecord]
    rows: Sequence[SlipRows]
    bench: Bench
    method: str
    settings: IdentificationSettings
    kinds: dict[str, str]
    warnings: tuple[str, ...]
    unmeasured: str | None
    drive_off: bool
    unused_ramps: str | None
    kink: LoadKink | None = None

    def find_kink(self, load: LoadTerms | None) -> LoadKink | None:
        """Return the kink (abrupt change) of the load that the sliding records show, or None.

        `load` contains load terms that replace the terms of the bench; None to use the terms of the
        bench. The result is also None if the logs are already restricted to one side of a kink
        (`on_one_side`), if the drive was off, or if there are no records of sliding motion.
        """
        if self.kink is not None or self.drive_off or not self.sliding:
            return None
        return load_kink(self.sliding, self.bench, load, self.settings)

    def on_one_side(self, kink: LoadKink) -> AxisLogs:
        """Return the logs without the samples on one side of the kink, the side with fewer samples.

        A log of ramps is kept if its median position lies on the side with more samples.
        """
        ramps = [record for record in self.ramps if kink.on_side(np.median(record.position))]
        sliding, ramps = (
            [part for record in records if (part := kink.one_side(record)) is not None]
            for records in (self.sliding, ramps)
        )
        return replace(
            self,
            sliding=sliding,
            ramps=ramps,
            rows=motion_rows(sliding, self.bench),
            warnings=(*self.warnings, kink.warning(self.bench)),
            unused_ramps=kink.shown(self.bench) if self.ramps and not ramps else self.unused_ramps,
            kink=kink,
        )

    def sensed(self, lag: float) -> AxisLogs:
        """Return the logs with the effort filtered by the position sensor's lag, `lag` [s]."""
        sliding = [sensed(record, lag) for record in self.sliding]
        ramps = [sensed(record, lag) for record in self.ramps]
        return replace(self, sliding=sliding, ramps=ramps, rows=motion_rows(sliding, self.bench))

    def with_load(self, laws: Laws | None) -> AxisLogs:
        """Return the logs with the load in `laws` as the known load of the ramp records."""
        if laws is None:
            return self
        return replace(self, ramps=[with_load(record, laws) for record in self.ramps])


def sort_logs(
    records: Sequence[MotionRecord],
    ramps: Sequence[MotionRecord],
    bench: Bench,
    method: str,
    settings: IdentificationSettings,
) -> AxisLogs:
    """Return the logs of an axis, sorted into sliding motion and breakaway ramps.

    For each record in `records`, the kind is detected: sliding motion or ramps. The records in
    `ramps` are ramps. Raises LogError if a log occurs twice, or cannot come from this axis.
    """
    every = [*records, *ramps]
    records = shaped(records, bench)
    refuse_duplicates(every)
    warnings = [warning for record in every for warning in implausible(record, bench)]
    warnings += [
        f"{Path(record.name).name}: {LOOKS_SLIDING}"
        for record in ramps
        if record.velocity is None and not is_ramp(record, bench)
    ]
    shown = [record.velocity is None and is_ramp(record, bench) for record in records]
    sliding = [record for record, ramp in zip(records, shown, strict=True) if not ramp]
    ramps = [*ramps, *(record for record, ramp in zip(records, shown, strict=True) if ramp)]
    kinds = {**{r.name: SLIDING_LOG for r in sliding}, **{r.name: RAMP_LOG for r in ramps}}
    positioned = [record for record in sliding if record.velocity is None]
    unused = [reason for record in positioned if (reason := why_unusable(record, bench))]
    unmeasured = None
    try:
        refuse_unmeasured(sliding, bench)
        refuse_unknown_temperature(sliding, bench)
        slow = slow_effort_warnings(sliding, bench, settings)
        sliding, shortened = without_constant_effort(sliding, bench)
        warnings += [*slow, *shortened]
    except UnusableLogs as error:
        moved = (undriven(record, bench, settings.confidence) for record in sliding)
        unmeasured = next((reason for reason in moved if reason is not None), str(error))
        sliding = []
    rows = motion_rows(sliding, bench)
    off = drive_was_off(rows, bench)
    return AxisLogs(
        sliding,
        ramps,
        rows,
        bench,
        method,
        settings,
        kinds,
        tuple(warnings),
        unmeasured,
        off,
        unused[0] if unused else None,
    )


def with_load(record: MotionRecord, laws: Laws) -> MotionRecord:
    """Return the record with the load in `laws` as its known load.

    The record is unchanged if `laws` has no load, or if the position was not measured.
    """
    if laws.load is None or record.velocity is not None:
        return record
    return replace(record, load=load_law(laws.load).at(record.position))
