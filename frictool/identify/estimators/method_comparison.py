"""Choice of the method whose model best predicts strokes that the fit did not use.

The candidates are output error with the load terms that predict best (`structure_selection`), and
the regressions of `auto`, without and with these load terms. Each candidate is fitted to one half
of the logs and predicts the other half. The predictions are compared by the rms error of the
simulated position and by the force error.

A candidate is allowed if its force error is at most twice the smallest force error, because a model
with a wrong effort may still simulate the position well. The first allowed candidate with a
position error at most a tenth above the smallest is chosen. The order of preference is: the method
that the decision scheme of `auto` prefers, other regressions, output error. Output error is
rejected if its interval for a parameter does not contain the estimate of the regression with the
same load terms. This regression is fitted to all logs, and is available even if the halves of the
logs are too short for a fit, or do not determine all parameters. If there is no other candidate,
output error is also rejected if its force error on all logs is above twice that of this regression.

If the fit includes a disturbing effect (`rows/effects.py`), the preferred method is used without a
comparison, because the effect cannot be simulated. If the logs are too short to be halved, the
regressions are compared on the logs to which they were fitted. Output error is then no candidate,
because output error minimises the compared error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.quantity import si_unit
from frictool.identify.estimators.output_error import OUTPUT_ERROR, simulated_fit, start_values
from frictool.identify.estimators.segment_simulation import SegmentSimulation
from frictool.identify.estimators.structure_selection import (
    Sides,
    choose_structure,
    comparison_segments,
    halves,
    stroke_squares,
)
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit, TriedModel, UnusableLogs
from frictool.identify.force_error import SlipRows, force_error, motion_rows
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.effects import WHAT, declared_effects
from frictool.identify.rows.load_terms import (
    DIRECTION,
    POSITIVE,
    TERMS,
    bench_with_terms,
    laws_of,
    load_intervals,
    possible,
    terms_of,
)
from frictool.typing import Vector

Rows = Sequence[Sequence[SlipRows]]  # slipping samples of each half
NAMES = {DIRECTION: WHAT["viscous_by_direction"]}
# least ratio of the smallest position error to the position error of the chosen candidate
REFINED = 0.9
# half widths of the regression's interval by which a load must differ from 0
SURE = 2.0
MOST_FORCE = 2.0  # largest allowed force error, relative to the smallest force error


@dataclass(frozen=True)
class PredictionScore:
    """Errors of a candidate method on strokes that the fit did not use.

    - name, terms: name of the method, and load terms of its fit
    - squares: mean square of the position error in each stroke, (s,), rad^2 | m^2
    - force: relative force error, defined in `force_error.py`
    - fit: function that fits the candidate to all logs
    - extent: range of the measured positions, rad | m
    """

    name: str
    terms: tuple[str, ...]
    squares: Vector
    force: float
    fit: Callable[[], SlidingFit]
    extent: float = np.inf

    @property
    def position(self) -> float:
        """Return the position error (rms), rad | m."""
        return float(np.sqrt(np.mean(self.squares)))

    @property
    def leaves(self) -> bool:
        """Return True if the simulated position is far outside the range of the measured positions.

        The result is True if the rms position error exceeds this range; such an error has no
        meaning.
        """
        return not self.position <= self.extent

    def shown(self, unit: str) -> str:
        """Return name, position error in `unit`, and force error as text."""
        error = f"{self.position:.3g} {unit}"
        if self.leaves:
            error = f"leaves the measured range of {self.extent:.3g} {unit} by far"
        return f"{self.name} {error}, {100.0 * self.force:.3g} %"


@dataclass(frozen=True)
class ComparedData:
    """Logs of an axis, and the regressions that are compared on these logs.

    - fits: fits of the regressions to all logs, in the order of preference
    """

    records: list[MotionRecord]
    bench: Bench
    settings: IdentificationSettings
    fits: Sequence[SlidingFit]

    @property
    def extent(self) -> float:
        """Return the range of the measured positions, rad | m."""
        return max(float(np.ptp(record.position)) for record in self.records)

    def all(self, bench: Bench) -> tuple[list[MotionRecord], Bench, IdentificationSettings]:
        """Return all records, `bench` and the settings, as arguments of a method's fit."""
        return self.records, bench, self.settings


