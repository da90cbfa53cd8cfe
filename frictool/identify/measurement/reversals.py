"""Backlash from the effort after reversals, and delay of the position relative to the effort.

    effort = inertia a + (viscous v + coulomb s) [advance >= width] + brush s [advance < width]
             + offset + other causes - delay d(effort)/dt

s is the sign of the velocity v, and a the acceleration. `advance` is the distance since the last
reversal, and [...] is 1 if the condition holds, else 0. The equation is used in the weak form
(`weak`). Inside the backlash, whose full width is `width`, only the friction of the motor (`brush`)
acts. In the search for the width, [advance < width] is smoothed over an encoder count.

The delay is a linear parameter. Its estimation is repeated, with the effort shifted by the previous
delay, until the remaining delay is nearly 0. Rows inside the backlash are not used for the delay,
because the motor's friction looks like a delay. These rows are excluded with the larger of two
upper ends of the backlash: the upper end of the estimated interval, and the upper end of the
interval in bench.yaml.

The other causes (`OtherCauses`) are loads, and friction that changes with position, speed,
direction or acceleration. These causes change the effort after reversals, too. The part of the
effort and of all regressors that they explain is therefore removed first (theorem of Frisch, Waugh
and Lovell). For the delay, only the loads are removed.

Schwarz's criterion (BIC) decides whether the model includes a backlash. A backlash is reported only
if it also explains the effort better than a gradual rise of friction, as in presliding or in an
elastic drive train. For such a rise, 1 - advance/width or e^(-advance/width) replaces [advance <
width]. The intervals of backlash and delay come from a jackknife over strokes. The position of a
reversal is known to within an encoder count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.documents.quantity import Axis, si_unit
from frictool.identify.assess.recorded_motion import recorded_facts
from frictool.identify.assess.weak_form_precision import weak_deviation
from frictool.identify.estimators.piecewise_friction import EVIDENCE
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.regression.regression import LeastSquaresSolution, SingularRegressors, solve
from frictool.identify.rows.effects import (
    SLOW_SHARES,
    TRAVEL_ORDER,
    WIDE_SHARES,
    SmoothedMotion,
)
from frictool.identify.rows.friction_columns import names_to, position_columns, rows_of
from frictool.identify.rows.load_columns import load_columns
from frictool.identify.rows.load_terms import TERMS, bench_with_terms, possible
from frictool.identify.rows.slip_fit import full_backlash
from frictool.identify.rows.slip_mask import slip_mask
from frictool.identify.rows.smoothing import smoothed_by
from frictool.identify.rows.strokes import find_strokes
from frictool.plant.weak_form import sampled_test_function
from frictool.typing import Matrix, Vector

ROUNDS = 4  # number of estimations of the delay
GRID_POINTS = 50  # grid points of the first search for the width, in a geometric series
NARROWEST = 0.5  # smallest width of the search, in counts
WIDEST = 0.4  # largest width relative to the median stroke
SLOPE = 4  # index of the delay's column
OUTSIDE, INSIDE = 2, 4  # indices of the columns of the friction outside and inside the backlash
SEEN = 2.0  # distance beyond the backlash, in counts, at which rows are used
LONGEST = 200_000  # largest number of samples of a record that are used
REDUCED = 0.75  # friction inside a backlash that would not show, relative to the friction outside
LARGEST_DELAY = 0.25  # largest delay relative to the window, for which the linear term is valid
# least singular value of the regressors of other causes that is not 0, relative to the largest
INDEPENDENT = 1e-4

Rise = Literal["step", "linear", "exponential"]
GRADUAL: tuple[Rise, ...] = ("linear", "exponential")


@dataclass(frozen=True)
class ReversalRows:
    """Weak-form rows (n,) of one record, and signals (m,) of all its samples.

    Each row is a mean over a window around a sample, weighted with the test function.

    - plain: weighted means of acceleration, velocity, sign of the velocity, and 1, (n, 4)
    - other: regressors of the other causes, (n, q)
    - slope: weighted mean of the derivative of the effort, (n,)
    - effort, stroke: weighted mean of the effort, and number of the stroke, (n,)
    - advance: distance since the last reversal, (m,), rad | m
    - sign, moving: direction of the motion (+-1 or 0) and velocity, (m,)
    - mask: True for each sample that is the middle of a row's window, (m,)
    - g: weights of the means, the test function of the weak form
    - count: encoder resolution, rad | m
    - period: sample period, s
    """

    plain: Matrix
    other: Matrix
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

    def inside(self, width: float, rise: Rise) -> Matrix:
        """Return the weighted means (n, 2) of direction and velocity inside the backlash.

        `width` is the full width of the backlash [rad | m]. If `rise` is "step", samples outside
        the backlash count as 0. Otherwise, the friction rises gradually: the weight of a sample is
        1 - advance/width ("linear") or e^(-advance/width).
        """
        if rise == "step":
            blurred = np.maximum(np.abs(self.moving) * self.period, self.count)
            share = np.clip((width - self.advance) / blurred + 0.5, 0.0, 1.0)
        elif rise == "linear":
            share = np.clip(1.0 - self.advance / width, 0.0, 1.0)
        else:
            share = np.exp(-np.maximum(self.advance, 0.0) / width)
        return np.column_stack(
            [
                np.convolve(one * share, np.pad(self.g, 1), "same")[self.mask]
                for one in (self.sign, self.moving)
            ]
        )


@dataclass(frozen=True)
class ReversalErrors:
    """Largest errors of the data that the regression of the backlash does not show.

    - reversal: error of the position of a reversal, rad | m
    - delay: error of the delay between position and effort, s
    """

    reversal: float
    delay: float


@dataclass(frozen=True)
class OtherCauses:
    """Loads and friction that may change the effort after reversals, as a backlash does.

    - bench: bench whose loads may act
    - low, high: lowest and highest position in all records, rad | m
    - top_speed: top speed in all records, rad/s | m/s
    """

    bench: Bench
    low: float
    high: float
    top_speed: float

    def loads(self, motion: SmoothedMotion) -> list[Vector]:
        """Return the regressors (n,) of the loads that the bench declares.

        If the bench declares none, return the regressors of all loads except ripples.
        """
        terms = possible(self.bench)
        columns = load_columns(motion, bench_with_terms(self.bench, terms))
        return [columns[name] for term in terms for name in TERMS[term]]

    def loads_and_friction(self, motion: SmoothedMotion) -> list[Vector]:
        """Return the regressors (n,) of loads and friction over position and speed."""
        velocity, sign = motion.velocity[motion.used], motion.sign[motion.used]
        rows = rows_of(motion.record, motion.sign, motion.used, motion.window)
        over_position = position_columns(motion.record, rows, self.low, self.high)
        return [
            *self.loads(motion),
            *(over_position[name] for name in names_to(TRAVEL_ORDER)),
            *(
                sign * np.exp(-((velocity / (share * self.top_speed)) ** 2))
                for share in (*SLOW_SHARES, *WIDE_SHARES)
            ),
            sign * np.abs(motion.acceleration[motion.used]),
            np.minimum(velocity, 0.0),
        ]


@dataclass(frozen=True)
class ReversalRegression:
    """Rows (n,) of all records, without the part of each column that other causes explain."""

    rows: list[ReversalRows]

    @cached_property
    def stroke(self) -> NDArray[np.int64]:
        """Return the number of the stroke of each row, counted over all records."""
        strokes = []
        above = 0
        for one in self.rows:
            strokes.append(one.stroke + above)
            above += int(one.stroke[-1]) + 1 if one.stroke.size else 0
        return np.concatenate(strokes)

    @cached_property
    def plain(self) -> Matrix:
        """Return acceleration, velocity, direction, 1 and slope of the effort, (n, 5)."""
        every = [np.column_stack((one.plain, one.slope)) for one in self.rows]
        return self._own(np.concatenate(every))

    @cached_property
    def effort(self) -> Vector:
        """Return the effort, (n,)."""
        return self._own(np.concatenate([one.effort for one in self.rows]))

    def split(self, width: float, rise: Rise = "step") -> Matrix:
        """Return the regressors (n, 5) for a backlash of the full width `width` [rad | m].

        The columns are the acceleration, the velocity and the direction outside the backlash, the
        constant 1, and the direction inside the backlash.
        """
        inside = self._own(np.concatenate([one.inside(width, rise) for one in self.rows]))
        plain = self.plain[:, :SLOPE].copy()
        plain[:, 1:3] -= inside[:, ::-1]
        return np.column_stack((plain, inside[:, 0]))

    def fitted(self, columns: Matrix) -> Vector:
        """Return the parameters (p,) of the regressors (n, p), by least squares."""
        return np.asarray(np.linalg.lstsq(columns, self.effort, rcond=None)[0])

    def fit_of(self, width: float, rise: Rise = "step") -> tuple[Vector, Vector]:
        """Return the parameters (5,) of `split`, and the residuals (n,).

        The friction inside a backlash is at least 0.
        """
        columns = self.split(width, rise)
        value = self.fitted(columns)
        if rise == "step" and value[INSIDE] < 0.0:
            value = np.append(self.fitted(columns[:, :INSIDE]), 0.0)
        return value, self.effort - columns @ value

    def squares(self, width: float, rise: Rise) -> float:
        """Return the sum of squared residuals for a backlash or gradual rise of `width`."""
        return float(np.sum(self.fit_of(width, rise)[1] ** 2))

    def best_width(self, widest: float, rise: Rise = "step") -> float:
        """Return the width [rad | m] of at most `widest` that minimises the squared residual."""
        least = NARROWEST * min(one.count for one in self.rows)
        grid = np.geomspace(min(least, 0.5 * widest), widest, GRID_POINTS)
        best = int(np.argmin([self.squares(float(width), rise) for width in grid]))
        low, high = grid[max(best - 1, 0)], grid[min(best + 1, GRID_POINTS - 1)]
        return bounded_minimum(lambda width: self.squares(width, rise), float(low), float(high))

    def largest_hidden(self, widest: float) -> float:
        """Return the largest backlash [rad | m], at most `widest`, that the rows would not show.

        Inside the backlash, friction is assumed to fall to the fraction REDUCED. The rows do not
        show a backlash if a model without backlash fits nearly as well.
        """
        count = np.unique(self.stroke).size
        plain = self.plain[:, :SLOPE]
        none = float(np.sum((self.effort - plain @ self.fitted(plain)) ** 2))
        least = NARROWEST * min(one.count for one in self.rows)
        for width in np.geomspace(widest, min(least, 0.5 * widest), GRID_POINTS):
            columns = self.split(float(width))
            columns[:, OUTSIDE] += REDUCED * columns[:, INSIDE]
            residual = self.effort - columns[:, :INSIDE] @ self.fitted(columns[:, :INSIDE])
            if count * np.log(np.sum(residual**2) / none) <= EVIDENCE:
                return float(width)
        return 0.0

    def solved(self, columns: Matrix) -> LeastSquaresSolution:
        """Return the solution with standard deviations by a jackknife over strokes.

        Raises UnusableLogs if the rows do not determine the parameters.
        """
        try:
            return solve(columns, self.effort, np.ones(self.effort.size), self.stroke)
        except SingularRegressors as error:
            raise UnusableLogs(
                f"the motion does not determine backlash and delay: {error}"
            ) from None

    def with_width(self, width: float) -> LeastSquaresSolution:
        """Return the solution with a backlash, linearised at the width `width` [rad | m].

        The last parameter is the correction of this width.
        """
        return self.solved(self._linearised(width))

    def change_with_delay(self, width: float) -> float:
        """Return the change of the estimated width per change of the delay [rad/s | m/s].

        An error of the delay changes the effort by this error times the slope of the effort. The
        regression, linearised at `width` [rad | m], assigns a part of this change to the width.
        Other parameters change, too, so that the result may exceed the speed of the axis.
        """
        columns = self._linearised(width)
        return float(np.linalg.lstsq(columns, self.plain[:, SLOPE], rcond=None)[0][-1])

    def _linearised(self, width: float) -> Matrix:
        """Return the columns of `split`, and the effort's derivative with respect to the width."""
        one = self.rows[0]
        speed = float(np.sqrt(np.mean(np.concatenate([r.plain[:, 1] for r in self.rows]) ** 2)))
        step = max(one.count, speed * one.period)
        up, here, down = (self.split(width + shift) for shift in (step, 0.0, -step))
        value = self.fit_of(width)[0]
        return np.column_stack((here, (up - down) @ value / (2.0 * step)))

    @cached_property
    def _basis(self) -> Matrix:
        """Return an orthonormal basis (n, k) of the regressors of the other causes."""
        other = np.concatenate([one.other for one in self.rows])
        if other.shape[0] <= other.shape[1] + self.rows[0].plain.shape[1] + 2:
            raise UnusableLogs(
                f"the axis slips for only {other.shape[0]} samples, too few to determine backlash "
                "and delay; record more strokes"
            )
        size = np.linalg.norm(other, axis=0)
        basis, values, _ = np.linalg.svd(other[:, size > 0.0] / size[size > 0.0], False)
        return np.asarray(basis[:, values > INDEPENDENT * values.max(initial=0.0)])

    def _own(self, columns: Vector) -> Vector:
        return np.asarray(columns - self._basis @ (self._basis.T @ columns))


