"""Detection of records in which the logged effort or position is wrong.

- Saturated effort: the sensor saturates below the actuator's limit. The effort then has flat tops
  or, with noise, stays near a level although the motion needs more.
- Clipped encoder: the position stops at its extreme within a sample, although the effort is too
  small to brake the axis that fast.
- Unsigned effort: the absolute value of the effort was logged. This effort is never negative and
  reaches 0 without staying there, and its mean is about the same in both directions of motion.
- Computed effort: the effort was computed from the encoder signal and not measured. A fit with
  hardly any friction explains the effort almost exactly, and the effort has no noise of its own: a
  filter of the position explains its second differences, too.
- Effort as a function of position: a gravity compensation commands the effort, and another force
  moves the axis. This is tested only if a fit gives neither inertia nor friction.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.fit_result import SlidingFit, UnusableLogs
from frictool.identify.hidden_saturation import hidden_saturation
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.smoothing import position_noise
from frictool.identify.rows.strokes import Strokes, find_strokes
from frictool.logs.quality.saturation import FlatTopDetector
from frictool.typing import Vector

LARGEST_SATURATED_SHARE = 0.01  # largest share of samples at a flat top of a valid effort
# share of the actuator's limit above which a flat top comes from the actuator, not the sensor
AT_THE_LIMIT = 0.99
# samples before a stop over which the speed is averaged, and samples without motion after the stop
STOPPING_SAMPLES = 3
MARGIN = 2.0  # safety factor on the deceleration that effort and friction can cause
COUNTS = 2.0  # largest error of the distance over STOPPING_SAMPLES, in encoder counts
NOISES = 8.0  # the same error in standard deviations of the position noise, if this is larger
# smallest effort, relative to the largest, that counts as 0 in a signal that is never negative
REACHES_ZERO = 0.01
# largest difference of the mean efforts forward and backward, relative to their sum, if the effort
# is unsigned
ALIKE = 0.5
# at a reversal, an unsigned effort falls below the share DIP of its means in both strokes; this is
# required at the share LEAST_DIPS of the reversals
DIP, LEAST_DIPS = 0.25, 0.8
MOST_AT_ZERO = 0.01  # largest share of the samples in motion that have the smallest effort
SELF_EXPLAINED = 1e-3  # relative residual that is smaller than the noise of any effort sensor
# samples of the position, before and after an effort, from which the effort may be computed; a
# filter of 5 sample periods has then decayed to 0.2 %
SAMPLES_BEFORE, SAMPLES_AFTER = 32, 4
NO_FRICTION = 0.02  # largest Coulomb friction, relative to the rms effort, that counts as none
# largest share of the effort's variance that the position leaves unexplained
LEFT_BY_POSITION = 1e-3
FEWEST_SAMPLES = 100  # least number of samples in each direction


def refuse_unmeasured(records: list[MotionRecord], bench: Bench) -> None:
    """Raise UnusableLogs if a record has a saturated or unsigned effort, or a clipped encoder."""
    for record in records:
        _refuse_saturated(record, bench)
        _refuse_hidden_saturation(record, bench)
        _refuse_clipped(record, bench)
        _refuse_unsigned(record)


def _refuse_saturated(record: MotionRecord, bench: Bench) -> None:
    tops = FlatTopDetector(float(record.effort.min()), float(record.effort.max()), None)
    tops.take(record.effort)
    most = bench.actuator.limit.value * bench.actuator.constant.value
    for top in tops.result():
        share = top.samples / record.effort.size
        if share > LARGEST_SATURATED_SHARE and abs(top.at) < AT_THE_LIMIT * most:
            unit = si_unit("effort", bench.axis)
            raise UnusableLogs(
                f"{record.name}: the effort is {top.at:.4g} {unit} in {100 * share:.2g} % of "
                f"samples (at most {100 * LARGEST_SATURATED_SHARE:g} %), below the drive limit "
                f"{most:.4g}: the measurement is saturated; widen its range"
            )


def _refuse_hidden_saturation(record: MotionRecord, bench: Bench) -> None:
    saturation = hidden_saturation(record, bench)
    most = bench.actuator.limit.value * bench.actuator.constant.value
    if saturation is not None and saturation.level < AT_THE_LIMIT * most:
        unit = si_unit("effort", bench.axis)
        raise UnusableLogs(
            f"{record.name}: the effort stays near {saturation.level:.4g} {unit} where the motion "
            f"needs up to {saturation.needed:.4g} ({100 * saturation.share:.2g} % of the moving "
            "samples): the measurement is saturated; widen its range"
        )


def _refuse_clipped(record: MotionRecord, bench: Bench) -> None:
    x = record.position
    n = STOPPING_SAMPLES
    unit = si_unit("position", bench.axis)
    noise = position_noise(record)
    friction, inertia = bench.mechanics.coulomb.interval[1], bench.mechanics.inertia.interval[0]
    for extreme in (x.max(), x.min()):
        stops = (
            np.flatnonzero(
                (x[n:-n] == extreme) & (x[n - 1 : -n - 1] != extreme) & (x[2 * n :] == extreme)
            )
            + n
        )
        for at in stops[record.piece[stops + n] == record.piece[stops - n]]:
            speed = abs(x[at - 1] - x[at - n]) / ((n - 1) * record.period)
            brake = (float(np.abs(record.effort[at - n : at + n]).max()) + friction) / inertia
            unseen = max(COUNTS * record.resolution, NOISES * noise) / ((n - 1) * record.period)
            if speed > MARGIN * brake * 0.5 * n * record.period + unseen:
                raise UnusableLogs(
                    f"{record.name}: at {record.time[at]:.6g} s the velocity falls from "
                    f"{speed:.3g} {unit}/s to 0, at the extreme position {extreme:.4g} {unit}: "
                    "the encoder is clipped, or the axis hit a stop"
                )


def _refuse_unsigned(record: MotionRecord) -> None:
    strokes = find_strokes(record)
    direction = strokes.sign
    effort = record.effort if record.effort.max() > 0.0 else -record.effort
    low, high = float(effort.min()), float(effort.max())
    moving = effort[direction != 0.0]
    if (
        low < 0.0
        or low > REACHES_ZERO * high
        or min(np.sum(direction > 0.0), np.sum(direction < 0.0)) < FEWEST_SAMPLES
        or np.mean(moving == low) > MOST_AT_ZERO
    ):
        return
    forward, backward = (float(np.mean(effort[direction == side])) for side in (1.0, -1.0))
    alike = abs(forward - backward) < ALIKE * (forward + backward)
    if alike and _dips(effort, strokes) >= LEAST_DIPS:
        raise UnusableLogs(
            f"{Path(record.name).name}: the effort has one sign in both directions of motion, but "
            "reaches 0: it is an absolute value; log the drive signal with its sign"
        )


def one_sided_effort(records: list[MotionRecord]) -> str | None:
    """Return a message if the effort of a record has one sign in both directions of motion.

    Such an effort is an absolute value, or comes from a load that pulls in one direction. The
    result is None if no record has such an effort.
    """
    for record in records:
        direction = find_strokes(record).sign
        low, high = float(record.effort.min()), float(record.effort.max())
        both = min(np.sum(direction > 0.0), np.sum(direction < 0.0)) >= FEWEST_SAMPLES
        if both and (low >= 0.0 or high <= 0.0):
            side = "negative" if low >= 0.0 else "positive"
            return (
                f"{Path(record.name).name}: the effort is never {side}, but the axis moves in both "
                "directions; if another column states the direction, multiply the effort by it"
            )
    return None


def _dips(effort: Vector, strokes: Strokes) -> float:
    edges = np.flatnonzero(np.diff(strokes.number, prepend=-1, append=-1))
    found = list[bool]()
    for start, turn, end in zip(edges[:-2], edges[1:-1], edges[2:], strict=True):
        if strokes.sign[start] * strokes.sign[turn] >= 0.0:
            continue
        level = min(float(np.mean(effort[start:turn])), float(np.mean(effort[turn:end])))
        near = effort[(start + turn) // 2 : (turn + end) // 2]
        found.append(float(near.min()) < DIP * level)
    return float(np.mean(found)) if found else 0.0


def refuse_self_explained(fit: SlidingFit, records: list[MotionRecord]) -> None:
    """Raise UnusableLogs if the fit explains a noiseless effort almost exactly without friction.

    `fit` must be a regression, because the residual of a simulation tends to 0 with the fitted
    inertia.
    """
    coulomb = fit.parameters.get("coulomb")
    if coulomb is None or fit.residual > SELF_EXPLAINED:
        return
    size = _rms([record.effort for record in records])
    if (
        abs(coulomb.value) < NO_FRICTION * size
        and max(_sensor_noise(record) for record in records) < SELF_EXPLAINED * size
    ):
        raise UnusableLogs(
            f"the effort was computed from the encoder: all but {100 * fit.residual:.1g} % of it "
            f"follows from the motion (friction {coulomb.value:.2g}, rms effort {size:.2g}); log "
            "the measured current"
        )


def _sensor_noise(record: MotionRecord) -> float:
    """Return the rms noise of the effort [N m | N] that no filter of the position explains."""
    length = SAMPLES_BEFORE + 1 + SAMPLES_AFTER
    if record.effort.size < 4 * length:
        return 0.0
    around = sliding_window_view(np.diff(record.position, 2), length)
    second = np.diff(record.effort, 2)[SAMPLES_BEFORE : -SAMPLES_AFTER or None]
    left = second - around @ np.linalg.lstsq(around, second, rcond=None)[0]
    return _rms([left]) / math.sqrt(6.0)  # a second difference of white noise has 6 variances


def commanded(records: list[MotionRecord]) -> str | None:
    """Return a message if the position alone explains the effort of a record, else None."""
    return next((one for record in records if (one := _commanded_by_position(record))), None)


def _commanded_by_position(record: MotionRecord) -> str | None:
    direction = find_strokes(record).sign
    moving = direction != 0.0
    if min(np.sum(direction > 0.0), np.sum(direction < 0.0)) < FEWEST_SAMPLES:
        return None
    x, effort, side = record.position[moving], record.effort[moving], direction[moving]
    columns = np.column_stack((np.ones(x.size), np.sin(x), np.cos(x), x - np.mean(x), side))
    value = np.linalg.lstsq(columns, effort, rcond=None)[0]
    left = float(np.var(effort - columns @ value))
    varies = float(np.var(effort))
    if left > LEFT_BY_POSITION * varies or abs(value[-1]) > NO_FRICTION * np.sqrt(varies):
        return None
    return (
        f"{Path(record.name).name}: the position alone explains all but "
        f"{100.0 * np.sqrt(left / varies):.2g} % of the effort in both directions, as in a gravity "
        "compensation; move the axis by its drive, not by another force"
    )


def _rms(parts: list[Vector]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
