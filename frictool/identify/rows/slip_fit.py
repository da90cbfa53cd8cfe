"""The rows that smoothing and the slip mask leave of records of motion, and the fits that differ
only in how they weigh them.

Where the inertia cannot be identified it stays in the regression as a nuisance: over whole strokes
acceleration is nearly orthogonal to velocity and its sign (4.27), so that this costs the others
next to nothing, while an a-priori inertia would put its own error, in the clutch +-16 %, into them.

The window is chosen twice: first as if the inertia could be had to any precision, then, knowing how
uncertain it is, as short as leaves the attenuation by the encoder's noise at a fifth of the
standard deviation: a shorter window loses fewer samples beside reversals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from frictool.documents.bench import Bench
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.rows.load_columns import load_columns
from frictool.identify.rows.load_terms import HARMONICS, SPRING, TERMS, with_laws
from frictool.identify.rows.quantisation_limit import refuse_hidden_inertia
from frictool.identify.rows.regression_samples import RegressionSamples, fit, joined, with_fixed
from frictool.identify.rows.slip_mask import keep_rows, slip_mask
from frictool.identify.rows.smoothing import acceleration_response, choose_window, smoothed
from frictool.identify.rows.strokes import Strokes, find_strokes

SMALLEST_SHARE, LARGEST_SHARE = (
    0.0075,
    0.1,
)  # of noise in the acceleration (`smoothing`): attenuation 0.006 % and 1 %
OWN_INERTIA = (
    "the loads over the position are fitted beside the bench's inertia, and hold its range"
)
BIAS_SHARE = 0.2  # of the inertia's standard deviation that attenuation may reach

Fitting = Callable[
    [RegressionSamples, int], SlidingFit
]  # samples and the window that smoothed them -> fit


def weighted_fit(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    weigh: Callable[[RegressionSamples], Vector],
    droppable: tuple[str, ...] = (),
) -> SlidingFit:
    """Least squares on the samples certain to slip, each row times weigh(samples) (n,), less what
    of `droppable` is needless.

    Raises NothingUsable where nothing slips.
    """

    def fitting(rows: RegressionSamples, used: int) -> SlidingFit:
        return fit(rows, weigh(rows), used, settings.confidence, {"window": used}, droppable)

    return slipping_fit(records, bench, settings, fitting)


def slipping_fit(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings, fitting: Fitting
) -> SlidingFit:
    """What `fitting` makes of the samples certain to slip, inertia refused where the encoder hides
    it. Raises NothingUsable."""
    samples, used = slipping(records, bench, SMALLEST_SHARE, settings.window)
    result = fitting(with_fixed(samples, settings.fixed), used)
    share = _bearable_share(result, settings.confidence) * _own_share(samples)
    if (
        settings.window is None
        and share > SMALLEST_SHARE
        and shortest_window(records, share) < used
    ):
        del samples  # an hour of them is large, and the next come
        samples, used = slipping(records, bench, share, None)
        result = fitting(with_fixed(samples, settings.fixed), used)
    response, own = acceleration_response(records[0], used), _own_share(samples)
    found = refuse_hidden_inertia(
        result, records[0], bench, response, own * samples.acceleration, f"over {used} samples"
    )
    if own < 1.0 and "inertia" in result.parameters and "inertia" not in found.parameters:
        beside = fitting(
            with_fixed(samples, {**settings.fixed, "inertia": known_inertia(bench)}), used
        )
        found = replace(
            beside,
            refused={**beside.refused, "inertia": f"{found.refused['inertia']}; {OWN_INERTIA}"},
        )
    return with_laws(found, bench)


def _own_share(samples: RegressionSamples) -> float:
    """The share (rms) of the acceleration that loads over the position and the other columns do not
    explain, 1 if there is no such load.

    A load over the position that goes with the acceleration takes the place of the inertia, since
    it has less noise.
    """
    if not any(name in samples.loads for term in (SPRING, *HARMONICS) for name in TERMS[term]):
        return 1.0
    others = np.column_stack((*samples.columns[1:], *samples.loads.values()))
    left = (
        samples.acceleration - others @ np.linalg.lstsq(others, samples.acceleration, rcond=None)[0]
    )
    return float(np.linalg.norm(left) / np.linalg.norm(samples.acceleration))


def known_inertia(bench: Bench) -> Interval:
    """The bench's inertia; from 0 to twice its value if the bench gives no interval (as in
    `unresolved_inertia`)."""
    known = bench.mechanics.inertia
    return Interval(
        known.value, *(known.interval if known.low is not None else (0.0, 2.0 * known.value))
    )


def _bearable_share(result: SlidingFit, confidence: float) -> float:
    """The share of noise in the acceleration whose attenuation of the inertia is small beside what
    is uncertain of it anyway."""
    inertia = result.parameters.get("inertia")
    if inertia is None or inertia.value <= 0.0:
        return LARGEST_SHARE
    deviation = inertia.half_width / float(ndtri(0.5 + 0.5 * confidence)) / inertia.value
    return min(float(np.sqrt(BIAS_SHARE * deviation)), LARGEST_SHARE)


def stroke_samples(record: MotionRecord) -> float:
    """Median length of the record's strokes in samples, 0 where nothing moves."""
    strokes = find_strokes(record)
    lengths = np.bincount(strokes.number[strokes.sign != 0.0], minlength=1)
    return float(np.median(lengths[lengths > 0])) if lengths.any() else 0.0