def best_by_prediction(data: ComparedData) -> SlidingFit:
    """Return the fit of the method that best predicts strokes that the fit did not use."""
    records = data.records
    bench = data.bench
    first = data.fits[0]
    if any(record.velocity is not None for record in records) or declared_effects(bench):
        return first
    sides = halves(records)
    rows = [motion_rows(side, bench) for side in sides or (records, records)]
    scores = regression_scores(sides or (records, records), rows, data)
    complete = all(
        name in first.parameters and (name == "offset" or first.parameters[name].value >= 0.0)
        for name in SLIDING
    )
    if sides is not None and first.laws is None and complete:
        scores += (
            regression_scores(sides, rows, data, (DIRECTION,))
            if DIRECTION in possible(bench)
            else []
        )
        scores += _simulations(sides, rows, data)
    if not scores:
        return first
    smallest = min(score.force for score in scores)
    allowed = [score for score in scores if score.force <= MOST_FORCE * smallest]
    winner, fit, against = _winner(allowed, scores, bench.load is not None)
    alone = fit.method == OUTPUT_ERROR and all(
        score.name.startswith(OUTPUT_ERROR) for score in scores
    )
    against_alone = _against_alone(first, fit, rows, bench) if alone else None
    if against_alone is not None:
        return replace(first, why=f"{first.why}; output-error is not used: {against_alone}")
    return replace(
        fit,
        why=_why(data, winner, scores, sides is not None) + against,
        tried=tuple(
            TriedModel(score.name, score.position, score.force, score is winner, score.leaves)
            for score in scores
        ),
    )


def _against_alone(first: SlidingFit, fit: SlidingFit, rows: Rows, bench: Bench) -> str | None:
    """Return why output error, the only candidate, is rejected, or None.

    There is no other candidate if each half of the logs is too short for a regression. `fit`, by
    output error, is therefore compared with the regression `first` to all logs. Output error is
    rejected in two cases: the fits have the same load terms and contradict each other; or the force
    error of output error is much larger.
    """
    apart = contradicted(first, fit) if terms_of(fit.laws) == terms_of(first.laws) else None
    if apart is not None:
        return f"its {apart} contradicts that of {first.method}"
    every = [one for side in rows for one in side]
    errors = [force_error(every, start_values(one, bench), one.laws) for one in (first, fit)]
    least, error = (1.0 if one is None else one for one in errors)
    if error <= MOST_FORCE * least:
        return None
    return (
        f"its force error of {100.0 * error:.3g} % is above {MOST_FORCE:g} times that of "
        f"{first.method}"
    )


def _winner(
    allowed: Sequence[PredictionScore], scores: Sequence[PredictionScore], declared: bool
) -> tuple[PredictionScore, SlidingFit, str]:
    """Return the chosen candidate, its fit, and the reason why the first choice was rejected.

    The reason is empty if the first choice was not rejected. Output error is rejected if its
    interval for a parameter does not contain the estimate of an allowed regression with the same
    load terms. Both models then lack an effect, such as a breakaway at the reversals, and output
    error compensates the missing effect by wrong parameters. A candidate is also rejected if its
    fit fails, or if a load that the bench does not declare is within SURE half widths of 0 in the
    regression.
    """
    best = min(score.position for score in allowed)
    winner = next(score for score in allowed if REFINED * score.position <= best)
    others = [score for score in allowed if score is not winner]
    rest = others or [score for score in scores[:1] if score is not winner]
    try:
        fit = winner.fit()
    except UnusableLogs as error:
        if not rest:
            raise
        second, other, _ = _winner(rest, scores, declared)
        return second, other, f"; {winner.name} is not used: {error}"
    twin = next(
        (score for score in scores if score is not winner and score.terms == winner.terms), None
    )
    simulated = fit.method == OUTPUT_ERROR and twin is not None
    regression = twin.fit() if simulated and twin is not None else fit
    apart = contradicted(regression, fit) if simulated and twin in others else None
    doubtful = None if declared else _doubtful_load(regression, fit)
    if apart is not None and twin is not None and rest:
        against = f"its {apart} contradicts that of {twin.name}; both models lack an effect"
    elif doubtful is not None and rest:
        against = f"its {doubtful} may be 0"
    else:
        return winner, _spanning(fit, regression) if simulated else fit, ""
    second, other, _ = _winner(rest, scores, declared)
    return second, other, f"; {winner.name} is not chosen: {against}"


def _doubtful_load(regression: SlidingFit, chosen: SlidingFit) -> str | None:
    claimed = load_intervals(chosen.laws)
    found = load_intervals(regression.laws)
    for names in (TERMS[term] for term in TERMS if term != DIRECTION):
        ends = [found[name] for name in names if name in found]
        if names[0] in claimed and all(
            SURE * (high - low) >= abs(low + high) for low, high in ends
        ):
            return names[0]
    return None


def _spanning(simulated: SlidingFit, regression: SlidingFit) -> SlidingFit:
    """Return the fit by output error, with intervals that also contain the regression's intervals.

    Both fits have the same load terms and logs. An effect that the model lacks has a different
    influence on each method, so that the difference between the fits is a part of the uncertainty.
    """
    extended = {
        name: replace(
            interval,
            low=min(interval.low, regression.parameters[name].low),
            high=max(interval.high, regression.parameters[name].high),
        )
        for name, interval in simulated.parameters.items()
        if name in regression.parameters
    }
    return replace(simulated, parameters=simulated.parameters | extended)


