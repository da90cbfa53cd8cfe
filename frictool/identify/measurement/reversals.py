"""Backlash and delay from strokes: what the effort does after a reversal, and how much later than
the position it is logged.

    effort = inertia a + (viscous v + coulomb s) [advance >= width] + brush s [advance < width] +
    offset - delay d(effort)/dt

in the weak form (`weak`), each column under its bell. Inside the backlash only the motor's own
friction acts. The width is searched, its indicator blurred over a count, or the way of a sample, so
that it may lie between two. The delay is linear, and found anew on the effort moved by it until
nothing is left, so that the noise of the derivative does not attenuate it. It comes from rows past
the backlash, of the bench or as it was found, whichever is wider: within it the brush's friction
passes for a delay. Schwarz's criterion says whether there is a gap at all. Strokes are left out in
turn for the intervals; the place of a reversal is known to a count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import ndtri

from frictool.documents.bench import Bench
from frictool.identify.assess.recorded_motion import recorded_facts
from frictool.identify.assess.weak_form_precision import weak_deviation
from frictool.identify.estimators.piecewise_friction import EVIDENCE
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.regression.regression import (
    LeastSquaresSolution,
    Matrix,
    SingularRegressors,
    solve,
)
from frictool.identify.rows.slip_fit import full_backlash
from frictool.identify.rows.slip_mask import slip_mask
from frictool.identify.rows.smoothing import smoothed_by
from frictool.identify.rows.strokes import find_strokes
from frictool.plant.weak_form import bell

ROUNDS = 4  # of the delay
PLACES = 40  # of the first search for the width
WIDEST = 0.4  # of the median stroke
SLOPE = 4  # its column
SEEN = 2.0  # counts past the backlash: as the slip mask leaves out
LONGEST = 200_000  # samples of a record that are looked at
LARGEST_DELAY = 0.25  # of the window: beyond, the linear term is not that of a delay


@dataclass(frozen=True)
class ReversalRows:
    """(n,): columns of one record under the bell where it moves; `advance`, `sign`, velocity
    `moving` (m,) of all its samples,

    `mask` (m,) which are rows."""

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
        """s and v (n, 2), each times [advance < width] blurred, under the bell."""
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
    """The full width of the backlash [rad | m] and the delay [s], or for each why not. Raises
    UnusableLogs where nothing moves."""
    facts = recorded_facts(records, bench)
    window = weak_deviation(list(facts.strokes), facts.axis, facts.sensing)[1]
    windows = [window, 2 * (3 * window // 4) + 1]
    widest = WIDEST * float(np.median([stroke.distance for stroke in facts.strokes]))
    gap, step = full_backlash(bench), max(record.resolution for record in records)
    for _ in range(
        2
    ):  # the second time past the backlash that was found, where the bench knew a narrower one
        late = _tried(lambda one: _delay(records, gap, one, confidence), windows)  # noqa: B023  # used at once
        moved = [
            _moved(record, late.value if isinstance(late, Interval) else 0.0) for record in records
        ]
        ranges = [
            step,
            facts.speed * (late.half_width if isinstance(late, Interval) else facts.sensing.period),
        ]
        width = _tried(lambda one: _backlash(moved, one, widest, ranges, confidence), windows)  # noqa: B023  # used at once
        if not isinstance(width, Interval) or width.high <= gap:
            break
        gap = width.high
    if isinstance(width, Interval) and width.half_width >= width.value:
        width = UnusableLogs(
            f"the backlash's width lies in [{width.low:.3g}, {width.high:.3g}], which tells next to nothing"
        )
    return width, late


def _tried(estimate: Callable[[int], Interval], windows: list[int]) -> Interval | UnusableLogs:
    """The first window's value, from the lowest to the highest of all windows' intervals: what the
    encoder's noise does differs in them."""
    try:
        found = [estimate(window) for window in windows]
    except UnusableLogs as error:
        return error
    return Interval(found[0].value, min(one.low for one in found), max(one.high for one in found))


def _delay(records: list[MotionRecord], gap: float, window: int, confidence: float) -> Interval:
    """From the rows past the backlash, a way of `gap` [rad | m]. Raises NothingUsable where they do
    not tell it."""
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
                f"the delay found, {delay:.3g} s, is too long for windows of {window} samples"
            )
    statistical = float(solution.half_width(confidence)[SLOPE]) / float(
        ndtri(0.5 + 0.5 * confidence)
    )
    if not np.isfinite(statistical):
        raise UnusableLogs(
            "the motion does not repeat often enough to tell the delay between the channels"
        )
    between = max(_between(record) for record in records)
    half = half_width(confidence, statistical, [between])
    return Interval(delay, delay - half, delay + half)