def reversals(
    records: list[MotionRecord], bench: Bench, confidence: float
) -> tuple[Interval | UnusableLogs, Interval | UnusableLogs]:
    """Return the full width of the backlash [rad | m], and the delay of the position [s].

    The delay is relative to the effort. If the records do not determine a value, the result
    contains an UnusableLogs with the reason instead. Raises UnusableLogs if the axis does not move.
    """
    facts = recorded_facts(records, bench)
    window = weak_deviation(list(facts.strokes), facts.axis, facts.sensing)[1]
    windows = [window, 2 * (3 * window // 4) + 1]
    widest = WIDEST * float(np.median([stroke.distance for stroke in facts.strokes]))
    gap = full_backlash(bench)
    other = OtherCauses(
        bench,
        min(float(record.position.min()) for record in records),
        max(float(record.position.max()) for record in records),
        facts.speed,
    )
    step = max(record.resolution for record in records)
    # repeated with the estimated backlash if the backlash in bench.yaml is narrower
    for _ in range(2):
        late = _over_windows(partial(_delay, records, other, gap, confidence), windows)
        known = late if isinstance(late, Interval) else Interval.around(0.0, facts.sensing.period)
        moved = [_with_earlier_effort(record, known.value) for record in records]
        errors = ReversalErrors(step, max(known.high - known.value, known.value - known.low))
        width = _over_windows(partial(_backlash, moved, other, widest, errors, confidence), windows)
        if not isinstance(width, Interval) or width.high <= gap:
            break
        gap = width.high
    if isinstance(width, Interval) and width.half_width >= width.value:
        width = UnusableLogs(
            f"the interval of the backlash is too wide to be useful: [{width.low:.3g}, "
            f"{width.high:.3g}] {si_unit('position', bench.axis)}"
        )
    elif isinstance(width, Interval):
        regression = _regression(moved, other, window)
        length = _gradual_rise(regression, width.value, widest, confidence)
        if length is not None:
            width = UnusableLogs(
                f"the logs do not distinguish a backlash of {width.low:.3g} to {width.high:.3g} "
                f"{si_unit('position', bench.axis)} from an elastic drive train or presliding over "
                f"{length:.3g} {si_unit('position', bench.axis)}"
            )
    return width, late


def _over_windows(
    estimate: Callable[[int], Interval], windows: list[int]
) -> Interval | UnusableLogs:
    """Return the estimate with the first window, and an interval that covers those of all windows.

    `windows` are lengths in samples. The effect of the encoder's noise differs between windows.
    """
    try:
        estimates = [estimate(window) for window in windows]
    except UnusableLogs as error:
        return error
    return Interval(
        estimates[0].value, min(one.low for one in estimates), max(one.high for one in estimates)
    )


def _delay(
    records: list[MotionRecord], other: OtherCauses, gap: float, confidence: float, window: int
) -> Interval:
    """Return the delay [s] of the position relative to the effort.

    Rows inside the backlash of the full width `gap` [rad | m] are not used. Raises UnusableLogs if
    the other rows do not determine the delay.
    """
    delay = 0.0
    for _ in range(ROUNDS):
        rows = [
            _rows(
                _with_earlier_effort(record, delay),
                other.loads,
                window,
                gap + SEEN * record.resolution,
            )
            for record in records
        ]
        regression = ReversalRegression(rows)
        solution = regression.solved(regression.plain)
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
        0.5 if record.effort_lag == 0.0 else min(record.period / record.effort_lag / 12.0, 0.5)
    )


def _backlash(
    records: list[MotionRecord],
    other: OtherCauses,
    widest: float,
    errors: ReversalErrors,
    confidence: float,
    window: int,
) -> Interval:
    """Return the full width of the backlash [rad | m] from all rows.

    Raises UnusableLogs if the rows show no backlash.
    """
    regression = _regression(records, other, window)
    width = _width(regression, widest, other.bench.axis)
    half = float(regression.with_width(width).half_width(confidence)[-1])
    if not np.isfinite(half):
        raise UnusableLogs("too few reversals for an interval of the backlash; record more strokes")
    normal = float(scipy.special.ndtri(0.5 + 0.5 * confidence))
    late = abs(regression.change_with_delay(width)) * errors.delay
    reach = half_width(confidence, half / normal, [errors.reversal, late])
    return Interval.around(width, reach, 0.0)


def _regression(records: list[MotionRecord], other: OtherCauses, window: int) -> ReversalRegression:
    return ReversalRegression(
        [_rows(record, other.loads_and_friction, window, 0.0) for record in records]
    )


def _with_earlier_effort(record: MotionRecord, delay: float) -> MotionRecord:
    """Return the first LONGEST samples, each with the effort that was logged `delay` [s] later."""
    part = record.part(slice(0, LONGEST))
    return replace(part, effort=np.interp(part.time + delay, record.time, record.effort))


def _rows(
    record: MotionRecord, other: Callable[[SmoothedMotion], list[Vector]], window: int, gap: float
) -> ReversalRows:
    """Return the rows outside the backlash `gap` [rad | m], with regressors from `other`."""
    strokes, g = find_strokes(record), sampled_test_function(window)
    acceleration, velocity, effort = smoothed_by(record, g)
    mask = slip_mask(record, strokes, velocity, window, gap)
    slope = np.gradient(effort, record.period)
    mask &= np.isfinite(slope)
    moving = np.gradient(record.position, record.period)
    plain = np.column_stack((acceleration, velocity, strokes.sign, np.ones(velocity.size)))[mask]
    # a position integrated from a measured velocity suffices for the loads
    at = replace(record, velocity=None)
    motion = SmoothedMotion(at, window, acceleration, velocity, effort, strokes.sign, mask)
    return ReversalRows(
        plain,
        np.column_stack([np.empty((plain.shape[0], 0)), *other(motion)]),
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


def _width(regression: ReversalRegression, widest: float, axis: Axis) -> float:
    """Return the width [rad | m], at most `widest`, at which the friction rises after a reversal.

    Raises UnusableLogs if the rows show no such rise.
    """
    count = float(np.unique(regression.stroke).size)
    width = regression.best_width(widest)
    value, residual = regression.fit_of(width)
    plain = regression.plain[:, :SLOPE]
    none = regression.effort - plain @ regression.fitted(plain)
    gain = count * np.log(np.sum(none**2) / np.sum(residual**2)) - 2.0 * np.log(count)
    if not (gain > EVIDENCE and value[OUTSIDE] > value[INSIDE]):
        hidden = regression.largest_hidden(widest)
        unit = si_unit("position", axis)
        raise UnusableLogs(
            "friction does not rise after reversals; a backlash of up to "
            f"{hidden:.3g} {unit} can stay hidden, if friction in it is lower by a quarter; record "
            "slow reversals"
            if hidden
            else "friction does not rise after reversals: no sign of backlash"
        )
    return width


def _gradual_rise(
    regression: ReversalRegression, width: float, widest: float, confidence: float
) -> float | None:
    """Return the length [rad | m] of a gradual rise of friction that fits the rows equally well.

    Return None if a backlash of the full width `width` [rad | m] explains the effort better
    (one-sided test of Vuong, 1989, over strokes).
    """
    index = np.unique(regression.stroke, return_inverse=True)[1]
    step = regression.fit_of(width)[1]
    for rise in GRADUAL:
        length = regression.best_width(2.0 * widest, rise)
        gradual = regression.fit_of(length, rise)[1]
        better = np.bincount(index, gradual**2 - step**2)
        if np.sum(better) <= scipy.special.ndtri(confidence) * np.std(better) * np.sqrt(
            better.size
        ):
            return length
    return None
