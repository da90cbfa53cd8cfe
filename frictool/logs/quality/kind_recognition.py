"""Recognition of the kind of test from a log's signals.

The kind decides which parameters can be identified.

    rest    the position does not move
    steps   the reference is constant except for a few jumps; if there is no reference, the axis
            rests at one position after the other
    ramp    the axis rests for most of the time; during each rest the effort rises from a low level
            along a line until the axis starts (ramps.py)
    sines   a few spectral lines contain nearly all power of the reference's acceleration; if there
            is no reference, of the drive signal; if there is neither, of the position
    stroke  the axis moves in one direction, or in one direction and back
    free    any other motion
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from frictool.logs.log import Stream
from frictool.logs.quality.ramps import REST, are_ramps, rests_of, without_flicker
from frictool.logs.quality.sliding_extremes import sliding_maximum
from frictool.logs.quality.time_base import encoder_step
from frictool.typing import Vector

Kind = Literal["rest", "steps", "ramp", "sines", "stroke", "free"]  # keys of KINDS (log_kinds.py)
STILL_COUNTS = 1.5  # largest motion at rest, in encoder counts
STILL_SHARE = 1e-3  # largest motion at rest (encoder noise), relative to the position's range
FEW_JUMPS = 0.02  # largest number of reference jumps relative to the number of samples
# number of spectral lines, and their least share of the power
LINES = 12
PURE = 0.9
LOBE = 2  # bins on each side of a line that a Hann window fills
FEWEST_BINS = 64  # a spectrum needs at least FEWEST_BINS * LOBE bins
GRID_POINTS = 500  # samples at which the path length is evaluated
ONE_WAY_AND_BACK = 2.2  # largest path of a stroke, relative to the position's range


def kind_of(stream: Stream) -> Kind | None:
    """Return the kind of test; None if there is no position or if there are too few samples."""
    signals = stream.signals
    position = signals.get("position")
    if position is None or position.size < 2 * REST:
        return None
    span = float(np.ptp(position))
    still = max(STILL_COUNTS * (encoder_step(position) or 0.0), STILL_SHARE * span)
    if span <= still:
        return "rest"
    reference = signals.get("reference")
    if (
        reference is not None
        and 0 < np.count_nonzero(np.diff(reference)) <= FEW_JUMPS * reference.size
    ):
        return "steps"
    drive = next(
        (signals[name] for name in ("effort", "current", "voltage") if name in signals), None
    )
    rests = _rests(position, still)
    step = encoder_step(position)
    resting = sum(end - start for start, end in rests) > 0.5 * position.size
    steady = without_flicker(position, step) if step else position
    within_counts = rests_of(np.abs(np.diff(steady)) > 0.5 * step) if step else []
    if drive is not None and (
        are_ramps(within_counts, steady, drive) or are_ramps(rests, position, drive)
    ):
        return "ramp"
    if reference is None and resting and len(rests) > 1:
        return "steps"
    excitation = (
        np.diff(reference, 2)
        if reference is not None and np.ptp(reference) > 0.0
        else drive
        if drive is not None
        else position
    )
    if _path(position) <= ONE_WAY_AND_BACK * span:
        return "stroke"
    return "sines" if _is_lines(excitation) else "free"


def _rests(position: Vector, still: float) -> list[tuple[int, int]]:
    half = REST // 2
    spread = sliding_maximum(position, REST, half) + sliding_maximum(-position, REST, half)
    inside = sliding_maximum((spread <= still).astype(np.float64), REST, (REST - 1) // 2)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside, [0]))))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _is_lines(values: Vector) -> bool:
    window = np.hanning(values.size)
    power = np.abs(np.fft.rfft((values - values.mean()) * window)) ** 2
    total = float(power.sum())
    line_power = 0.0
    if power.size < FEWEST_BINS * LOBE or total == 0.0:
        return False
    for _ in range(LINES):
        peak = int(np.argmax(power))
        lobe = slice(max(peak - LOBE, 0), peak + LOBE + 1)
        line_power += float(power[lobe].sum())
        power[lobe] = 0.0
    return line_power >= PURE * total


def _path(position: Vector) -> float:
    return float(np.abs(np.diff(position[:: max(1, position.size // GRID_POINTS)])).sum())
