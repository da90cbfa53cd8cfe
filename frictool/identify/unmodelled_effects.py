"""Widen intervals by effects that the model lacks and the residual shows.

The residual of a fit varies between strokes, positions, directions and times if the machine has an
effect that the model lacks. The covariance over strokes (`regression`) does not include the error
that such an effect causes in the parameters, because every stroke has the same error. Here the
residual r of the model is regressed on the sliding columns X and on the columns Z of an effect:

    r = X d + Z g

The effect is accepted if Student's test of g, with the deviations of the jackknife over strokes and
Bonferroni's correction for all effects and their columns, is significant at the level 1 -
confidence. Then more effects are added to it, the most significant one first, until none is
significant by itself. The shift of d against the fit on X alone is the change of the parameters if
the model had these effects: the spread between models, which Buckland, Burnham and Augustin (1997)
add to the variance within one.

The end of an interval on the side of the shift moves by the shift, so that the interval contains
the shifted one. The opposite end moves to a distance of sqrt(half^2 + shift^2) from the value,
because different effects look alike and may shift a parameter in opposite directions. The largest
movement by an accepted effect counts. No end moves beyond the interval of the bench, unless the two
intervals do not overlap.

Noise of the acceleration attenuates its coefficient, and columns that resemble the acceleration
would explain the rest. If the encoder is so coarse that this noise is not small, the inertia keeps
its interval, and its effort counts as known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit
from frictool.identify.force_error import SlipRows, slip_rows
from frictool.identify.interval_checks import contradicts
from frictool.identify.motion_record import MotionRecord
from frictool.identify.outcome import sliding_intervals
from frictool.identify.regression.clusters import clusters
from frictool.identify.regression.regression import (
    LeastSquaresSolution,
    SingularRegressors,
    solve_triangles,
)
from frictool.identify.regression.tsqr import Tensor, triangles
from frictool.identify.rows.effects import WHAT
from frictool.identify.rows.slip_fit import SMALLEST_SHARE
from frictool.identify.rows.smoothing import acceleration_response, bump, measurement_noise
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import IntVector, Vector

MOST_ROWS = 40_000  # largest number of rows; of longer logs one row in several is used
MOST_EFFECTS = 4  # largest number of effects that act together
NOISY = 2.0 * SMALLEST_SHARE  # share of noise in the acceleration above which it is not used
SLOW_SHARE = 0.1  # speed of the Stribeck column's fall, relative to the largest speed
# largest effort of the effects relative to the measured effort (rms); columns that resemble the
# sliding columns would have any effort
LARGEST_EFFORT = 0.2
CERTAIN = 1e-4  # significance of an effect that is reported
NOTABLE = 3.0  # least factor by which a reported effect widens an interval


@dataclass(frozen=True)
class EffectSignals:
    """Smoothed signals (n,) of the slipping rows of one record, SI.

    - rise: difference of the efforts a quarter of a window after and before the row, N m | N
    - around: sum of the efforts one window after and before the row, N m | N
    - time, position: relative to their means
    - angle: measured position, rad | m
    """

    acceleration: Vector
    velocity: Vector
    sign: Vector
    rise: Vector
    around: Vector
    time: Vector
    position: Vector
    angle: Vector
    top_speed: float


@dataclass(frozen=True)
class UnmodelledEffect:
    """Effect that a model may lack.

    - what: name in messages
    - columns: function from the signals to the regressors, each (n,)
    - needs: signal without which the effect is not tried, or None: `acceleration` (not noisy),
      `position` (measured), or `angle` (measured, rotary)
    """

    what: str
    columns: Callable[[EffectSignals], tuple[Vector, ...]]
    needs: str | None = None


EFFECTS = (
    UnmodelledEffect(WHAT["delay"], lambda s: (s.rise,), "acceleration"),
    # the second difference of the effort without its middle, whose noise is that of the row
    UnmodelledEffect(WHAT["resonance"], lambda s: (s.around,), "acceleration"),
    UnmodelledEffect(WHAT["drift"], lambda s: (s.time, s.time**2)),
    UnmodelledEffect(WHAT["warming"], lambda s: (s.time * s.sign, s.time * s.velocity)),
    UnmodelledEffect(WHAT["viscous_by_direction"], lambda s: (np.abs(s.velocity),)),
    UnmodelledEffect(
        WHAT["stribeck"],
        lambda s: (s.sign * np.exp(-np.abs(s.velocity) / (SLOW_SHARE * s.top_speed)),),
    ),
    UnmodelledEffect(
        "viscous friction that is not proportional to speed",
        lambda s: (s.velocity * np.abs(s.velocity),),
    ),
    UnmodelledEffect(WHAT["spring"], lambda s: (s.position,), "position"),
    UnmodelledEffect(
        WHAT["friction_over_position"],
        lambda s: (s.position * s.sign, s.position**2 * s.sign),
        "position",
    ),
    UnmodelledEffect(WHAT["inertial_friction"], lambda s: (s.sign * np.abs(s.acceleration),)),
    UnmodelledEffect(WHAT["gravity"], lambda s: (np.sin(s.angle), np.cos(s.angle)), "angle"),
    UnmodelledEffect(
        WHAT["eccentricity"],
        lambda s: (
            s.acceleration * np.cos(s.angle) - s.velocity**2 * np.sin(s.angle),
            s.acceleration * np.sin(s.angle) + s.velocity**2 * np.cos(s.angle),
        ),
        "angle",
    ),
)


@dataclass(frozen=True)
class AcceptedEffects:
    """Effects that act together.

    - what: names of the effects, the first one accepted first
    - significance: of the last one
    - shift: change of each sliding parameter, (p,)
    """

    what: tuple[str, ...]
    significance: float
    shift: Vector


@dataclass(frozen=True)
class WidenedFit:
    """Fit with intervals that include unmodelled effects.

    - what: most significant effect, if it is certain, or None
    - ratios: parameters that become much wider, with the ratios of the widths
    """

    fit: SlidingFit
    what: str | None = None
    ratios: Mapping[str, float] = field(default_factory=dict)

    def warnings(self, identified: Mapping[str, Interval]) -> tuple[str, ...]:
        """Return a warning that names the effect, if identified parameters have its intervals.

        Ramps may replace an interval of the fit.
        """
        wider = [
            f"{name} {ratio:.2g}"
            for name, ratio in self.ratios.items()
            if name in identified and identified[name].high == self.fit.parameters[name].high
        ]
        if self.what is None or not wider:
            return ()
        return (
            f"the residual has a structure that the model lacks, most like {self.what}; the "
            f"intervals include its effect ({', '.join(wider)} times as wide)",
        )


def widened(
    fit: SlidingFit, records: Sequence[MotionRecord], bench: Bench, confidence: float
) -> WidenedFit:
    """Return the fit with the intervals of its sliding parameters widened."""
    regression = _regression(fit, records, bench)
    if regression is None:
        return WidenedFit(fit)
    parameters = dict(fit.parameters)
    accepted = regression.accepted(1.0 - confidence)
    for k, name in enumerate(regression.names):
        for one in accepted:
            parameters[name] = _hull(
                parameters[name],
                _moved(fit.parameters[name], float(one.shift[k]), getattr(bench.mechanics, name)),
            )
    best = min(accepted, key=lambda one: one.significance, default=None)
    if best is None or best.significance > CERTAIN:
        return WidenedFit(replace(fit, parameters=parameters))
    ratios = {
        name: one.half_width / fit.parameters[name].half_width
        for name, one in parameters.items()
        if one.half_width > NOTABLE * fit.parameters[name].half_width > 0.0
    }
    return WidenedFit(replace(fit, parameters=parameters), best.what[-1], ratios)


def _hull(one: Interval, other: Interval) -> Interval:
    return replace(one, low=min(one.low, other.low), high=max(one.high, other.high))


def _moved(interval: Interval, shift: float, known: Quantity | None) -> Interval:
    """Return the interval with both ends moved outward because of a shift.

    No end moves beyond the interval of the bench, unless the bench contradicts the interval.
    """
    low = min(interval.low + shift, interval.value - np.hypot(interval.value - interval.low, shift))
    high = max(
        interval.high + shift, interval.value + np.hypot(interval.high - interval.value, shift)
    )
    if not contradicts(interval, known) and known is not None and known.low is not None:
        low = max(low, known.low)
        high = min(high, known.interval[1])
    return _hull(interval, Interval(interval.value, float(low), float(high)))


@dataclass(frozen=True)
class _EffectRegression:
    """Triangles (g, q, q) of [sliding columns, columns of all effects, residual] by cluster (g,).

    `names` are the sliding columns, which come first; `places` are the effects with the indices of
    their columns. `effort` is the norm of the measured effort.
    """

    parts: Tensor
    cluster: IntVector
    names: tuple[str, ...]
    places: tuple[tuple[UnmodelledEffect, range], ...]
    effort: float

    def accepted(self, level: float) -> list[AcceptedEffects]:
        """Return effects that explain the residual alone, and effects that act together."""
        alone = self._solved([])
        if alone is None:
            return []
        base = alone.value
        out = []
        chosen: list[tuple[UnmodelledEffect, range]] = []
        while len(chosen) < MOST_EFFECTS:
            tried = []
            for place in self.places:
                if place in chosen:
                    continue
                solution = self._solved([*chosen, place])
                if solution is not None:
                    tried.append((_significance(solution, len(place[1])), place, solution.value))
            significant = [one for one in tried if one[0] < level]
            best = min(significant, key=lambda one: one[0], default=None)
            # no effect acts on a machine that obeys the model, so that all tests together have the
            # level; once one is accepted, each further one has it
            if best is None or (not chosen and best[0] > level / len(self.places)):
                break
            # in the first round also other effects with at least half of the best one's evidence
            alike = [one for one in significant if one[0] <= np.sqrt(best[0])]
            for level_of, place, value in [best] if chosen else alike:
                what = tuple(effect.what for effect, _ in [*chosen, place])
                shift = self._plausible([*chosen, place], value) * (value[: len(self.names)] - base)
                out.append(AcceptedEffects(what, level_of, shift))
            chosen.append(best[1])
        return out

    def _plausible(self, places: Sequence[tuple[UnmodelledEffect, range]], value: Vector) -> float:
        """Return the factor that limits the effort of effects to LARGEST_EFFORT, 1 if it is less.

        `value` are the sliding parameters and the coefficients of the effects.
        """
        columns = [k for _, place in places for k in place]
        effort = float(np.linalg.norm(self.parts[:, :, columns] @ value[len(self.names) :]))
        return min(1.0, LARGEST_EFFORT * self.effort / max(effort, 1e-300))

    def _solved(
        self, places: Sequence[tuple[UnmodelledEffect, range]]
    ) -> LeastSquaresSolution | None:
        columns = [*range(len(self.names)), *(k for _, place in places for k in place), -1]
        try:
            return solve_triangles(self.parts[:, :, columns], self.cluster)
        except SingularRegressors:
            return None


def _significance(solution: LeastSquaresSolution, count: int) -> float:
    """Return the significance of the last `count` parameters together, 0 to 1."""
    deviation = solution.deviation[-count:]
    if not np.all(np.isfinite(deviation) & (deviation > 0.0)):
        return 1.0
    ratio = np.abs(solution.value[-count:]) / deviation
    return float(
        min(1.0, 2.0 * count * np.min(scipy.special.stdtr(solution.freedom[-count:], -ratio)))
    )


def _regression(
    fit: SlidingFit, records: Sequence[MotionRecord], bench: Bench
) -> _EffectRegression | None:
    """Return the regression of the residual, or None if no row slips or nothing is free."""
    intervals = {**sliding_intervals(fit.parameters, bench), **fit.parameters}
    values = {name: interval.value for name, interval in intervals.items()}
    found = [(record, slip_rows(record, bench)) for record in records]
    tables = [
        _table(record, rows, rows.effort - rows.modelled_effort(values, fit.laws))
        for record, rows in found
        if rows is not None
    ]
    names = [name for name in SLIDING if name in fit.parameters and name not in fit.fixed]
    missing = {"angle"} if bench.axis == "linear" else set()
    if any(one.noise_share > NOISY for one in tables):
        missing.add("acceleration")
        names = [name for name in names if name != "inertia"]
    if any(record.velocity is not None for record in records):
        missing |= {"position", "angle"}
    if not tables or not names:
        return None
    signals = EffectSignals(
        **{
            name: np.concatenate([getattr(one.signals, name) for one in tables])
            for name in EffectSignals.__annotations__
            if name != "top_speed"
        },
        top_speed=max(one.signals.top_speed for one in tables),
    )
    every = -(-signals.velocity.size // MOST_ROWS)
    above = np.cumsum([0, *(int(one.stroke[-1]) + 1 for one in tables)])
    stroke = np.concatenate([one.stroke + first for one, first in zip(tables, above, strict=False)])
    counts = np.concatenate([one.counts for one in tables])
    shortest = max(one.shortest for one in tables)
    number = clusters(stroke, signals.sign, counts, shortest)[::every]
    sliding = {
        "inertia": signals.acceleration,
        "viscous": signals.velocity,
        "coulomb": signals.sign,
        "offset": np.ones(signals.sign.size),
    }
    columns = [sliding[name] for name in names]
    places = []
    for effect in EFFECTS:
        if effect.needs not in missing:
            more = effect.columns(signals)
            places.append((effect, range(len(columns), len(columns) + len(more))))
            columns += more
    columns.append(np.concatenate([one.residual for one in tables]))
    starts = np.flatnonzero(np.diff(number, prepend=-1))
    thinned = tuple(column[::every] for column in columns)
    effort = float(np.sqrt(sum(np.sum(rows.effort**2) for _, rows in found if rows) / every))
    parts = triangles(thinned, np.ones(number.size), starts)
    return _EffectRegression(parts, number[starts], tuple(names), tuple(places), effort)


@dataclass(frozen=True)
class _Table:
    """Rows (n,) of one record: signals, residual, stroke, encoder counts per row.

    - shortest: rows over which residuals are correlated
    - noise_share: noise of the acceleration over its rms
    """

    signals: EffectSignals
    residual: Vector
    stroke: IntVector
    counts: Vector
    shortest: int
    noise_share: float


def _table(record: MotionRecord, rows: SlipRows, residual: Vector) -> _Table:
    strokes = find_strokes(record)
    effort = np.convolve(record.effort, bump(rows.window, record.period), mode="same")
    quarter = rows.window // 4

    def near(distance: int) -> Vector:
        return effort[np.clip(rows.index + distance, 0, effort.size - 1)]

    signals = EffectSignals(
        rows.acceleration,
        rows.velocity,
        strokes.sign[rows.index],
        near(quarter) - near(-quarter),
        near(rows.window) + near(-rows.window),
        rows.time - float(np.mean(rows.time)),
        rows.position - float(np.mean(rows.position)),
        rows.position,
        float(np.max(np.abs(rows.velocity))),
    )
    counts = np.abs(rows.velocity) * record.period / record.resolution
    response = float(np.linalg.norm(acceleration_response(record, rows.window)))
    size = float(np.sqrt(np.mean(rows.acceleration**2)))
    noise = measurement_noise(record) * response / max(size, 1e-300)
    return _Table(signals, residual, strokes.number[rows.index], counts, 3 * rows.window, noise)
