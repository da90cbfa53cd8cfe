"""Backlash from the effort after reversals, and delay of the position relative to the effort.

    effort = inertia a + (viscous v + coulomb s) [advance >= width] + brush s [advance < width]
             + offset - delay d(effort)/dt

s is the sign of the velocity v, and a the acceleration. `advance` is the distance since the last
reversal, and [...] is 1 if the condition holds, else 0. The equation is used in the weak form
(`weak`). Inside the backlash, whose full width is `width`, only the friction of the motor (`brush`)
acts. In the search for the width, [advance < width] is smoothed over an encoder count.

The delay is a linear parameter. Its estimation is repeated, with the effort shifted by the previous
delay, until the remaining delay is nearly 0. Rows inside the backlash are not used for the delay,
because the motor's friction looks like a delay. These rows are excluded with the larger of two
upper ends of the backlash: that of the estimated interval, and that of the interval in bench.yaml.

Schwarz's criterion (BIC) decides whether the model includes a backlash. The intervals come from a
jackknife over strokes; the position of a reversal is known to within a count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.identify.assess.recorded_motion import recorded_facts
from frictool.identify.assess.weak_form_precision import weak_deviation
from frictool.identify.estimators.piecewise_friction import EVIDENCE
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.regression.regression import LeastSquaresSolution, SingularRegressors, solve
from frictool.identify.rows.slip_fit import full_backlash
from frictool.identify.rows.slip_mask import slip_mask
from frictool.identify.rows.smoothing import smoothed_by
from frictool.identify.rows.strokes import find_strokes
from frictool.plant.weak_form import bell
from frictool.typing import Matrix, Vector

ROUNDS = 4  # number of estimations of the delay
GRID_POINTS = 40  # grid points of the first search for the width
WIDEST = 0.4  # largest width relative to the median stroke
SLOPE = 4  # index of the delay's column
SEEN = 2.0  # distance beyond the backlash, in counts, at which rows are used
LONGEST = 200_000  # largest number of samples of a record that are used
LARGEST_DELAY = 0.25  # largest delay relative to the window, for which the linear term is valid


@dataclass(frozen=True)
class ReversalRows:
    """Weak-form rows (n,) of one record, and signals (m,) of all its samples.

    Each row is a mean over a window around a sample, weighted with the test function.

    - plain: weighted means of acceleration, velocity, sign of the velocity, and 1, (n, 4)
    - slope: weighted mean of the derivative of the effort, (n,)
    - effort, stroke: weighted mean of the effort, and number of the stroke, (n,)
    - advance: distance since the last reversal, (m,), rad | m
    - sign, moving: direction and velocity, (m,)
    - mask: True for samples in the middle of the window of a row, (m,)
    - g: weights of the means, the test function of the weak form
    - count: encoder resolution, rad | m
    - period: sample period, s
    """

    plain: Matrix
    slope: Vector
    effort: Vector
    stroke: NDArray[np.int64]
    advance: Vector
    sign: Vector
    moving: Vector
    mask: NDArray[np.bool_]
    g: Vector
    count: float
    period: float

    def inside(self, width: float) -> Matrix:
        """Return the weighted means (n, 2) of direction and velocity inside the backlash.

        `width` is the full width of the backlash [rad | m]. Samples outside count as 0.
        """
        share = np.clip(
            (width - self.advance) / np.maximum(np.abs(self.moving) * self.period, self.count)
            + 0.5,
            0.0,
            1.0,
        )
        return np.column_stack(
            [
                np.convolve(one * share, np.pad(self.g, 1), "same")[self.mask]
                for one in (self.sign, self.moving)
            ]
        )


def reversals(
    records: list[MotionRecord], bench: Bench, confidence: float
) -> tuple[Interval | UnusableLogs, Interval | UnusableLogs]:
    """Return the full width of the backlash [rad | m], and the delay of the position [s].

    The delay is relative to the effort. A value that the records do not determine is replaced by an
    UnusableLogs with the reason. Raises UnusableLogs if the axis does not move.
    """
    facts = recorded_facts(records, bench)
    window = weak_deviation(list(facts.strokes), facts.axis, facts.sensing)[1]
    windows = [window, 2 * (3 * window // 4) + 1]
    widest = WIDEST * float(np.median([stroke.distance for stroke in facts.strokes]))
    gap = full_backlash(bench)
    step = max(record.resolution for record in records)
    # repeated with the estimated backlash if the backlash in bench.yaml is narrower
    for _ in range(2):
        late = _over_windows(partial(_delay, records, gap, confidence), windows)
        known = late if isinstance(late, Interval) else Interval.around(0.0, facts.sensing.period)
        moved = [_moved(record, known.value) for record in records]
        ranges = [step, facts.speed * known.half_width]
        width = _over_windows(partial(_backlash, moved, widest, ranges, confidence), windows)
        if not isinstance(width, Interval) or width.high <= gap:
            break
        gap = width.high
    if isinstance(width, Interval) and width.half_width >= width.value:
        width = UnusableLogs(
            f"the interval of the backlash is too wide to be useful: [{width.low:.3g}, "
            f"{width.high:.3g}] rad or m"
        )
    return width, late


def _over_windows(
    estimate: Callable[[int], Interval], windows: list[int]
) -> Interval | UnusableLogs:
    """Return the estimate with the first window, with an interval that covers those of all windows.

    `windows` are lengths in samples. The effect of the encoder's noise differs between windows.
    """
    try:
        estimates = [estimate(window) for window in windows]
    except UnusableLogs as error:
        return error
    return Interval(
        estimates[0].value, min(one.low for one in estimates), max(one.high for one in estimates)
    )


def _delay(records: list[MotionRecord], gap: float, confidence: float, window: int) -> Interval:
    """Return the delay [s] of the position relative to the effort.

    Rows inside the backlash of the full width `gap` [rad | m] are not used. Raises UnusableLogs if
    the other rows do not determine the delay.
    """
    delay = 0.0
    for _ in range(ROUNDS):
        rows = [
            _rows(_moved(record, delay), window, gap + SEEN * record.resolution)
            for record in records
        ]
        solution = _solved(rows, 0.0)
        delay -= float(solution.value[SLOPE])
        if abs(delay) > LARGEST_DELAY * window * records[0].period:
            raise UnusableLogs(
                f"the estimated delay, {delay:.3g} s, is too long compared with the window of "
                f"{window} samples; correct the time stamps"
            )
    statistical = float(solution.half_width(confidence)[SLOPE]) / float(
        scipy.special.ndtri(0.5 + 0.5 * confidence)
    )
    if not np.isfinite(statistical):
        raise UnusableLogs(
            "the motion does not repeat often enough to determine the delay between the channels; "
            "record more strokes"
        )
    between = max(_between(record) for record in records)
    half = half_width(confidence, statistical, [between])
    return Interval.around(delay, half)


def _between(record: MotionRecord) -> float:
    """Return the largest timing error [s] of an effort interpolated between two samples."""
    return record.period * (
        0.5 if record.lag == 0.0 else min(record.period / record.lag / 12.0, 0.5)
    )


def _backlash(
    records: list[MotionRecord], widest: float, ranges: list[float], confidence: float, window: int
) -> Interval:
    """Return the full width of the backlash [rad | m] from all rows.

    `ranges` contains two errors [rad | m]: that of the position of a reversal, and the distance
    that the axis moves within the uncertainty of the delay. Raises UnusableLogs if the rows show no
    backlash.
    """
    rows = [_rows(record, window, 0.0) for record in records]
    width = _width(rows, widest)
    if width == 0.0:
        raise UnusableLogs(
            "friction does not rise with the distance after a reversal: there is no sign "
            "of backlash"
        )
    half = float(_solved(rows, width).half_width(confidence)[-1])
    normal = float(scipy.special.ndtri(0.5 + 0.5 * confidence))
    if not np.isfinite(half):
        raise UnusableLogs("too few reversals for an interval of the backlash; record more strokes")
    reach = half_width(confidence, half / normal, ranges)
    return Interval.around(width, reach, 0.0)


def _moved(record: MotionRecord, delay: float) -> MotionRecord:
    """Return the first LONGEST samples, each with the effort that was logged `delay` [s] later."""
    part = record.part(slice(0, LONGEST))
    return replace(part, effort=np.interp(part.time + delay, record.time, record.effort))


def _rows(record: MotionRecord, window: int, gap: float) -> ReversalRows:
    strokes, g = find_strokes(record), bell(window)
    acceleration, velocity, effort = smoothed_by(record, g)
    mask = slip_mask(record, strokes, velocity, window, gap)
    slope = np.gradient(effort, record.period)
    mask &= np.isfinite(slope)
    moving = np.gradient(record.position, record.period)
    plain = np.column_stack((acceleration, velocity, strokes.sign, np.ones(velocity.size)))[mask]
    return ReversalRows(
        plain,
        slope[mask],
        effort[mask],
        strokes.number[mask],
        strokes.advance,
        strokes.sign,
        moving,
        mask,
        g,
        record.resolution,
        record.period,
    )


def _together(rows: list[ReversalRows]) -> tuple[Matrix, Vector, NDArray[np.int64]]:
    strokes = []
    above = 0
    for one in rows:
        strokes.append(one.stroke + above)
        above += int(one.stroke[-1]) + 1 if one.stroke.size else 0
    plain = np.concatenate([np.column_stack((one.plain, one.slope)) for one in rows])
    return plain, np.concatenate([one.effort for one in rows]), np.concatenate(strokes)


def _width(rows: list[ReversalRows], widest: float) -> float:
    plain, effort, stroke = _together(rows)
    count = float(np.unique(stroke).size)

    def squares(width: float) -> tuple[float, float]:
        columns = _split(rows, plain, width)
        value = np.linalg.lstsq(columns, effort, rcond=None)[0]
        return float(np.sum((effort - columns @ value) ** 2)), float(value[2] - value[4])

    candidates = np.linspace(0.0, widest, GRID_POINTS + 1)[1:]
    near = candidates[int(np.argmin([squares(float(candidate))[0] for candidate in candidates]))]
    best = bounded_minimum(
        lambda candidate: squares(candidate)[0],
        max(near - candidates[0], 0.1 * candidates[0]),
        near + candidates[0],
    )
    least, rise = squares(best)
    none = plain[:, :SLOPE]
    left = float(np.sum((effort - none @ np.linalg.lstsq(none, effort, rcond=None)[0]) ** 2))
    gain = count * np.log(left / least) - 2.0 * np.log(count)
    return best if gain > EVIDENCE and rise > 0.0 else 0.0


def _split(rows: list[ReversalRows], plain: Matrix, width: float) -> Matrix:
    """Return the regressors (n, 5) for a backlash of the full width `width` [rad | m].

    The columns are the acceleration, the velocity and the direction outside the backlash, the
    constant 1, and the direction inside the backlash.
    """
    inside = np.concatenate([one.inside(width) for one in rows])
    return np.column_stack(
        (
            plain[:, 0],
            plain[:, 1] - inside[:, 1],
            plain[:, 2] - inside[:, 0],
            plain[:, 3],
            inside[:, 0],
        )
    )


def _solved(rows: list[ReversalRows], width: float) -> LeastSquaresSolution:
    """Return the regression with the delay or, if `width` [rad | m] is above 0, with the backlash.

    The regression with the backlash includes the derivative of the effort with respect to the
    width. Raises UnusableLogs if the rows do not determine the parameters.
    """
    plain, effort, stroke = _together(rows)
    if width > 0.0:
        step = max(rows[0].count, float(np.sqrt(np.mean(plain[:, 1] ** 2))) * rows[0].period)
        up, here, down = (
            _split(rows, plain, candidate) for candidate in (width + step, width, width - step)
        )
        value = np.linalg.lstsq(here, effort, rcond=None)[0]
        plain = np.column_stack((here, (up - down) @ value / (2.0 * step)))
    try:
        return solve(plain, effort, np.ones(effort.size), stroke)
    except SingularRegressors as error:
        raise UnusableLogs(f"the motion does not determine backlash and delay: {error}") from None
