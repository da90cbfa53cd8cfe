"""Search for loads and disturbing effects that improve the prediction of the effort.

A hypothesis is a load or a disturbing effect, with one or more columns of the regressor matrix. The
search is a part of the method `auto`. It adds one hypothesis at a time to inertia, viscous
friction, Coulomb friction and offset. The hypotheses are:

- loads: a spring; on a rotary axis, gravity; harmonics of a ripple over the position, with wave
  numbers from the spectrum of the residual over the position or, for few periods, from repeated
  fits (`position_spectrum`)
- effects that only disturb the fit (`rows/effects.py`), such as an offset that drifts
- viscous friction that differs by direction; the search only compares this hypothesis with the
  others, because `structure_selection` decides whether it is used

A fit to one half of the strokes predicts the effort of the other half. The hypothesis with the
smallest prediction error is used if it passes two tests: the squared prediction errors decrease
significantly and noticeably, and the parameters of the hypothesis differ significantly from 0
(`joint_test`). A load is rejected if an effect predicts the strokes equally well, or if the load no
longer explains effort with smoothing windows of twice the length. A load that noise hides is used
if it passes both tests with these longer windows. At the end, a hypothesis is removed again in two
cases: the prediction errors increase little without the hypothesis, or a parameter that cannot be
negative has become negative, such as the coefficient of |acceleration|. Without a load, an effect
is removed again if another hypothesis predicts the strokes equally well (`_certain`). A spring of
negative stiffness is not used either: over a part of the travel, other effects look like such a
spring, and such effects are more frequent.

Significant hypotheses that are not used are reported as left in the residual.
docs/theory/identify_effects.md states further conditions and the significance levels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms
from frictool.identify.estimators.hypothesis_rows import ReducedRows
from frictool.identify.estimators.load_hypotheses import UNSTABLE_SPRING, Structure, declared_term
from frictool.identify.estimators.searched_records import ECCENTRICITY, SearchedRecords
from frictool.identify.fit_result import Explanation, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, delayed, sensed
from frictool.identify.regression.term_selection import WORTH, beyond_chance, clearly_better
from frictool.identify.rows.effects import DELAY, TEMPERATURE, WARMING, Hypothesis
from frictool.identify.rows.load_terms import DIRECTION, RIPPLES, SPRING, TERMS
from frictool.typing import Vector

FALSE_ALARM = 0.02  # probability that any hypothesis is significant if all are wrong
MOST_LEFT = 3  # largest number of hypotheses that are reported as left in the residual
# largest squared prediction error, relative to the error without the hypothesis, at which an effect
# is used, or a hypothesis is reported as left in the residual
NOTICEABLE = 0.95
LIKE_ACCELERATION = (DELAY, "resonance")  # effects that are not tried with noisy acceleration
SMOOTHER = 2.0  # factor on the smoothing windows of the second test of a load
# least rms effort of a load that only longer windows show, relative to the Coulomb friction
SMALLEST_LOAD = 0.01
EQUAL = 1.1  # largest ratio of the squared errors of two hypotheses that predict equally well


@dataclass(frozen=True)
class Trial:
    """Hypothesis under test, with the prediction errors of a fit that includes the hypothesis.

    - rows: regression rows of the fit
    - squares: squared prediction error of each stroke, (s,)
    - level: significance level of the test of the hypothesis
    - wave: wave number of a ripple, 1/rad | 1/m; None if the hypothesis is not a ripple
    """

    hypothesis: Hypothesis
    rows: ReducedRows
    squares: Vector
    level: float
    wave: float | None = None

    @property
    def sum(self) -> float:
        """Return the sum of the squared prediction errors over all strokes."""
        return float(np.sum(self.squares))


def _trials(
    searched: SearchedRecords,
    rows: ReducedRows,
    waves: tuple[float, ...],
    used: Sequence[Hypothesis],
) -> list[Trial]:
    hidden = _hidden(searched, rows, waves, used)
    free = [one for one in searched.hypotheses if one not in used and one.term not in hidden]
    level = 0.5 * FALSE_ALARM / max(len(searched.hypotheses), 1)
    candidates: list[tuple[Hypothesis, ReducedRows, float, float | None]] = [
        (one, rows, level, None) for one in free
    ]
    for found in (searched.ripple(rows, waves, used), searched.long_ripple(rows, waves, used)):
        if found is None:
            continue
        ripple, peak = found
        more = searched.rows((*waves, peak.number))
        candidates.append((ripple, more, 0.5 * FALSE_ALARM / peak.tried, peak.number))
    out = []
    for one, table, chance, wave in candidates:
        squares = table.squares([*used, one])
        if squares is not None and table.visible(one, used):
            named = one if _stable(one, table, used) else UNSTABLE_SPRING
            out.append(Trial(named, table, squares, chance, wave))
    return out


def _stable(one: Hypothesis, rows: ReducedRows, others: Sequence[Hypothesis]) -> bool:
    """Return True unless the hypothesis `one` is a spring with a negative fitted stiffness."""
    return one.term != SPRING or rows.fitted_to(one, others)[0] > 0.0


def _hidden(
    searched: SearchedRecords,
    rows: ReducedRows,
    waves: tuple[float, ...],
    used: Sequence[Hypothesis],
) -> tuple[str, ...]:
    """Return the effects that cannot be tested because the acceleration is noisy.

    A delay is tested in spite of the noise if, with longer smoothing windows, noise cannot imitate
    the delay, and the delay predicts the strokes better than any other hypothesis. The delay of a
    voltage drive is tested in spite of the noise if the effort acts later than logged, as with the
    inductance of the winding. Noise that a servo feeds back has the opposite effect: the effort
    seems to act earlier.
    """
    if not searched.noisy(rows.samples):
        return ()
    if searched.bench.actuator.winding_delays:
        return LIKE_ACCELERATION[1:] if rows.lags(used) else LIKE_ACCELERATION
    smoother = searched.smoother(SMOOTHER)
    try:
        smooth = smoother.rows(waves)
    except UnusableLogs:
        return LIKE_ACCELERATION
    squares = {
        one.term: float(np.sum(errors))
        for one in searched.hypotheses
        if one not in used
        and smooth.visible(one, used)
        and (errors := smooth.squares([*used, one])) is not None
    }
    best = min(squares, key=lambda term: squares[term], default=None)
    return tuple(term for term in LIKE_ACCELERATION if term != DELAY or best != DELAY)


def search_explanations(
    records: Sequence[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> tuple[LoadTerms | None, tuple[Explanation, ...]]:
    """Return the load terms that the logs support, and all significant explanations of the effort.

    The load terms are None if the logs support no hypothesis, or if the axis never slips. If the
    bench declares its loads, only the delay of a voltage drive can be added. The explanations
    include significant hypotheses that are not used.
    """
    try:
        searched = SearchedRecords.of(records, bench, settings)
        waves = searched.declared_waves
        rows = searched.rows(waves)
    except UnusableLogs:
        return None, ()
    used: list[Hypothesis] = []
    out: list[Explanation] = []
    best = rows.squares(used)
    trials = _trials(searched, rows, waves, used)
    rejected: list[Trial] = []
    declared = bench.load is not None
    while best is not None and trials and (not declared or bench.actuator.winding_delays):
        usable = [
            one
            for one in trials
            if _spans_a_turn(one)
            and one.hypothesis is not UNSTABLE_SPRING
            and not any(one is other for other in rejected)
            and (one.hypothesis.term == DELAY or not declared)
        ]
        if not usable:
            break
        trial = min(usable, key=lambda one: one.sum)
        if _of_encoder(searched, trial, used, waves):
            trials = [one for one in trials if one is not trial]
            continue
        if not _lasting(searched, trial, used, waves):
            break  # the load fits oscillations that a disturbing effect would fit equally well
        if trial.hypothesis.term == WARMING:
            cause = next((one for one in usable if one.hypothesis.term == TEMPERATURE), None)
            if cause is not None and _supported(cause, best, used, settings):
                trial = cause
        rivals = _rivals(trial, trials, settings.confidence)
        effect = next((one for one in rivals if not one.hypothesis.is_load), None)
        if trial.hypothesis.is_load and effect is not None:
            if effect not in usable:
                break
            rivals = [trial, *(one for one in rivals if one is not effect)]
            trial = effect
        if trial.hypothesis.term == DIRECTION:
            break
        if not (
            _supported(trial, best, used, settings)
            or _supported_smoother(searched, trial, used, waves)
        ):
            rejected.append(trial)
            continue
        out.append(_explanation(trial, used, float(np.sum(best)), rivals, "used"))
        used.append(trial.hypothesis)
        best = trial.squares
        if trial.wave is not None:
            waves = (*waves, trial.wave)
            rows = trial.rows
        trials = _trials(searched, rows, waves, used)
        rejected = []
    smooth = _smoother_rows(searched, waves, max(waves, default=None)) if len(used) > 1 else None
    for one in list(used):
        others = [other for other in used if other is not one]
        if not others:
            continue
        possible = rows.possible(one, others) and _stable(one, rows, others)
        needed = possible and (
            _better(one, best, rows.squares(others), settings.confidence)
            or (
                smooth is not None
                and one.is_load
                and _better(one, smooth.squares(used), smooth.squares(others), settings.confidence)
            )
        )
        if not needed:
            used = others
            best = rows.squares(used)
            out = [kept for kept in out if kept.name != declared_term(one) or kept.what != one.what]
    used, out = _certain(used, out)
    parts = {(declared_term(one), one.what) for one in _parts_of_delay(searched, rows, waves, used)}
    out = [one for one in out if (one.name, one.what) not in parts]
    used, kept_waves = _renumbered(used, waves, len(searched.declared_waves))
    if kept_waves != waves:
        waves, rows = kept_waves, searched.rows(kept_waves)
    out += _left(searched, rows, waves, used, settings)
    structure = Structure(tuple(one.term for one in used), waves)
    load = structure.load(searched.rotary) if used else None
    if load is not None and bench.load is not None:
        terms = (*bench.load.terms, *load.terms[1:])
        load = msgspec.structs.replace(bench.load, terms=tuple(dict.fromkeys(terms)))
    return load, tuple(out)


def _certain(
    used: list[Hypothesis], explanations: list[Explanation]
) -> tuple[list[Hypothesis], list[Explanation]]:
    """Return the effects in `used` without those that another hypothesis explains equally well.

    `explanations` belong to the hypotheses in `used`. The model document contains no effect. If a
    fitted effect does not act on the axis, the model predicts other logs worse than a fit without
    the effect. All effects are kept if a load is used, because the test of the load included them.
    A measured temperature, a delay and a resonance are always kept.
    """
    if any(one.is_load for one in used):
        return used, explanations
    kept = (TEMPERATURE, *LIKE_ACCELERATION)
    unsure = {(one.name, one.what) for one in explanations if one.rivals}
    left = [one for one in used if one.term in kept or (declared_term(one), one.what) not in unsure]
    names = {(declared_term(one), one.what) for one in left}
    return left, [one for one in explanations if (one.name, one.what) in names]


def _parts_of_delay(
    searched: SearchedRecords, rows: ReducedRows, waves: tuple[float, ...], used: list[Hypothesis]
) -> list[Hypothesis]:
    """Return the effects in `used` that only correct the first-order approximation of a delay.

    With a delay d, the effort acts as u(t - d) = u - d u' + d^2/2 u'' - ... The effect `delay` is
    the first term. The second term resembles a resonance, because most of u'' is inertia times a''.
    Near reversals, u' lacks the jump of the friction, which resembles friction under the inertial
    load. A lag has such parts, too. The test delays the effort by the fitted delay itself, or
    filters it by a lag of this size. All effects but delay and measured temperature are parts of
    the delay if the strokes are then predicted at least as well without them.
    """
    late = next((one for one in used if one.term == DELAY), None)
    effects = [one for one in used if not one.is_load and one.term not in (DELAY, TEMPERATURE)]
    if late is None or not effects:
        return []
    both = rows.squares(used)
    others = [one for one in used if one not in effects]
    time = -float(rows.fitted_to(late, [one for one in others if one is not late])[0])
    for move in (delayed, sensed) if time > 0.0 else (delayed,):
        moved = replace(searched, records=[move(one, time) for one in searched.records])
        try:
            exact = moved.rows(waves).squares(others)
        except UnusableLogs:
            continue
        if exact is not None and both is not None and np.sum(exact) <= np.sum(both):
            return effects
    return []


def _smoother_rows(
    searched: SearchedRecords, waves: tuple[float, ...], kept: float | None
) -> ReducedRows | None:
    """Return regression rows with longer smoothing windows; None if the windows cannot be longer.

    Longer windows hardly change the effort of a load, but reduce the noise of the acceleration,
    which may hide the load. The result is also None if longer windows would remove the ripple with
    the wave number `kept` [1/rad | 1/m]. `kept` is None if no ripple has to be kept.
    """
    smoother = searched.smoother(SMOOTHER)
    if smoother.windows == searched.windows:
        return None
    try:
        rows = smoother.rows(waves)
    except UnusableLogs:
        return None
    short = kept is not None and 2.0 * np.pi / kept < smoother.shortest_period(rows)
    return None if short else rows


def _supported_smoother(
    searched: SearchedRecords, trial: Trial, used: Sequence[Hypothesis], waves: tuple[float, ...]
) -> bool:
    """Return whether a load clearly improves the prediction over longer smoothing windows.

    The rms effort of the load must be at least SMALLEST_LOAD times the Coulomb friction, because
    the longer windows also show small errors of other effects.
    """
    one = trial.hypothesis
    if not one.is_load:
        return False
    columns = trial.rows.columns([*used, one])
    friction = [k for k, column in enumerate(columns) if trial.rows.names[column] == "coulomb"]
    coulomb = float(np.sum(np.abs(trial.rows.fitted(columns)[friction])))
    if trial.rows.effort(one, used) < SMALLEST_LOAD * coulomb:
        return False
    more = waves if trial.wave is None else (*waves, trial.wave)
    rows = _smoother_rows(searched, more, max(more, default=None))
    return (
        rows is not None
        and _better(
            one, rows.squares([*used, one]), rows.squares(used), searched.settings.confidence
        )
        and rows.probability(one, used) < trial.level
    )


def _renumbered(
    used: Sequence[Hypothesis], waves: tuple[float, ...], declared: int
) -> tuple[list[Hypothesis], tuple[float, ...]]:
    """Remove unused ripples, and renumber the others; return all hypotheses and wave numbers.

    Wave numbers are in 1/rad | 1/m. The first `declared` ripples belong to the bench and have no
    hypothesis.
    """
    numbers = dict(zip(RIPPLES, waves, strict=False))
    kept = [numbers[one.term] for one in used if one.term in RIPPLES]
    left = iter(RIPPLES[declared:])
    renamed = [
        replace(one, term=(term := next(left)), names=TERMS[term]) if one.term in RIPPLES else one
        for one in used
    ]
    return renamed, (*waves[:declared], *kept)


def _lasting(
    searched: SearchedRecords, trial: Trial, used: Sequence[Hypothesis], waves: tuple[float, ...]
) -> bool:
    """Return whether a load also explains the effort over longer smoothing windows.

    With longer windows, the rms prediction error must fall below WORTH times the error without the
    load, and the parameters of the load must differ significantly from 0. The result is True
    without this test in three cases: the hypothesis is not a load, longer windows would remove the
    ripple, or the windows cannot be longer.
    """
    one = trial.hypothesis
    more = waves if trial.wave is None else (*waves, trial.wave)
    rows = _smoother_rows(searched, more, trial.wave) if one.is_load else None
    if rows is None:
        return True
    simpler = rows.squares(used)
    squares = rows.squares([*used, one])
    if simpler is None or squares is None:
        return True
    smaller = bool(np.sum(squares) < WORTH**2 * np.sum(simpler))
    return smaller and rows.probability(one, used) < trial.level


def _of_encoder(
    searched: SearchedRecords, trial: Trial, used: Sequence[Hypothesis], waves: tuple[float, ...]
) -> bool:
    """Return whether a periodic encoder error predicts the strokes better than the ripple `trial`.

    An encoder error e sin(n x), with the position x and the wave number n, adds its second time
    derivative to the measured acceleration. The result is False if the hypothesis of `trial` is not
    a ripple.
    """
    n = trial.wave
    if n is None:
        return False
    samples = trial.rows.samples
    first, second = trial.hypothesis.names
    sine, cosine = (samples.loads[name] for name in (first, second))
    a, v = (samples.acceleration, samples.velocity)
    errors = {
        first: n * a * cosine - (n * v) ** 2 * sine,
        second: -n * a * sine - (n * v) ** 2 * cosine,
    }
    changed = replace(samples, loads={**samples.loads, **errors})
    squares = searched.reduced_rows(changed, (*waves, n)).squares([*used, trial.hypothesis])
    return squares is not None and beyond_chance(
        squares, trial.squares, searched.settings.confidence
    )


def _named_after_encoder(trial: Trial) -> Trial:
    one = trial.hypothesis
    what = one.what.replace("a ripple over the position", "a periodic error of the encoder")
    named = replace(one, what=what, settle="compare the encoder with another one")
    return replace(trial, hypothesis=named)


def _spans_a_turn(trial: Trial) -> bool:
    position = trial.rows.samples.loads.get(TERMS[SPRING][0])
    return (
        trial.hypothesis.term != ECCENTRICITY
        or position is None
        or float(np.ptp(position)) >= 2.0 * np.pi
    )


def _rivals(best: Trial, trials: Sequence[Trial], confidence: float) -> list[Trial]:
    """Return the other trials that predict the strokes nearly as well as the trial `best`.

    The sum of the squared prediction errors of such a trial is at most EQUAL times that of `best`,
    and not significantly larger.
    """
    return [
        one
        for one in trials
        if one is not best
        and one.sum <= EQUAL * best.sum
        and not beyond_chance(best.squares, one.squares, confidence)
    ]


def _supported(
    trial: Trial, simpler: Vector, used: Sequence[Hypothesis], settings: IdentificationSettings
) -> bool:
    return (
        _better(trial.hypothesis, trial.squares, simpler, settings.confidence)
        and trial.rows.probability(trial.hypothesis, used) < trial.level
    )


def _better(
    one: Hypothesis, richer: Vector | None, simpler: Vector | None, confidence: float
) -> bool:
    """Return whether the hypothesis `one` improves the prediction of the strokes.

    `richer` and `simpler` are the squared prediction errors (s,) of the strokes with and without
    the hypothesis. A load has to improve the prediction clearly, because the load becomes part of
    the model. An effect has to reduce the error noticeably and in most strokes. The effect of the
    measured temperature only has to reduce the error noticeably, because few strokes, those at
    extreme temperatures, show this effect.
    """
    if one.is_load or richer is None or simpler is None:
        return clearly_better(richer, simpler, confidence)
    noticeable = bool(np.sum(richer) < NOTICEABLE * np.sum(simpler))
    return noticeable and (one.needs_temperature or beyond_chance(richer, simpler, confidence))


def _left(
    searched: SearchedRecords,
    rows: ReducedRows,
    waves: tuple[float, ...],
    used: Sequence[Hypothesis],
    settings: IdentificationSettings,
) -> list[Explanation]:
    """Return at most MOST_LEFT explanations by significant hypotheses that are not used.

    The hypotheses are added one at a time; the next one is the hypothesis that reduces the squared
    prediction errors most.
    """
    out: list[Explanation] = []
    seen = list(used)
    while len(out) < MOST_LEFT:
        simpler = rows.squares(seen)
        if simpler is None:
            break
        significant = [
            one
            for one in _trials(searched, rows, waves, seen)
            if one.sum < NOTICEABLE * float(np.sum(simpler))
            and beyond_chance(one.squares, simpler, settings.confidence)
            and one.rows.probability(one.hypothesis, seen) < one.level
        ]
        if not significant:
            break
        trial = min(significant, key=lambda one: one.sum)
        if _of_encoder(searched, trial, seen, waves):
            trial = _named_after_encoder(trial)
        rivals = _rivals(trial, significant, settings.confidence)
        out.append(_explanation(trial, seen, float(np.sum(simpler)), rivals, "left"))
        seen.append(trial.hypothesis)
        rows = trial.rows
        waves = waves if trial.wave is None else (*waves, trial.wave)
    return out


def _explanation(
    trial: Trial,
    others: Sequence[Hypothesis],
    before: float,
    rivals: Sequence[Trial],
    state: str,
) -> Explanation:
    one = trial.hypothesis
    # ripples of nearly equal periods have the same name
    alike = tuple(dict.fromkeys(rival.hypothesis.what for rival in rivals))
    position = trial.rows.samples.loads.get(TERMS[SPRING][0])
    if position is not None and not _spans_a_turn(trial):
        turn = float(np.ptp(position)) / (2.0 * np.pi)
        alike = (
            *alike,
            f"another load with one cycle per turn (the travel is {turn:.2g} of a turn)",
        )
    return Explanation(
        declared_term(one),
        one.what,
        state,
        trial.rows.effort(one, others),
        trial.rows.probability(one, others),
        float(np.sqrt(trial.sum / before)) if before > 0.0 else 1.0,
        one.settle,
        alike,
    )