def contradicted(regression: SlidingFit, simulated: SlidingFit) -> str | None:
    """Return name and interval of the first parameter on which two fits disagree, as text, or None.

    Two fits disagree if the value in `regression` lies outside the interval in `simulated`.
    """
    for name in SLIDING:
        regressed, interval = regression.parameters.get(name), simulated.parameters.get(name)
        if (
            regressed is not None
            and interval is not None
            and not interval.low <= regressed.value <= interval.high
        ):
            return f"{name} [{interval.low:.4g}, {interval.high:.4g}]"
    return None


def _why(
    data: ComparedData, winner: PredictionScore, scores: Sequence[PredictionScore], unseen: bool
) -> str:
    how = (
        "strokes left out of the fit"
        if unseen
        else "the strokes of the fit, because the logs are too short to be divided"
    )
    unit = si_unit("position", data.bench.axis)
    tried = "; ".join(score.shown(unit) for score in scores)
    smallest = min(scores, key=lambda score: score.force)
    best = min(scores, key=lambda score: score.position)
    lost = (
        f" ({best.name} is not allowed: its force error is above {MOST_FORCE:g} times that of "
        f"{smallest.name})"
    )
    barred = lost if best.force > MOST_FORCE * smallest.force else ""
    tried = f"compared on {how} (position error rms, force error): {tried}"
    if winner is scores[0]:
        return f"{data.fits[0].why}; {tried}; no other allowed method is better by 10 %{barred}"
    return f"{tried}; {winner.name} is the first method within 10 % of the best allowed one{barred}"


def regression_scores(
    sides: Sides, rows: Rows, data: ComparedData, terms: tuple[str, ...] = ()
) -> list[PredictionScore]:
    """Return the scores of the regressions `data.fits`, fitted with the load terms `terms`.

    - sides: records of each half of the data
    - rows: slipping samples of each half

    A method has no score if one half of the data cannot be fitted or does not determine a parameter
    that all logs determine, or if the friction fitted to a half is negative.
    """
    scores = []
    declared = bench_with_terms(data.bench, terms) if terms else data.bench
    for fit in data.fits:
        method = fit.method or ""
        try:
            halved = [run(method, side, declared, data.settings) for side in sides]
            if any(fit.parameters.keys() - half.parameters.keys() for half in halved):
                continue  # the value of the bench would predict instead of a fitted value
            values = [start_values(half, data.bench) for half in halved]
            if any(one.get(name, 0.0) < 0.0 for one in values for name in POSITIVE):
                continue
            position = [
                stroke_squares(_axis(side, data.bench, half), one)
                for side, half, one in zip(sides[::-1], halved, values, strict=True)
            ]
        except UnusableLogs:
            continue
        force = _force(rows, values, [half.laws for half in halved])
        make = (
            (lambda fit=fit: fit)
            if not terms
            else (lambda method=method: replace(run(method, *data.all(declared)), method=method))
        )
        scores.append(
            PredictionScore(
                _name(method, terms), terms, np.concatenate(position), force, make, data.extent
            )
        )
    return scores


def _simulations(sides: Sides, rows: Rows, data: ComparedData) -> list[PredictionScore]:
    known = start_values(data.fits[0], data.bench)
    try:
        structure = choose_structure(sides, data.bench, known, data.settings.confidence)
    except UnusableLogs:
        return []
    regressions = (
        regression_scores(sides, rows, data, structure.terms)
        if structure.terms not in ((), (DIRECTION,))
        else []
    )
    force = _force(
        rows, structure.values, [_laws(values, data.bench) for values in structure.values]
    )

    def make() -> SlidingFit:
        return replace(
            simulated_fit(*data.all(data.bench), structure.terms, structure.errors),
            method=OUTPUT_ERROR,
        )

    return [
        *regressions,
        PredictionScore(
            _name(OUTPUT_ERROR, structure.terms),
            structure.terms,
            structure.squares,
            force,
            make,
            data.extent,
        ),
    ]


def _name(method: str, terms: tuple[str, ...]) -> str:
    return (
        method
        if not terms
        else f"{method} with {' and '.join(NAMES.get(term, term) for term in terms)}"
    )


def _axis(side: Sequence[MotionRecord], bench: Bench, fit: SlidingFit) -> SegmentSimulation:
    return SegmentSimulation(comparison_segments(side), bench, terms_of(fit.laws))


def _force(rows: Rows, values: Sequence[Mapping[str, float]], laws: Sequence[Laws | None]) -> float:
    """Return the rms force error over both halves of the data, each predicted by the other half."""
    errors = [
        force_error(side, one, law) for side, one, law in zip(rows[::-1], values, laws, strict=True)
    ]
    return float(np.sqrt(np.mean([error**2 for error in errors if error is not None] or [0.0])))


def _laws(values: Mapping[str, float], bench: Bench) -> Laws | None:
    return laws_of({name: Interval(value, value, value) for name, value in values.items()}, bench)
