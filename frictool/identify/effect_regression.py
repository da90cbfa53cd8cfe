"""Regression of the effort, to test for effects that the model does not include.

Each effect, such as a spring or a delay, is a hypothesis with columns in the regressor matrix
(`estimators/explanation_search.py`). A hypothesis is preferred if it predicts the effort better in
strokes that were left out of the fit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.identify.assess.identifiability import STROKE_MEANS
from frictool.identify.breakaway.onset_load import SPRING_UNIT, harmonic_units
from frictool.identify.estimators.explanation_search import EQUAL, LIKE_ACCELERATION
from frictool.identify.estimators.hypothesis_rows import ReducedRows
from frictool.identify.estimators.load_hypotheses import declared_term, harmonic, wave_numbers
from frictool.identify.estimators.searched_records import ECCENTRICITY, SearchedRecords
from frictool.identify.fit_result import (
    SLIDING,
    Interval,
    SlidingFit,
    UnusableLogs,
    intervals_around,
)
from frictool.identify.force_error import friction_in_slip
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.outcome import sliding_intervals
from frictool.identify.regression.multiway import equal_bins, shared_variance
from frictool.identify.regression.regression import SingularRegressors, solve_triangles
from frictool.identify.regression.term_selection import beyond_chance
from frictool.identify.rows.effects import DELAY, FALLS, WARMING, Hypothesis
from frictool.identify.rows.load_terms import (
    GRAVITY,
    RIPPLES,
    SPRING,
    TERMS,
    bench_with_terms,
    terms_of,
)
from frictool.identify.rows.regression_samples import RegressionSamples, with_fixed, without_loads
from frictool.identify.rows.shape_over_speed import named_by_shape
from frictool.plant.position_load import PositionLoad
from frictool.typing import IntVector, Matrix, Vector

BINS = 24  # number of bins of the position, and of velocity and sign of the acceleration
# a parameter depends on few rows if (sum q)^2/(n sum q^2) is below this value; q are the squared
# influences of the n rows on the parameter; a sinusoidal motion gives 0.5
FEW_ROWS = 0.2
MOST_EFFECTS = 4  # largest number of effects that are added to the model
FEWEST_STROKES = 12  # with fewer strokes, the halves of the data hardly predict each other
RESONANCE = "resonance"
SCALED = ("inertia", "viscous")  # parameters that a wrong gain of the encoder scales
# largest rms effort of the effects, relative to the measured rms effort, if the rms residual is
# smaller; an effect that resembles inertia or friction could otherwise be fitted with any effort
LARGEST_EFFORT = 0.2
# largest eccentricity of an encoder, rad: ten times the error of a usual magnetic encoder
LARGEST_ECCENTRICITY = 0.05


@dataclass(frozen=True)
class AcceptedEffects:
    """Effects that the model does not include, and that can act together.

    - what: names of the effects in the order of acceptance
    - significance: p-value of the effect that was accepted last
    - shift: change of each sliding parameter if these effects are added to the model, with an
      effort limited to a plausible size
    - held_out: squared prediction error of the effort in strokes left out of the fit, divided by
      the error without the effects
    - scatter: half width of the interval of each shift; 0 for a parameter that is not a key
    - whole: `shift` with the fitted effort of the effects, without a limit
    - settle: advice on a test, or a change of bench.yaml, that would show whether the last effect
      acts
    - one_sided: True if the effects can shift a parameter in the direction of `shift` only
    """

    what: tuple[str, ...]
    significance: float
    shift: Mapping[str, float]
    held_out: float = 1.0
    scatter: Mapping[str, float] = field(default_factory=dict)
    whole: Mapping[str, float] = field(default_factory=dict)
    settle: str = ""
    one_sided: bool = False


@dataclass(frozen=True)
class EffectRegression:
    """Regression of the effort with the columns of the model and of all hypotheses.

    A hypothesis is a load or an effect that possibly acts, such as a spring or a delay.

    - used: hypotheses that the model includes
    - free: hypotheses that the model does not include
    - names: sliding parameters that are fitted, and not fixed
    - noisy: True if the acceleration is too noisy to test effects whose columns resemble the
      acceleration
    - winding: True if the drive is a voltage drive whose winding can delay the effort
    - confidence: confidence of the intervals, 0 to 1
    - load_zero: position at which the load columns are 0, rad | m; None if they are not shifted
      (`SlidingFit.load_zero`)
    """

    rows: ReducedRows
    used: tuple[Hypothesis, ...]
    free: tuple[Hypothesis, ...]
    names: tuple[str, ...]
    confidence: float
    noisy: bool = False
    winding: bool = False
    load_zero: float | None = None

    @property
    def tested(self) -> list[Hypothesis]:
        """Return those hypotheses in `free` that can be tested.

        If `noisy`, hypotheses whose columns resemble the acceleration cannot be tested, except a
        lag of a winding (`explanation_search`).
        """
        hidden = LIKE_ACCELERATION if self.noisy else ()
        lags = self.winding and self.rows.lags(self.used)
        return [one for one in self.free if one.term not in hidden or (lags and one.term == DELAY)]

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """Return all hypotheses, those in the model and the others."""
        return (*self.used, *self.free)

    def without(self, one: Hypothesis) -> EffectRegression:
        """Return the regression of the model without the hypothesis `one`."""
        used = tuple(other for other in self.used if other is not one)
        free = tuple(other for other in self.free if other is not one)
        return replace(self, used=used, free=(*free, one))

    def spread(self, parameters: Mapping[str, Interval]) -> dict[str, Interval]:
        """Return `parameters` with intervals widened by the scatter of the residual between bins.

        There are two sets of bins: bins of the position; and bins of the velocity, separately for
        each sign of the acceleration.
        """
        scatter = self.scatter()
        out = {}
        for name in self.names:
            half = float(np.hypot(parameters[name].half_width, scatter[name]))
            out[name] = Interval.around(parameters[name].value, half)
        return out

    def scatter(self, more: Sequence[Hypothesis] = ()) -> dict[str, float]:
        """Return half widths of all parameters from the scatter of the residual between bins.

        The residual is that of the model with the additional hypotheses `more`.
        """
        rows = self.rows
        used = [*self.used, *more]
        columns = rows.table(used)
        position = rows.samples.loads.get(TERMS[SPRING][0])
        groups = [_states(rows.samples)]
        groups += [] if position is None else [equal_bins(position, BINS)]
        variance = shared_variance(columns, rows.residual(used), rows.samples.stroke, groups)
        variance += self._variance_by_noise(columns, used)
        factor = float(scipy.special.stdtrit(BINS - columns.shape[1], 0.5 + 0.5 * self.confidence))
        names = [rows.names[k] for k in rows.columns(used)]
        return dict(zip(names, (factor * np.sqrt(variance)).tolist(), strict=True))

    def _variance_by_noise(self, columns: Matrix, used: Sequence[Hypothesis]) -> Vector:
        """Return the variance (p,) of the parameters due to noise of the acceleration.

        `columns` (n, p) are the regressors of a fit with the hypotheses `used`. The variance is 0
        unless viscous friction depends on few rows (FEW_ROWS). The noise is assumed to repeat in
        every stroke, so that more strokes do not reduce the variance. The rms effort of the noise
        is limited to the rms residual.
        """
        rows = self.rows
        scale = np.linalg.norm(columns, axis=0)
        influence = np.linalg.pinv(columns / scale) ** 2 / scale[:, None] ** 2
        names = [rows.names[k] for k in rows.columns(used)]
        if "viscous" not in names:
            return np.zeros(scale.size)
        viscous = influence[names.index("viscous")]
        if np.sum(viscous) ** 2 > FEW_ROWS * viscous.size * np.sum(viscous**2):
            return np.zeros(scale.size)
        fixed = rows.samples.fixed.get("inertia")
        inertia = float(rows.fitted(rows.columns(used))[0]) if fixed is None else fixed.value
        strokes = np.unique(rows.samples.stroke).size
        left = float(np.sqrt(np.mean(rows.residual(used) ** 2)))
        noise = min(inertia * rows.noise, left)
        return np.asarray(noise**2 * strokes * np.sum(influence, axis=1))

    def intervals(self, more: Sequence[Hypothesis] = ()) -> dict[str, Interval]:
        """Return the intervals of all parameters of the model extended by the hypotheses `more`.

        The intervals follow from the scatter between strokes. The result is empty if the rows do
        not determine the parameters.
        """
        columns = self.rows.columns([*self.used, *more])
        try:
            solution = solve_triangles(self.rows.plain[:, :, [*columns, -1]], self.rows.cluster)
        except SingularRegressors:
            return {}
        names = [self.rows.names[k] for k in columns]
        return intervals_around(names, solution.value, solution.half_width(self.confidence))

    def attenuation(self) -> float:
        """Return the relative decrease of the fitted inertia due to noise of the acceleration."""
        left = self.rows.left_by_others(self.used)
        return min(self.rows.noise**2 / left, 1.0) if left > 0.0 else 1.0

    def accepted(self) -> list[AcceptedEffects]:
        """Return the effects, alone or in groups, that explain a part of the residual.

        The result also contains effects that could replace an effect of the model: with them, the
        prediction of strokes left out of the fit is not worse.
        """
        if self.values(self.used) is None or self.rows.squares(self.used) is None:
            return []
        out = self._rivals()
        chosen = list(self.used)
        level = 1.0 - self.confidence
        while len(chosen) < len(self.used) + MOST_EFFECTS:
            first = len(chosen) == len(self.used)
            tried = [
                (self.rows.probability(one, chosen), one)
                for one in self.tested
                if one not in chosen and self.rows.visible(one, chosen)
            ]
            # Bonferroni's correction until an effect is accepted; then each test has the full level
            best = min(tried, key=lambda one: one[0], default=None)
            if best is None or best[0] > level / (1.0 if chosen else len(tried)):
                break
            for significance, one in self._alike(best[1], tried) if first else [best]:
                out += self.shifted([*chosen, one], significance)
            chosen.append(best[1])
        return out

    def _alike(
        self, best: Hypothesis, tried: Sequence[tuple[float, Hypothesis]]
    ) -> list[tuple[float, Hypothesis]]:
        least = self.rows.squares([*self.used, best])
        return [
            (significance, one)
            for significance, one in tried
            if one is best
            or (
                significance < 1.0 - self.confidence
                and self._as_good(self.rows.squares([*self.used, one]), least)
            )
        ]

    def timing(
        self,
        known: float,
        smoother: EffectRegression,
        slopes: Mapping[str, float] = MappingProxyType({}),
    ) -> AcceptedEffects | None:
        """Return the shift of the parameters by an unknown delay between effort and position.

        Before the fit, the delay is known to be within +-`known` [s]. The fitted delay is that of
        `smoother`, the same regression with longer smoothing windows: a servo feeds noise of the
        encoder back into the effort, this noise looks like a delay, and longer windows reduce it.
        The interval of the fitted delay is widened by the change of the delay from the shorter to
        the longer windows, as far as chance does not explain this change. The fitted delay and the
        range +-`known` are combined, weighted by inverse variances. If the fitted delay is longer
        than `known` and differs significantly from 0, only the fitted delay is used.

        The shift of a parameter is the delay times the parameter's change per second of delay. This
        change is taken from `slopes` or, if `slopes` lacks the parameter, from the regression. The
        inertia is further increased if a winding can cause the delay (`winding_delay.py`).

        Return None if the model includes the delay, if the rows do not determine the delay, or if
        the delay is not significant although there are at least FEWEST_STROKES strokes.
        """
        late = next((one for one in self.free if one.term == DELAY), None)
        if late is None:
            return None
        rates = self.rates(late)
        rates |= {name: one for name, one in slopes.items() if name in rates}
        before = self.intervals([late]).get(DELAY)
        found = smoother.intervals([late]).get(DELAY)
        if not rates or before is None or found is None:
            return None
        half = float(np.hypot(found.half_width, unlikely_change(before, found)))
        shown = smoother.rows.probability(late, smoother.used) < 1.0 - self.confidence
        if not shown and np.unique(self.rows.stroke).size >= FEWEST_STROKES:
            return None
        weight = known**2 / (known**2 + half**2)
        if shown and abs(found.value) > known:
            weight = 1.0
        delay = Interval.around(weight * found.value, float(np.sqrt(weight)) * half)
        shift = {name: delay.value * one for name, one in rates.items()}
        if self.winding and delay.value < 0.0 and "inertia" in shift:
            viscous = (self.values([*self.used, late]) or {}).get("viscous", 0.0)
            shift["inertia"] -= delay.value * viscous
        return AcceptedEffects(
            (late.what,),
            1.0,
            shift,
            scatter={name: delay.half_width * abs(one) for name, one in rates.items()},
        )

    def resonant_inertia(self) -> Interval | None:
        """Return the inertia of a fit with a resonance; None if the log shows no resonance.

        The log shows a resonance if the coefficient of the resonance differs significantly from 0
        and is negative. The coefficient is negative if a load behind a spring increases the
        reflected inertia.
        """
        one = next((one for one in self.hypotheses if one.term == RESONANCE), None)
        if one is None or self.noisy or "inertia" not in self.names:
            return None
        others = [other for other in self.used if other is not one]
        found = self.intervals([] if one in self.used else [one])
        if RESONANCE not in found or found[RESONANCE].high >= 0.0:
            return None
        level = 1.0 - self.confidence
        return found["inertia"] if self.rows.probability(one, others) < level else None

    def inertia_with_undelayed_viscous(self, viscous: float) -> Interval | None:
        """Return the inertia of a fit in which `viscous` times the velocity is not delayed.

        In the regression, viscous a - du/dt replaces the column of the delay, -du/dt; a is the
        acceleration and u the effort. The result is None if the model lacks the delay or the
        inertia, or if the columns are linearly dependent.
        """
        columns = self.rows.columns(self.used)
        names = [self.rows.names[k] for k in columns]
        if DELAY not in names or "inertia" not in names:
            return None
        turned = np.eye(len(names) + 1)
        turned[names.index("inertia"), names.index(DELAY)] = viscous
        parts = self.rows.plain[:, :, [*columns, -1]] @ turned
        try:
            solution = solve_triangles(parts, self.rows.cluster)
        except SingularRegressors:
            return None
        half = solution.half_width(self.confidence)
        return intervals_around(names, solution.value, half)["inertia"]

    def rates(self, effect: Hypothesis) -> dict[str, float]:
        """Return the change of each free parameter per unit of the coefficient of `effect`.

        `effect` must have a single coefficient. The result is empty if the rows do not determine
        this coefficient.
        """
        alone = self.values(self.used)
        values = self.values([*self.used, effect])
        if alone is None or values is None:
            return {}
        (column,) = effect.names
        return {name: (values[name] - alone[name]) / values[column] for name in self.names}

    def encoder_gain(self, known: float) -> AcceptedEffects | None:
        """Return the shift of the parameters that an eccentric encoder can cause.

        Over less than a turn, the eccentricity mainly multiplies the position by a gain within 1 +-
        `known`. The log hardly determines this gain. The shift of a parameter is therefore limited
        to `known` times the parameter. Return None if the eccentricity is not in `free`, or if the
        eccentricity does not improve the prediction of strokes left out of the fit.
        """
        eccentric = next((one for one in self.free if one.term == ECCENTRICITY), None)
        if eccentric is None:
            return None
        values = self.values([*self.used, eccentric])
        alone = self.values(self.used)
        if values is None or alone is None or not self._improves(eccentric):
            return None
        shift = {}
        for name in self.names:
            if name in SCALED:
                limit = known * abs(alone[name])
                shift[name] = float(np.clip(values[name] - alone[name], -limit, limit))
        return AcceptedEffects((eccentric.what,), 1.0, shift)

    def _improves(self, one: Hypothesis) -> bool:
        before = self.rows.squares(self.used)
        after = self.rows.squares([*self.used, one])
        return before is not None and after is not None and bool(np.sum(after) < np.sum(before))

    def _rivals(self) -> list[AcceptedEffects]:
        """Return effects that can replace a hypothesis in `used` without a worse prediction.

        A spring can also replace a delay or a resonance that predicts better than the spring
        (`_spring_instead`).
        """
        least = self.rows.squares(self.used)
        out = []
        for one in self.used:
            others = [other for other in self.used if other is not one]
            for rival in self.tested:
                if one.needs_temperature and rival.term == WARMING:
                    continue  # a measured cause explains the change along the log
                if one.is_load and rival.only_widens:
                    continue  # such an effect is a polynomial that can imitate every load
                if self.rows.visible(rival, others) and self._as_good(
                    self.rows.squares([*others, rival]), least
                ):
                    out += self.shifted([*others, rival], 1.0)
            if one.term in LIKE_ACCELERATION:
                out += self._spring_instead(others)
        return out

    def _spring_instead(self, others: Sequence[Hypothesis]) -> list[AcceptedEffects]:
        """Return the change of the parameters from the model to a fit with a spring and `others`.

        Errors of the differentiated position resemble a delay or a resonance. A delay or a
        resonance can therefore predict the strokes better than a spring, although the spring acts.
        The result is [] unless the spring improves the prediction of the fit with `others` and
        its stiffness differs significantly from 0.
        """
        spring = next((one for one in self.tested if one.term == SPRING), None)
        if spring is None or not self.rows.visible(spring, others):
            return []
        before = self.rows.squares(others)
        after = self.rows.squares([*others, spring])
        if before is None or after is None or not beyond_chance(after, before, self.confidence):
            return []
        if self.rows.probability(spring, others) >= 1.0 - self.confidence:
            return []
        return self.alternative([*others, spring])

    def _as_good(self, squares: Vector | None, least: Vector | None) -> bool:
        return (
            squares is not None
            and least is not None
            and bool(np.sum(squares) <= EQUAL * np.sum(least))
            and not beyond_chance(least, squares, self.confidence)
        )

    def shifted(
        self, hypotheses: Sequence[Hypothesis], significance: float
    ) -> list[AcceptedEffects]:
        """Return the change of the parameters from the model to a fit with `hypotheses`, or [].

        The effort of hypotheses that the model lacks is limited to a plausible size. The result is
        [] if the rows do not determine the fit.
        """
        alone = self.values(self.used)
        values = self.values(hypotheses)
        if alone is None or values is None:
            return []
        more = [one for one in hypotheses if one not in self.used]
        factor = self._effort_limit_factor(more, hypotheses)
        fitted = {name: values[name] - alone[name] for name in self.names}
        shift = {name: factor * change for name, change in fitted.items()}
        shift = self._limited(shift, factor, hypotheses)
        whole = self._limited(fitted, 1.0, hypotheses)
        before = self.rows.squares(self.used)
        after = self.rows.squares(hypotheses)
        held_out = 1.0
        if before is not None and after is not None:
            held_out = float(np.sum(after) / max(np.sum(before), 1e-300))
        named = [
            self.named(one, [other for other in hypotheses if other is not one]) for one in more
        ]
        what = tuple(one.what for one in named)
        settle = named[-1].settle
        return [AcceptedEffects(what, significance, shift, held_out, whole=whole, settle=settle)]

    def named(self, one: Hypothesis, others: Sequence[Hypothesis]) -> Hypothesis:
        """Return the hypothesis `one` with a name and advice that suit its effort over speed.

        The effort is fitted together with the hypotheses `others` (`rows/shape_over_speed.py`). A
        hypothesis outside FALLS is returned unchanged.
        """
        model = [*others, one]
        values = self.values(model) if one.term in FALLS else None
        return one if values is None else named_by_shape(one, model, values, self.rows.samples)

    def alternative(self, hypotheses: Sequence[Hypothesis]) -> list[AcceptedEffects]:
        """Return the result of `shifted` for `hypotheses`, with the scatter of the change.

        The shifted intervals are at least as wide as the intervals of a fit with `hypotheses`. The
        result is empty if the rows do not determine this fit.
        """
        after = replace(self, used=tuple(hypotheses)).intervals()
        scatter = added_scatter(self.intervals(), after)
        return [replace(one, scatter=scatter) for one in self.shifted(hypotheses, 1.0) if after]

    def _limited(
        self, shift: Mapping[str, float], factor: float, hypotheses: Sequence[Hypothesis]
    ) -> dict[str, float]:
        """Return `shift`, with a limit on the part that is due to an eccentric encoder.

        `shift` is `factor` times the change by `hypotheses`. An eccentric encoder multiplies
        inertia and viscous friction by a factor within 1 +- LARGEST_ECCENTRICITY. Over less than a
        turn, the columns of the eccentricity resemble the columns of these parameters, so that a
        fit can give any factor.
        """
        others = [one for one in hypotheses if one.term != ECCENTRICITY or one in self.used]
        alone = self.values(self.used)
        without = self.values(others) if len(others) < len(hypotheses) else None
        if alone is None or without is None:
            return dict(shift)
        out = dict(shift)
        for name in SCALED:
            if name in out:
                other = factor * (without[name] - alone[name])
                limit = LARGEST_ECCENTRICITY * abs(alone[name])
                out[name] = other + float(np.clip(out[name] - other, -limit, limit))
        return out

    def values(self, hypotheses: Sequence[Hypothesis]) -> dict[str, float] | None:
        """Return the fitted parameters with `hypotheses`; None if the regressors are singular."""
        columns = self.rows.columns(hypotheses)
        try:
            values = self.rows.fitted(columns)
        except SingularRegressors:
            return None
        names = [self.rows.names[k] for k in columns]
        return dict(zip(names, values.tolist(), strict=True))

    def _effort_limit_factor(
        self, more: Sequence[Hypothesis], hypotheses: Sequence[Hypothesis]
    ) -> float:
        """Return the factor (at most 1) that limits the rms effort of the hypotheses `more`.

        The limit is the larger of the rms residual and LARGEST_EFFORT times the rms effort.
        """
        samples = self.rows.samples
        size = float(np.sqrt(np.mean((samples.effort + samples.known_effort) ** 2)))
        left = float(np.sqrt(np.mean(self.rows.residual(self.used) ** 2)))
        effort = sum(
            self.rows.effort(one, [other for other in hypotheses if other is not one])
            for one in more
        )
        return min(1.0, max(LARGEST_EFFORT * size, left) / max(effort, 1e-300))


def effect_regression(
    fit: SlidingFit,
    records: Sequence[MotionRecord],
    bench: Bench,
    confidence: float,
    smoother: float = 1.0,
    hides: bool = True,
) -> EffectRegression | None:
    """Return the regression of the effort; None if the axis never slips or all values are fixed.

    The smoothing windows are `smoother` times as long as in `fit`. If `hides` is True, the inertia
    is fixed if noise of the acceleration decreases it by more than the half width of its interval.
    It is fixed at the value of `fit` or, if `fit` has no inertia, at the value of the bench.
    """
    structure = bench_with_terms(bench, terms_of(fit.laws)) if fit.load is None else bench
    try:
        searched = SearchedRecords.of(records, structure, IdentificationSettings(confidence))
        searched = replace(searched.smoother(smoother), widens=True)
        waves = wave_numbers(fit.load) or searched.declared_waves
        samples = searched.samples(waves)
        noisy = searched.noisy(samples)
        samples = without_loads(_without_knees(samples, fit, bench), {*fit.refused, *fit.dropped})
        samples = with_fixed(samples, fit.fixed)
        if fit.load_zero is not None:
            samples = _relative_loads(samples, waves, fit.load_zero)
        rows = searched.reduced_rows(samples, waves)
    except UnusableLogs:
        return None
    names = tuple(name for name in SLIDING if name in fit.parameters and name in rows.base)
    if not names:
        return None
    terms = () if fit.load is None else fit.load.terms
    used = tuple(one for one in searched.hypotheses if declared_term(one) in terms)
    ripples = tuple(harmonic(term) for term in RIPPLES[len(searched.declared_waves) : len(waves)])
    free = tuple(one for one in searched.hypotheses if one not in used)
    winding = bench.actuator.winding_delays
    regression = EffectRegression(rows, (*used, *ripples), free, names, confidence, noisy, winding)
    regression = replace(regression, load_zero=fit.load_zero)
    if noisy and hides and _hidden(fit, regression):
        known = {**sliding_intervals(fit.parameters, bench), **fit.parameters}["inertia"]
        rows = searched.reduced_rows(with_fixed(samples, {**fit.fixed, "inertia": known}), waves)
        names = tuple(name for name in names if name != "inertia")
        return replace(regression, rows=rows, names=names)
    return regression


def load_units(waves: Sequence[float]) -> dict[str, tuple[PositionLoad, ...]]:
    """Return unit loads of spring, gravity and each ripple, by the name of the term.

    There is one unit load for each parameter of a term: this parameter is 1, the others are 0.
    `waves` are the wave numbers of the ripples, 1/rad | 1/m.
    """
    ripples = {term: harmonic_units(wave) for term, wave in zip(RIPPLES, waves, strict=False)}
    return {SPRING: SPRING_UNIT, GRAVITY: harmonic_units(1.0), **ripples}


def _relative_loads(
    samples: RegressionSamples, waves: Sequence[float], zero: float
) -> RegressionSamples:
    """Shift the load columns of the samples so that they are 0 at the position `zero` [rad | m]."""
    place = np.array([zero])
    loads = dict(samples.loads)
    for term, units in load_units(waves).items():
        for name, unit in zip(TERMS[term], units, strict=True):
            if name in loads:
                loads[name] = loads[name] - float(unit.at(place)[0])
    return replace(samples, loads=loads)


def added_scatter(
    before: Mapping[str, Interval], after: Mapping[str, Interval]
) -> dict[str, float]:
    """Return the scatter that widens each interval in `before` to its width in `after`.

    The half width and the scatter are added in quadrature. The scatter is 0 if the interval in
    `after` is narrower.
    """
    return {
        name: math.sqrt(max(after[name].half_width ** 2 - one.half_width**2, 0.0))
        for name, one in before.items()
        if name in after
    }


def unlikely_change(one: Interval, other: Interval) -> float:
    """Return the part of the change from `one` to `other` that chance does not explain.

    `one` is the estimate with the smaller variance. If the model is true, the variance of the
    change is the variance of `other` minus the variance of `one` (Hausman, 1978).
    """
    change = other.value - one.value
    chance = max(other.half_width**2 - one.half_width**2, 0.0)
    return float(np.copysign(np.sqrt(max(change**2 - chance, 0.0)), change))


def inertia_of_other_method(fit: SlidingFit) -> bool:
    """Return True if the inertia comes from the weak form or from means over strokes."""
    return fit.method == STROKE_MEANS or "position_order" in fit.details


def _hidden(fit: SlidingFit, regression: EffectRegression) -> bool:
    """Return whether noise can decrease the fitted inertia by more than its half width.

    The result is also True if the fit has no inertia, or an inertia from the weak form or from
    means over strokes. It is False if the inertia is fixed.
    """
    inertia = fit.parameters.get("inertia")
    if "inertia" not in regression.rows.base:
        return False
    if inertia_of_other_method(fit):
        return True
    return inertia is None or inertia.half_width < regression.attenuation() * inertia.value


def _states(samples: RegressionSamples) -> IntVector:
    half = BINS // 2
    return equal_bins(samples.velocity, half) + half * (samples.acceleration > 0.0)


def _without_knees(samples: RegressionSamples, fit: SlidingFit, bench: Bench) -> RegressionSamples:
    """Subtract the efforts of knees and of the Stribeck effect from the effort of the samples.

    At a knee, the viscous friction changes.
    """
    if fit.laws is None or not (fit.laws.regimes or "stribeck_velocity" in fit.parameters):
        return samples
    intervals = {**sliding_intervals(fit.parameters, bench), **fit.parameters}
    values = {name: interval.value for name, interval in intervals.items()}
    laws = Laws(regimes=fit.laws.regimes, stribeck_exponent=fit.laws.stribeck_exponent)
    still = np.zeros(samples.velocity.size)
    line = values["viscous"] * samples.velocity + values["coulomb"] * samples.sign
    friction = friction_in_slip(values, laws, still, samples.velocity)
    return replace(samples, effort=samples.effort - (friction - line))