def _between(record: MotionRecord) -> float:
    """By how much a straight line between two samples of the effort is early or late, s: of one
    that lags, or of one that is held."""
    return record.period * (
        0.5 if record.lag == 0.0 else min(record.period / record.lag / 12.0, 0.5)
    )


def _backlash(
    records: list[MotionRecord], window: int, widest: float, ranges: list[float], confidence: float
) -> Interval:
    """From all rows; ranges [rad | m]: of the place of a reversal, and of what the delay makes of
    it.

    Raises NothingUsable where no gap shows.
    """
    rows = [_rows(record, window, 0.0) for record in records]
    width = _width(rows, widest)
    if width == 0.0:
        raise UnusableLogs(
            "friction does not rise with the way after a reversal: no backlash shows"
        )
    half, normal = (
        float(_solved(rows, width).half_width(confidence)[-1]),
        float(ndtri(0.5 + 0.5 * confidence)),
    )
    if not np.isfinite(half):
        raise UnusableLogs("too few reversals to tell how uncertain the backlash's width is")
    reach = half_width(confidence, half / normal, ranges)
    return Interval(width, max(width - reach, 0.0), width + reach)


def _moved(record: MotionRecord, delay: float) -> MotionRecord:
    """The first of a record, its effort as it was `delay` later."""
    part = slice(0, LONGEST)
    effort = np.interp(record.time[part] + delay, record.time, record.effort)
    reference = None if record.reference is None else record.reference[part]
    velocity = None if record.velocity is None else record.velocity[part]
    return replace(
        record,
        time=record.time[part],
        position=record.position[part],
        effort=effort,
        piece=record.piece[part],
        reference=reference,
        velocity=velocity,
    )


def _rows(record: MotionRecord, window: int, gap: float) -> ReversalRows:
    """Those further than `gap` [rad | m] past a reversal."""
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
    """Regressors (n, 5), effort (n,) and stroke (n,) of all records."""
    strokes, above = [], 0
    for one in rows:
        strokes.append(one.stroke + above)
        above += int(one.stroke[-1]) + 1 if one.stroke.size else 0
    plain = np.concatenate([np.column_stack((one.plain, one.slope)) for one in rows])
    return plain, np.concatenate([one.effort for one in rows]), np.concatenate(strokes)


def _width(rows: list[ReversalRows], widest: float) -> float:
    """The width that explains most, 0 where Schwarz's criterion does not ask for one."""
    plain, effort, stroke = _together(rows)
    count = float(np.unique(stroke).size)

    def squares(width: float) -> tuple[float, float]:
        columns = _split(rows, plain, width)
        value = np.linalg.lstsq(columns, effort, rcond=None)[0]
        return float(np.sum((effort - columns @ value) ** 2)), float(value[2] - value[4])

    places = np.linspace(0.0, widest, PLACES + 1)[1:]
    near = places[int(np.argmin([squares(float(place))[0] for place in places]))]
    bounds = (max(near - places[0], 0.1 * places[0]), near + places[0])
    found = float(
        minimize_scalar(lambda place: squares(place)[0], bounds=bounds, method="bounded").x
    )
    least, rise = squares(found)
    none = plain[:, :SLOPE]
    left = float(np.sum((effort - none @ np.linalg.lstsq(none, effort, rcond=None)[0]) ** 2))
    gain = count * np.log(left / least) - 2.0 * np.log(count)
    return found if gain > EVIDENCE and rise > 0.0 else 0.0


def _split(rows: list[ReversalRows], plain: Matrix, width: float) -> Matrix:
    """Regressors (n, 5): acceleration; speed and direction beyond the width; 1; direction within
    it."""
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
    """The regression, with the delay, or where there is a width with what it splits and its
    derivative by the width.

    Raises NothingUsable where the rows do not tell it.
    """
    plain, effort, stroke = _together(rows)
    if width > 0.0:
        step = max(rows[0].count, float(np.sqrt(np.mean(plain[:, 1] ** 2))) * rows[0].period)
        up, here, down = (
            _split(rows, plain, place) for place in (width + step, width, width - step)
        )
        value = np.linalg.lstsq(here, effort, rcond=None)[0]
        plain = np.column_stack((here, (up - down) @ value / (2.0 * step)))
    try:
        return solve(plain, effort, np.ones(effort.size), stroke)
    except SingularRegressors as error:
        raise UnusableLogs(f"the motion does not tell it: {error}") from None