def shortest_window(records: list[MotionRecord], share: float) -> int:
    """The longest of the windows that the records need for noise at `share` of the acceleration."""
    return max(choose_window(record, stroke_samples(record), share) for record in records)


def slipping_window(records: list[MotionRecord], window: int | None) -> int:
    """The window asked for, or the longest that any record needs. Raises UnusableLogs where nothing
    moves."""
    if all(stroke_samples(record) == 0.0 for record in records):
        raise UnusableLogs(
            "no sample slips: nothing moves by more than the encoder's own count to and fro"
        )
    return window or shortest_window(records, SMALLEST_SHARE)


def slipping(
    records: list[MotionRecord], bench: Bench, share: float, window: int | None
) -> tuple[RegressionSamples, int]:
    """The samples certain to slip, and the longest window that any record was smoothed over. Raises
    UnusableLogs where none slips."""
    parts, windows = [], []
    for record in records:
        length = stroke_samples(record)
        if length == 0.0:
            continue
        used = window or choose_window(record, length, share)
        parts.append(slipping_rows(record, bench, used, smoothed(record, used)))
        windows.append(used)
    if sum(part.velocity.size for part in parts) == 0:
        backlash = " beyond the backlash" if full_backlash(bench) else ""
        raise UnusableLogs(f"no sample slips for longer than its smoothing window{backlash}")
    return joined(parts), max(windows)


def full_backlash(bench: Bench) -> float:
    """The largest full width of the bench's backlash, rad | m."""
    width = bench.mechanics.backlash
    return 0.0 if width is None else max(width.interval)


def slipping_mask(
    record: MotionRecord, strokes: Strokes, bench: Bench, velocity: Vector, window: int, every: int
) -> NDArray[np.bool_]:
    """Which samples (n,) are the rows of a record: certain to slip over `window`, one in `every`;
    `velocity` (n,) smoothed over it."""
    mask = slip_mask(record, strokes, velocity, window, full_backlash(bench))
    if every > 1:
        mask[np.arange(mask.size) % every != 0] = False
    return mask


def slipping_rows(
    record: MotionRecord,
    bench: Bench,
    window: int,
    signals: tuple[Vector, Vector, Vector],
    every: int = 1,
) -> RegressionSamples:
    """The rows of one record that are certain to slip, one in `every`, from its smoothed
    acceleration, velocity and effort (n,).

    The signals are overwritten: an hour of them is large.
    """
    strokes = find_strokes(record)
    mask = slipping_mask(record, strokes, bench, signals[1], window, every)
    loads = load_columns(record, bench, window, signals[1], strokes.sign)
    for values in (*signals, strokes.sign, strokes.number):
        keep_rows(mask, values)
    kept, loads = np.count_nonzero(mask), {name: column[mask] for name, column in loads.items()}
    acceleration, velocity, effort = (values[:kept] for values in signals)
    counts = np.abs(velocity) * (every * record.period / record.resolution)
    offset, terms = bench.mechanics.offset, None if bench.load is None else bench.load.terms
    known = None if offset is None else Interval(offset.value, *offset.interval)
    most = None if bench.load is None or bench.load.most is None else bench.load.most.value
    return RegressionSamples(
        acceleration,
        velocity,
        effort,
        strokes.number[:kept],
        strokes.sign[:kept],
        counts,
        known,
        loads,
        terms,
        most,
    )
