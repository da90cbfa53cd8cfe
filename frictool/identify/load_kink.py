"""Search for a position at which the load changes abruptly: a preloaded spring, or an end stop.

The effort of a load is the same in both directions of motion, whereas friction changes its sign.
The load is modelled by two straight lines over the position x, one on each side of a knot x_0:

    offset + stiffness x + jump H(x - x_0) + bend max(x - x_0, 0)

H is the unit step. A contact, such as a brake pad, often stiffens. A second search therefore uses
a load that begins at the knot, on the side with fewer samples. It is quadratic in the distance from
the knot, divided by the length of this side, d. Its effort at d = 1 is `rise`. A gear with friction
needs a larger effort against the load than with the load; `drag` is half of this difference at
d = 1, and s is the direction of motion:

    offset + stiffness x + rise d + curve (d^2 - d) + s (drag d + drag_curve (d^2 - d))

Each load is fitted together with the sliding parameters and the effects of the model, with x_0 at
each position of a grid. Each half of the strokes selects a position x_0; the fit to this half with
its x_0 predicts the other half. The kink is reported if all of these conditions hold:

- Both halves of the strokes select nearly the same position.
- The load with the knot predicts the strokes that cross the knot clearly better than two smooth
  loads: the loads of the model, and these loads plus gravity and a polynomial over the travel. The
  load with the knot also predicts significantly better than the loads of the model with further
  ripples, although these ripples have more parameters. A load with a drag also predicts
  significantly better than the second smooth load plus friction that is smooth over the travel.
- The parameters of the change differ significantly from 0, and noise of the acceleration cannot
  cause them.
- The change of the effort at the knot, or the rise, exceeds the half width of its interval. If the
  jump or the bend is fitted for each direction of motion separately, both results are similar;
  friction over position would change the effort of both directions by opposite amounts. The drag is
  at most the rise: otherwise the load could not move the axis.
- The change of the effort is at least LEAST_CHANGE times the Coulomb friction.

The smoothing windows are shorter than the windows of a fit, because a long window hides a jump and
excludes strokes in which the axis rests at the knot. Short windows leave more noise of the
acceleration. The windows are long enough that this noise, times the inertia, is well below the
smallest change that is reported.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import msgspec
import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Axis, Quantity, si_unit
from frictool.documents.valid_side import ValidSide
from frictool.identify.estimators.explanation_search import FALSE_ALARM
from frictool.identify.estimators.hypothesis_rows import ReducedRows
from frictool.identify.estimators.load_hypotheses import harmonic
from frictool.identify.estimators.searched_records import ROWS_PER_WINDOW, SearchedRecords
from frictool.identify.fit_result import SLIDING, Interval, UnusableLogs, intervals_around
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.regression import SingularRegressors, solve_triangles
from frictool.identify.regression.term_selection import WORTH, beyond_chance, halved
from frictool.identify.regression.tsqr import Tensor
from frictool.identify.rows.effects import Hypothesis, effect_names
from frictool.identify.rows.load_terms import DIRECTION, GRAVITY, RIPPLES, SPRING, TERMS
from frictool.identify.rows.regression_samples import (
    FEWEST_STROKES,
    RegressionSamples,
    joined,
    parameters_of,
    reduced,
)
from frictool.identify.rows.slip_fit import stroke_samples
from frictool.identify.rows.smoothing import (
    acceleration_response,
    measurement_noise,
    smoothing_kernel,
)
from frictool.typing import Vector

SHORTER = (0.25, 0.5, 1.0)  # lengths of the smoothing windows relative to the windows of a fit
KNOTS = 48  # number of intervals of the travel; the first search tries the knots between them
FINER = 8  # number of intervals of the second search in each interval of the first search
ORDER = 5  # order of the polynomial of a smooth load
MORE_RIPPLES = 3  # largest number of ripples in addition to those of the model
# least number of rows on each side of the knot in a stroke that crosses the knot; half a window
FEWEST_ROWS = ROWS_PER_WINDOW // 2
DEPENDENT = 1e-3  # least share of a column that the other columns do not explain
LEAST_CHANGE = 0.2  # least change of the effort, relative to the Coulomb friction
ALIKE = 0.5  # least ratio of the changes in the two directions of motion
QUIET = 0.25  # largest noise of the inertial effort, relative to the least change
TINY = float(np.finfo(np.float64).tiny)  # avoids the logarithm of 0
STIFFNESS = TERMS[SPRING][0]
KINK = Hypothesis("kink", ("jump", "bend"), "a kink of the load", "", is_load=True)
BEYOND = "rise", "curve", "drag", "drag_curve"
CONTACT = Hypothesis("contact", BEYOND, "a load beyond a position", "", is_load=True)


@dataclass(frozen=True)
class LoadKink:
    """Abrupt change of the load at a position, the knot.

    - position: position of the knot, rad | m
    - margin: largest error of `position`, rad | m
    - jump: change of the effort at the knot, N m | N; 0 if only the stiffness changes
    - bend: change of the stiffness at the knot, N m/rad | N/m
    - rise: effort at the outermost position beyond the knot, N m | N, if the load begins at the
      knot and stiffens; else 0
    - above: True if most samples lie at positions above the knot
    - squares: (squared prediction error with the kink)/(squared error with the best smooth load),
      geometric mean over the strokes
    """

    position: float
    margin: float
    jump: float
    bend: float
    rise: float
    above: bool
    squares: float

    def on_side(self, position: Vector | np.floating) -> NDArray[np.bool_]:
        """Return True for positions (n,) [rad | m] on the side of the knot with most samples.

        Positions within `margin` of the knot give False.
        """
        beyond = (position - self.position) * (1.0 if self.above else -1.0)
        return np.asarray(beyond > self.margin)

    def one_side(self, record: MotionRecord) -> MotionRecord | None:
        """Return the part of the record on the side with most samples; None if it has no motion."""
        part = record.inside(self.on_side(record.position))
        return part if part is not None and stroke_samples(part) > 0.0 else None

    def valid_side(self, axis: Axis) -> ValidSide:
        """Return the side of the knot with most samples, on which the model is valid."""
        ends = self.position - self.margin, self.position + self.margin
        position = Quantity(self.position, *ends, unit=si_unit("position", axis))
        return ValidSide("above" if self.above else "below", position)

    def shown(self, bench: Bench) -> str:
        """Return text on the kink, and on the positions at which the model is valid."""
        unit = si_unit("effort", bench.axis)
        if self.rise:
            change = f"a load that rises to {abs(self.rise):.3g} {unit} begins"
        elif self.jump:
            change = f"the load changes by {abs(self.jump):.3g} {unit}"
        else:
            unit = si_unit("stiffness", bench.axis)
            change = f"the stiffness of the load changes by {abs(self.bend):.3g} {unit}"
        one = self.valid_side(bench.axis)
        place = one.place(bench.axis).removeprefix(f"{one.side} ")
        return f"{change} at {place}; the model is valid {one.side} it only"

    def warning(self, bench: Bench) -> str:
        """Return the warning that names the kink and its possible causes."""
        causes = "contact" if self.rise else "spring preload, limp-home spring"
        return (
            f"{self.shown(bench)} ({causes} or end stop?); log the motion on the other side of it "
            "separately"
        )


@dataclass(frozen=True)
class _KinkSearch:
    """Search for a kink with regression rows of all records.

    - position: smoothed position of each row (sample of the regression), (n,), rad | m
    - reach: distance that the axis moves in half of the smoothing window, plus the encoder step,
      (n,), rad | m
    - smoothing_kernel: kernel that smooths effort and regressors
    - noise: rms noise of the acceleration due to the encoder, rad/s^2 | m/s^2
    - confidence: confidence of the intervals, 0 to 1
    - base: columns (n,) of a fit without the kink, by name
    - shape: searched load, KINK or CONTACT
    """

    samples: RegressionSamples
    position: Vector
    reach: Vector
    smoothing_kernel: Vector
    noise: float
    confidence: float
    base: Mapping[str, Vector]
    shape: Hypothesis

    @cached_property
    def stroke(self) -> NDArray[np.int64]:
        """Return the number of the stroke of each row, (n,); the numbers are consecutive."""
        return np.asarray(np.unique(self.samples.stroke, return_inverse=True)[1])

    @cached_property
    def forward(self) -> NDArray[np.bool_]:
        """Return True for each forward stroke, (s,)."""
        return np.bincount(self.stroke, self.samples.sign) > 0.0

    @cached_property
    def half(self) -> NDArray[np.int64]:
        """Return 0 or 1 for each stroke (s,): the half of the strokes to which it belongs."""
        return halved(np.arange(self.forward.size))

    @cached_property
    def predicted(self) -> Vector | None:
        """Return the squared prediction error of each stroke by fits without a kink, (s,).

        The result is None if one half of the strokes does not determine the fit.
        """
        return self.reduced_rows({}).squares([])

    @cached_property
    def step(self) -> float:
        """Return the spacing of the positions (knots) that the first search tries, rad | m."""
        return float(np.ptp(self.position)) / KNOTS

    def crossing(self, knot: float) -> NDArray[np.bool_]:
        """Return True for each stroke with rows on both sides of the knot, (s,)."""
        above = np.bincount(self.stroke, self.position > knot)
        below = np.bincount(self.stroke, self.position < knot)
        return np.minimum(above, below) >= FEWEST_ROWS

    def testable(self, knot: float) -> bool:
        """Return whether strokes of both halves cross the knot in both directions."""
        crossing = self.crossing(knot)
        groups = [crossing & (self.forward == side) for side in (True, False)]
        return all(
            np.count_nonzero(one) >= FEWEST_STROKES and np.unique(self.half[one]).size == 2
            for one in groups
        )

    def changes(self, knots: Sequence[float], rows: NDArray[np.bool_] | slice) -> Tensor:
        """Return the regressors of the searched load at the n selected rows for k knots, (k, n, q).

        The jump is smoothed by the kernel of the effort. The speed is assumed to be constant within
        a smoothing window.
        """
        beyond = self.position[rows] - np.array(knots)[:, None]
        if self.shape is CONTACT:
            sides, lengths = np.transpose([self.other_side(knot) for knot in knots])[..., None]
            share = np.maximum(sides * beyond, 0.0) / lengths
            signed = share * self.samples.sign[rows]
            parts = share, share**2 - share, signed, signed * share - signed
            return np.stack(parts, axis=2)
        passed = np.concatenate(([0.0], np.cumsum(self.smoothing_kernel)))
        share = np.interp(beyond / self.reach[rows], np.linspace(-1.0, 1.0, passed.size), passed)
        return np.stack((share, np.maximum(beyond, 0.0)), axis=2)

    def above(self, knot: float) -> bool:
        """Return whether most rows lie at positions above the knot."""
        return bool(np.median(self.position) > knot)

    def other_side(self, knot: float) -> tuple[float, float]:
        """Return the direction (+1 or -1) and the length [rad | m] of the side with fewer rows."""
        side = -1.0 if self.above(knot) else 1.0
        return side, max(float(np.max(side * (self.position - knot))), self.step)

    def best(self, rows: NDArray[np.bool_], knots: Sequence[float]) -> float:
        """Return the position in `knots` with the smallest residual of the selected rows."""
        fitted = np.linalg.qr(np.column_stack([one[rows] for one in self.base.values()]))[0]
        left = self.samples.effort[rows]
        left = left - fitted @ (fitted.T @ left)
        changes = self.changes(knots, rows)
        changes -= fitted @ (fitted.T @ changes)
        slope = left @ changes
        gram = changes.transpose(0, 2, 1) @ changes
        value = np.linalg.pinv(gram, DEPENDENT**2, hermitian=True) @ slope[:, :, None]
        return knots[int(np.argmax(slope[:, None, :] @ value))]

    def knot(self, rows: NDArray[np.bool_], knots: Sequence[float]) -> float:
        """Return the best position (`best`) on a fine grid around the best position in `knots`."""
        first = self.best(rows, knots)
        finer = first + self.step * np.linspace(-1.0, 1.0, 2 * FINER + 1)
        return self.best(rows, finer.tolist())

    def reduced_rows(self, columns: Mapping[str, Vector]) -> ReducedRows:
        """Return the rows with the base columns and `columns`, as triangular matrices."""
        table = {**self.base, **columns}
        sliding = [name for name in SLIDING if name in table]
        loads = {name: one for name, one in table.items() if name not in sliding}
        samples = replace(self.samples, loads=loads)
        even = np.ones(samples.velocity.size)
        plain, _, cluster, stroke = reduced(samples, even, len(sliding), ROWS_PER_WINDOW)
        names = (*sliding, *loads)
        return ReducedRows(samples, plain, cluster, stroke, names, tuple(self.base), self.noise)

    def with_kink(self, knot: float) -> ReducedRows:
        """Return the rows with the columns of a kink at `knot`."""
        return self.reduced_rows(
            dict(zip(self.shape.names, self.changes([knot], slice(None))[0].T, strict=True))
        )

    def found(self, rivals: Sequence[Vector], most: float) -> LoadKink | None:
        """Return the kink if it meets the conditions at the top of this module, else None.

        - rivals: squared prediction errors of each stroke with smooth loads, each (s,)
        - most: largest allowed squared prediction error, relative to the error of the best rival
        """
        low = float(self.position.min())
        knots = [knot for k in range(1, KNOTS) if self.testable(knot := low + self.step * k)]
        if not knots or not rivals:
            return None
        sides = [self.knot(self.half[self.stroke] == side, knots) for side in (0, 1)]
        if abs(sides[0] - sides[1]) > self.step:
            return None
        knot = self.knot(np.full(self.position.size, True), knots)
        margin = max(abs(one - knot) for one in sides) + self.step / FINER
        if not self.testable(knot):
            return None
        first, second = (self.with_kink(one).squares([self.shape]) for one in reversed(sides))
        if first is None or second is None:
            return None
        crossing = self.crossing(knot)
        logarithm = np.log(np.where(self.half == 0, first, second)[crossing] + TINY)
        ratio = max(
            (logarithm - np.log(rival[crossing] + TINY) for rival in rivals),
            key=lambda one: float(np.mean(one)),
        )
        share = float(np.exp(np.mean(ratio)))
        if share > most or not beyond_chance(ratio, 0.0 * ratio, self.confidence):
            return None
        try:
            rows = self.with_kink(knot)
            least = FALSE_ALARM / len(knots)
            if not rows.visible(self.shape, ()) or rows.probability(self.shape, ()) > least:
                return None
            change = self._change(rows, knot)
        except SingularRegressors:
            return None
        if change is None:
            return None
        return LoadKink(knot, margin, *change, self.above(knot), share)

    def _change(self, rows: ReducedRows, knot: float) -> tuple[float, float, float] | None:
        """Return (jump, bend, rise) of the load at `knot`, as in `LoadKink`, or None.

        The result is None if the change of the load is small or uncertain, or if it differs between
        the directions of motion.
        """
        both = _intervals(rows, self.shape, self.confidence)
        least = LEAST_CHANGE * abs(both["coulomb"].value)
        if self.shape is CONTACT:
            rise, drag = both["rise"], abs(both["drag"].value)
            if abs(rise.value) < max(least, drag) or rise.low * rise.high <= 0.0:
                return None
            return 0.0, 0.0, rise.value
        names = self.shape.names
        (changes,) = self.changes([knot], slice(None))
        back = (self.samples.sign < 0.0)[:, None]
        columns = np.column_stack((np.where(back, 0.0, changes), np.where(back, changes, 0.0)))
        split = replace(self.shape, names=(*names, *(f"{name}_backward" for name in names)))
        named = dict(zip(split.names, columns.T, strict=True))
        sides = _intervals(self.reduced_rows(named), split, self.confidence)
        shorter = min(knot - self.position.min(), self.position.max() - knot)
        for name, size in zip(names, (1.0, float(shorter)), strict=True):
            values = [sides[one].value for one in (name, f"{name}_backward")]
            if (
                size * abs(both[name].value) >= least
                and both[name].low * both[name].high > 0.0
                and min(values) * max(values) > 0.0
                and min(map(abs, values)) >= ALIKE * max(map(abs, values))
            ):
                jump = both["jump"].value if name == "jump" else 0.0
                return jump, both["bend"].value, 0.0
        return None


def load_kink(
    records: Sequence[MotionRecord],
    bench: Bench,
    load: LoadTerms | None,
    settings: IdentificationSettings,
) -> LoadKink | None:
    """Return the kink of the load that the records show, or None.

    `load` contains load terms that replace the terms of the bench; None to use the terms of the
    bench.
    """
    explained = bench if load is None else msgspec.structs.replace(bench, load=load)
    try:
        searched = _with_short_windows(SearchedRecords.of(records, explained, settings))
        parts = searched.samples_of_records(searched.declared_waves)
        samples = joined(parts)
        names, refused = parameters_of(samples)
    except UnusableLogs:
        return None
    position = samples.loads.get(STIFFNESS)
    if position is None or refused or names != SLIDING:
        return None
    times = [
        np.full(part.velocity.size, 0.5 * (window - 2) * record.period)
        for part, window, record in zip(parts, searched.windows, searched.records, strict=True)
    ]
    tried = {name for one in searched.hypotheses for name in one.names}
    # in equal strokes, viscous friction by direction resembles a load
    tried -= set(TERMS[DIRECTION])
    fitted = {name: one for name, one in samples.loads.items() if name not in tried}
    gravity = {name: samples.loads[name] for name in TERMS[GRAVITY] if name in samples.loads}
    plain = fitted if load is None else _disturbing(fitted)

    def search_with(loads: Mapping[str, Vector], shape: Hypothesis = KINK) -> _KinkSearch:
        return _KinkSearch(
            samples,
            position,
            np.concatenate(times) * np.abs(samples.velocity) + searched.records[0].resolution,
            smoothing_kernel(searched.windows[0], searched.records[0].period),
            searched.noise,
            settings.confidence,
            _independent({**dict(zip(names, samples.columns, strict=True)), **loads}),
            shape,
        )

    smooth = {**fitted, **_polynomial(position), **gravity}
    friction = {f"{name}_{DIRECTION}": samples.sign * one for name, one in smooth.items()}
    rivals = [search_with(loads).predicted for loads in (fitted, smooth)]
    kinks = []
    for shape, richer in ((KINK, []), (CONTACT, [{**smooth, **friction}])):
        searches = [
            search_with({**loads, STIFFNESS: position}, shape)
            for loads in (plain, {**fitted, **gravity})
        ]
        kink = _best_kink(searches, rivals, WORTH**2)
        if kink is None:
            continue
        rich = [search_with(one).predicted for one in ({**fitted, **_ripples(searched)}, *richer)]
        if _best_kink(searches, rich, 1.0) is not None:
            kinks.append(kink)
    return min(kinks, key=lambda one: one.squares, default=None)


def _best_kink(
    searches: Sequence[_KinkSearch], rivals: Sequence[Vector | None], most: float
) -> LoadKink | None:
    """Return the kink that predicts the strokes best, or None (`_KinkSearch.found`)."""
    known = [one for one in rivals if one is not None]
    found = [kink for one in searches if (kink := one.found(known, most)) is not None]
    return min(found, key=lambda one: one.squares, default=None)


def _disturbing(columns: Mapping[str, Vector]) -> dict[str, Vector]:
    """Return the columns of the effects, such as a delay, that are no loads over the position."""
    names = {*effect_names(), *TERMS[DIRECTION]}
    return {name: one for name, one in columns.items() if name in names}


def _polynomial(position: Vector) -> dict[str, Vector]:
    """Return the columns (n,) of a polynomial over the travel."""
    low = float(position.min())
    scaled = 2.0 * (position - low) / max(float(np.ptp(position)), TINY) - 1.0
    return {f"order_{k}": one for k, one in enumerate(legvander(scaled, ORDER).T) if k > 0}


def _ripples(searched: SearchedRecords) -> dict[str, Vector]:
    """Return the columns (n,) of further ripples, at most MORE_RIPPLES, that the rows show."""
    declared = searched.declared_waves
    waves = declared
    for _ in range(MORE_RIPPLES):
        used = [harmonic(term) for term in RIPPLES[len(declared) : len(waves)]]
        rows = searched.rows(waves)
        found = searched.ripple(rows, waves, used) or searched.long_ripple(rows, waves, used)
        if found is None:
            break
        waves = (*waves, found[1].number)
    loads = searched.samples(waves).loads
    names = [name for term in RIPPLES[len(declared) : len(waves)] for name in TERMS[term]]
    return {name: loads[name] for name in names}


def _with_short_windows(searched: SearchedRecords) -> SearchedRecords:
    """Return the records with the shortest windows in which noise hides no change of the load."""
    rows = searched.rows(searched.declared_waves)
    inertia, _, coulomb = np.abs(rows.fitted(rows.columns([]))[:3]).tolist()
    lengths = [searched.smoother(factor).windows for factor in SHORTER]
    windows = []
    for k, record in enumerate(searched.records):
        noise = inertia * measurement_noise(record)
        windows.append(
            next(
                (
                    one[k]
                    for one in lengths
                    if noise * float(np.linalg.norm(acceleration_response(record, one[k])))
                    <= QUIET * LEAST_CHANGE * coulomb
                ),
                searched.windows[k],
            )
        )
    return replace(searched, windows=tuple(windows))


def _independent(columns: Mapping[str, Vector]) -> dict[str, Vector]:
    """Return the columns (n,) that the preceding columns do not explain."""
    kept: dict[str, Vector] = {}
    basis = np.empty((next(iter(columns.values())).size, 0))
    for name, one in columns.items():
        left = one - basis @ (basis.T @ one)
        left -= basis @ (basis.T @ left)
        size = float(np.linalg.norm(left))
        if name in SLIDING or size > DEPENDENT * float(np.linalg.norm(one)):
            kept[name] = one
            basis = np.column_stack((basis, left / max(size, 1e-300)))
    return kept


def _intervals(rows: ReducedRows, kink: Hypothesis, confidence: float) -> dict[str, Interval]:
    columns = rows.columns([kink])
    solution = solve_triangles(rows.plain[:, :, [*columns, -1]], rows.cluster)
    names = [rows.names[k] for k in columns]
    return intervals_around(names, solution.value, solution.half_width(confidence))
