"""Widening of intervals by effects that the model does not include.

An effect that the model lacks leaves the same residual in every stroke. The scatter between strokes
therefore does not show the resulting error. Eleven possible causes are examined
(docs/theory/identify_effects.md). Cause 1 adds a variance; causes 2 to 11 shift the parameters:

1. a residual that repeats at the same positions, or at the same velocities and signs of the
   acceleration (`regression/multiway.py`), and encoder noise that strokes of equal speed repeat
2. a hypothesis of `explanation_search`, such as a spring, that improves the fit
3. smoothing windows that are too long
4. a delay or a resonance that the fit approximates to first order
5. an unknown delay between effort and position that the model does not include
6. the local gain of an eccentric encoder
7. encoder noise that hides the inertia (last paragraph) or decreases it (`_of_attenuation`)
8. higher orders of friction over position than the model includes (`further_orders.py`)
9. a spring, or viscous friction that differs by direction (`hidden_effects.py`)
10. a resonance that lies above the frequencies of the motion and increases the reflected inertia
11. friction that falls with speed (`falling_friction.py`)

If two explanations predict the strokes equally well, the intervals include the intervals of the
fits with either explanation.

The end of an interval on the side of the shift moves by the shift. The opposite end moves to the
distance sqrt(half^2 + shift^2) from the value, where half is the half width, because effects that
the log cannot distinguish can shift a parameter in opposite directions. If several effects move an
end, only the largest movement is applied. If an interval overlaps the interval in bench.yaml, no
end moves beyond the interval in bench.yaml.

The effort of a hypothesis (cause 2) is limited to a plausible size. A warning names the parameters
that a hypothesis with the fitted effort would move out of their intervals.

Noise in the acceleration makes the inertia of a regression too small. If this decrease exceeds the
half width of the inertia's interval, the inertia is regarded as hidden by noise. The inertia is
then fixed at the value in the fit or, if the fit has no inertia, in the bench. An inertia from the
weak form or from means over strokes is fixed in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.assess.identifiability import STROKE_MEANS
from frictool.identify.effect_regression import (
    AcceptedEffects,
    EffectRegression,
    added_scatter,
    effect_regression,
    inertia_of_other_method,
    unlikely_change,
)
from frictool.identify.estimators.explanation_search import NOTICEABLE
from frictool.identify.estimators.load_hypotheses import declared_term
from frictool.identify.estimators.searched_records import ECCENTRICITY
from frictool.identify.falling_friction import explained, falling_friction, slow_friction
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.fitted_lag import exchanged_inertia, late_fit
from frictool.identify.fixed_parameter_refit import refit
from frictool.identify.further_orders import further_orders
from frictool.identify.hidden_effects import hidden_effects
from frictool.identify.interval_checks import contradicts
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import (
    READ_APART,
    MotionRecord,
    delayed,
    fitted_sensor_lag,
    late_reading,
    sensed,
)
from frictool.identify.outcome import sliding_intervals
from frictool.identify.rows.effects import DELAY, RISING, WHAT
from frictool.identify.sensor_lag_doubt import sensor_lag_doubts
from frictool.identify.winding_delay import (
    current_between_samples,
    lag_doubts,
    undeclared_winding,
    winding_delay,
)
from frictool.plant.weak_form import effort_weights

SMOOTHER = 2.0  # factor on the length of the smoothing windows of the second fit
# largest relative error of a rotary encoder's local gain: an error of 5 mrad (0.3 degrees) with one
# cycle per turn, usual for a magnetic encoder at the end of a shaft
LOCAL_GAIN = 5e-3
CERTAIN = 1e-4  # largest p-value of an effect that is reported
SERIES = (DELAY, "resonance")  # effects that the fit approximates to first order
NOTABLE_SPRING = 1.5  # least factor by which a reported spring widens the interval of the inertia
SPRING_NOTE = (
    "the interval of the inertia is {:.2g} times as wide, since this motion cannot exclude a "
    "spring; test at other frequencies, or declare load.terms: [offset] if no load acts on the axis"
)
# key of SlidingFit.details: friction [N m | N] at low speed, if friction is concave over speed
SLOW_FRICTION = "slow_friction"
NOTABLE = 3.0  # least factor by which a reported effect widens an interval


@dataclass(frozen=True)
class WidenedFit:
    """Fit whose intervals include unmodelled effects.

    - effect: effects with the smallest p-value; None if no p-value is small enough for a report, or
      if the effects hardly improve the prediction
    - ratios: for each parameter whose interval becomes much wider, the width after the widening
      divided by the width before
    - beyond: pair of the name of an effect and the parameters that the effect, with its fitted
      effort, moves out of their intervals; None if there is no such effect
    - cautions: pairs of a parameter's name and a warning about this parameter
    - spring: factor by which a possible spring (`hidden_effects.py`) widens the interval of the
      inertia
    - advice: note on how to identify parameters that were refused because of `effect`, or None
    """

    fit: SlidingFit
    effect: AcceptedEffects | None = None
    ratios: Mapping[str, float] = field(default_factory=dict)
    beyond: tuple[str, Sequence[str]] | None = None
    cautions: Sequence[tuple[str, str]] = ()
    spring: float = 1.0
    advice: str | None = None

    def refusals(self, refused: Mapping[str, str]) -> dict[str, str]:
        """Return the reasons of the parameters `refused`, with the cause of a wide interval."""
        if self.effect is None:
            return dict(refused)
        cause = f"perhaps {self.effect.what[-1]} makes the interval {{:.2g}} times as wide"
        return {
            name: f"{reason}; {cause.format(self.ratios[name])}" if name in self.ratios else reason
            for name, reason in refused.items()
        }

    def with_advice(self, refused: Mapping[str, str]) -> WidenedFit:
        """Return this fit with a note on how to identify the parameters `refused`."""
        names = ", ".join(name for name in refused if name in self.ratios)
        if self.effect is None or not self.effect.settle or not names:
            return self
        return replace(self, advice=f"to identify {names}: {self.effect.settle}")

    def warnings(self, identified: Mapping[str, Interval]) -> tuple[str, ...]:
        """Return the warnings about parameters in `identified`, except those of `doubts`."""
        return tuple(text for name, text in self.cautions if name in identified)

    def doubts(self, identified: Mapping[str, Interval]) -> dict[str, tuple[str]]:
        """Return a warning for each parameter that the effect `beyond` moves out of its interval.

        An effect that the intervals include causes no warning; `notes` reports it.
        """
        what, names = self.beyond or ("", ())
        moved = [name for name in names if self._widened(name, identified)]
        text = (
            f"the model lacks an effect, perhaps {what}; the intervals of {', '.join(moved)} may "
            "be too narrow; test at other frequencies and amplitudes"
        )
        return dict.fromkeys(moved, (text,))

    def notes(self, identified: Mapping[str, Interval]) -> tuple[str, ...]:
        """Return `advice`, and texts about `effect` and a spring that make an interval wider."""
        wider = [
            f"{name} {ratio:.2g}"
            for name, ratio in self.ratios.items()
            if self._widened(name, identified)
        ]
        spring = None if self.spring <= NOTABLE_SPRING else SPRING_NOTE.format(self.spring)
        others = tuple(one for one in (spring, self.advice) if one is not None)
        if self.effect is None or not wider:
            return others
        settle = self.effect.settle and f". To decide, {self.effect.settle}"
        return (
            "included in the intervals: an effect that the model lacks, perhaps "
            f"{self.effect.what[-1]} ({', '.join(wider)} times as wide){settle}",
            *others,
        )

    def _widened(self, name: str, identified: Mapping[str, Interval]) -> bool:
        """Return whether the interval in `identified` comes from the fit, and not from ramps."""
        return name in identified and identified[name].high == self.fit.parameters[name].high


def widened(
    fit: SlidingFit, records: Sequence[MotionRecord], bench: Bench, confidence: float
) -> WidenedFit:
    """Widen the intervals of the sliding parameters in a fit for unmodelled effects."""
    regression = effect_regression(fit, records, bench, confidence)
    if regression is None:
        return WidenedFit(fit)
    plain = fit
    fit = replace(fit, parameters=fit.parameters | regression.spread(fit.parameters))
    parameters = dict(fit.parameters)
    accepted = regression.accepted()
    smoother = effect_regression(fit, records, bench, confidence, SMOOTHER)
    moved = _of_windows(fit, records, bench, confidence, regression, smoother)
    if regression.noisy and "inertia" not in regression.names and not inertia_of_other_method(fit):
        moved += _of_noise(fit, records, bench, confidence)
    moved += _of_attenuation(fit)
    moved += _of_delay(fit, records, bench, regression, regression)
    moved += _of_rivals(fit, records, bench, regression)
    moved += falling_friction(regression)
    moved += _of_timing(fit, records, bench, confidence, (regression, smoother))
    moved += _of_resonance(fit, records, bench, confidence, smoother)
    moved += _of_fitted_lag(records, bench, regression)
    gain = regression.encoder_gain(LOCAL_GAIN)
    further = further_orders(regression)
    moved += [one for one in (gain, further) if one is not None]
    viscous = sliding_intervals({**fit.parameters, **fit.fixed}, bench)["viscous"].value
    inertial: EffectRegression | None = regression
    stated = bench.actuator.winding_delays and any(one.lag > 0.0 for one in records)
    if regression.noisy and (DELAY in fit.effects or stated):
        inertial = effect_regression(fit, records, bench, confidence, hides=False)
    moved += _of_sampling(records, inertial, viscous)
    winding = winding_delay(inertial, viscous, records, bench)
    moved += winding.effects if winding is not None else []
    between = current_between_samples(inertial, records, bench)
    moved += between
    parameters = _with_shifts(parameters, fit, bench, (*accepted, *moved))
    wide = _with_shifts(parameters, fit, bench, hidden_effects(regression, bench))
    cautions = list[tuple[str, str]]()
    if winding is not None and "inertia" in wide:
        wide["inertia"] = winding.corrected(wide["inertia"])
        cautions.append(("inertia", winding.warning(wide["inertia"], bench)))
    unknown = None if between else undeclared_winding(inertial, records, bench)
    if unknown is not None and "inertia" in wide:
        cautions.append(("inertia", unknown))
    cautions += lag_doubts(records, bench, regression, wide)
    cautions += sensor_lag_doubts(records, bench, inertial or regression, wide)
    certain = [one for one in accepted if one.held_out < NOTICEABLE and one.significance <= CERTAIN]
    certain.sort(key=lambda one: one.significance)
    ratios = {
        name: one.half_width / plain.parameters[name].half_width
        for name, one in parameters.items()
        if one.half_width > NOTABLE * plain.parameters[name].half_width > 0.0
    }
    explanations = tuple(explained(regression, one) for one in fit.explanations)
    shown = [one.what for one in explanations] + [one.what[-1] for one in certain[:1]]
    slow = slow_friction(regression) if RISING in shown else None
    details = fit.details if slow is None else {**fit.details, SLOW_FRICTION: slow}
    return WidenedFit(
        replace(fit, parameters=wide, explanations=explanations, details=details),
        certain[0] if certain else None,
        ratios,
        _beyond(wide, bench, certain),
        cautions,
        _growth(parameters.get("inertia"), wide.get("inertia")),
    )


def _growth(before: Interval | None, after: Interval | None) -> float:
    """Return the ratio of the half widths of two intervals; 1 if an interval is missing."""
    if before is None or after is None or before.half_width == 0.0:
        return 1.0
    return after.half_width / before.half_width


def _beyond(
    intervals: Mapping[str, Interval], bench: Bench, effects: Sequence[AcceptedEffects]
) -> tuple[str, Sequence[str]] | None:
    """Return the first effect whose fitted effort moves parameters out of their intervals.

    The result is the name of the effect, and the names of these parameters. A parameter moves at
    most to an end of the interval in bench.yaml.
    """
    for effect in effects:
        names = []
        for name, shift in effect.whole.items():
            one = intervals[name]
            value = Interval.around(one.value, 0.0)
            moved = _with_shift(value, shift, 0.0, True, getattr(bench.mechanics, name))
            if _hull(one, moved) != one:
                names.append(name)
        if names:
            return effect.what[-1], names
    return None


def _with_shifts(
    parameters: Mapping[str, Interval],
    fit: SlidingFit,
    bench: Bench,
    effects: Sequence[AcceptedEffects],
) -> dict[str, Interval]:
    """Widen the intervals of `parameters` to contain the shifted intervals of `fit`.

    Each of the `effects` shifts the intervals of `fit` separately; the shifts are not added.
    """
    out = dict(parameters)
    for one in effects:
        for name, shift in one.shift.items():
            if name in out:
                known = getattr(bench.mechanics, name)
                scatter = one.scatter.get(name, 0.0)
                end = _with_shift(fit.parameters[name], shift, scatter, one.one_sided, known)
                out[name] = _hull(out[name], end)
    return out


def _of_windows(
    fit: SlidingFit,
    records: Sequence[MotionRecord],
    bench: Bench,
    confidence: float,
    plain: EffectRegression,
    smoother: EffectRegression | None,
) -> list[AcceptedEffects]:
    """Return the shifts of the parameters by longer windows, reduced by the part due to chance.

    `plain` is the regression over the windows of the fit, and `smoother` the regression over
    windows of twice the length. If the fit approximates a delay or a resonance to first order, the
    parameters of the fit are also compared with `plain` and with the regression over the longest
    windows.
    """
    before = plain.intervals()
    out = []
    if smoother is not None:
        out.append(_beyond_chance(before, smoother))
    if any(name in fit.effects for name in SERIES):
        longest = effect_regression(fit, records, bench, confidence, math.inf)
        before |= fit.parameters
        out += [_beyond_chance(before, one) for one in (plain, longest) if one is not None]
    return out


def _of_resonance(
    fit: SlidingFit,
    records: Sequence[MotionRecord],
    bench: Bench,
    confidence: float,
    smoother: EffectRegression | None,
) -> list[AcceptedEffects]:
    """Return the change of the inertia due to a resonance that longer smoothing windows show.

    `smoother` is the regression over windows of twice the length. If this regression shows a
    resonance, the inertia comes from windows of four times the length, because noise of the encoder
    disturbs longer windows less.
    """
    fitted = fit.parameters.get("inertia")
    seen = None if smoother is None else smoother.resonant_inertia()
    if fitted is None or seen is None:
        return []
    smoothest = effect_regression(fit, records, bench, confidence, SMOOTHER**2)
    seen = (None if smoothest is None else smoothest.resonant_inertia()) or seen
    shift = {"inertia": seen.value - fitted.value}
    return [AcceptedEffects(("a resonance",), 1.0, shift, scatter={"inertia": seen.half_width})]


def _of_noise(
    fit: SlidingFit, records: Sequence[MotionRecord], bench: Bench, confidence: float
) -> list[AcceptedEffects]:
    """Return the change of the inertia by windows twice as long, minus the part due to chance."""
    fitted = fit.parameters.get("inertia")
    smoother = effect_regression(fit, records, bench, confidence, SMOOTHER, hides=False)
    after = None if smoother is None else smoother.intervals().get("inertia")
    if fitted is None or after is None:
        return []
    return [AcceptedEffects((), 1.0, {"inertia": unlikely_change(fitted, after)})]


def _of_attenuation(fit: SlidingFit) -> list[AcceptedEffects]:
    """Return the shift of the inertia that removes the effect of noise of the acceleration.

    White noise decreases the fitted inertia by the fraction q = `fit.attenuation`, which is the
    variance of the noise divided by the variance of the acceleration. A controller that follows the
    noise, and the rounding errors of repeated motion, correlate noise and acceleration. The
    magnitude of their covariance is assumed to be at most the variance of the noise: a position
    loop follows the noise with a gain of at most about 1. The decrease is then 0 to 2 q.
    """
    inertia = fit.parameters.get("inertia")
    if inertia is None or fit.attenuation == 0.0:
        return []
    shift = {"inertia": fit.attenuation * abs(inertia.value)}
    return [AcceptedEffects((), 1.0, shift, scatter=shift, one_sided=True)]


def _beyond_chance(before: Mapping[str, Interval], smoother: EffectRegression) -> AcceptedEffects:
    after = smoother.intervals()
    shift = {
        name: unlikely_change(before[name], after[name])
        for name in smoother.names
        if name in before and name in after
    }
    return AcceptedEffects((), 1.0, shift)


def _of_rivals(
    fit: SlidingFit,
    records: Sequence[MotionRecord],
    bench: Bench,
    regression: EffectRegression,
) -> list[AcceptedEffects]:
    """Return the shifts of the parameters to fits with equally good explanations of the effort.

    Equally good explanations predict the strokes equally well. If the model includes one of them,
    the others replace it in turn. If all are left in the residual, each is added to the model in
    turn. Ripples and an eccentric encoder are not tried.
    """
    out = []
    for one in fit.explanations:
        # a fit in which this effect is already named after its effort (`EffectRegression.named`)
        names = [WHAT["stribeck"] if what == RISING else what for what in (one.what, *one.rivals)]
        used = [other for other in regression.used if declared_term(other) == one.name]
        if not one.rivals or (one.state == "used" and len(used) != 1):
            continue  # several ripples have the same name
        others = [h for h in regression.used if one.state == "left" or h is not used[0]]
        for rival in regression.free:
            if rival.what in names and rival.term != ECCENTRICITY:
                model = replace(regression, used=(*others, rival))
                out += regression.alternative(model.used)
                if rival.term == DELAY:
                    out += _of_delay(fit, records, bench, regression, model)
    return out


def _of_delay(
    fit: SlidingFit,
    records: Sequence[MotionRecord],
    bench: Bench,
    plain: EffectRegression,
    model: EffectRegression,
) -> list[AcceptedEffects]:
    """Return the shifts of the parameters if an exact delay or lag replaces a first-order delay.

    `plain` is the regression of the fit. `model` is the regression with a delay to first order. The
    result is empty if `model` has no delay. A lag is tried only if the effort acts later than it is
    logged, since the inverse of a lag would amplify noise.
    """
    late = model.intervals().get(DELAY)
    if late is None:
        return []
    before = plain.intervals()
    out = []
    for move in (delayed, sensed) if late.value < 0.0 else (delayed,):
        exact = late_fit(fit, records, bench, model, move)
        after = {} if exact is None else exact.regression.intervals()
        shift = {n: after[n].value - before[n].value for n in plain.names if n in after}
        out.append(AcceptedEffects((), 1.0, shift, scatter=added_scatter(before, after)))
    return out


def _of_timing(
    fit: SlidingFit,
    records: Sequence[MotionRecord],
    bench: Bench,
    confidence: float,
    regressions: tuple[EffectRegression, EffectRegression | None],
) -> list[AcceptedEffects]:
    """Return the shifts of the parameters by an unknown delay that the model does not include.

    `regressions` contains the regression over the windows of the fit, and over windows of twice the
    length. If noise hides the inertia, both regressions are repeated with the inertia as a
    parameter, since a delay changes the inertia.
    """
    plain, smoother = regressions
    if plain.noisy:
        free = effect_regression(fit, records, bench, confidence, hides=False)
        plain = free or plain
        smoother = effect_regression(fit, records, bench, confidence, SMOOTHER, hides=False)
    period = max(record.period for record in records)
    apart = READ_APART * period
    slopes = _rates(fit, records, bench, confidence, apart)
    timing = plain.timing(apart, smoother or plain, slopes)
    reading = _of_reading(bench, period, plain, slopes)
    return [one for one in (timing, reading) if one is not None]


def _of_reading(
    bench: Bench, period: float, plain: EffectRegression, slopes: Mapping[str, float]
) -> AcceptedEffects | None:
    """Return the uncertainty of the parameters due to the unknown time of reading a current.

    `period` is in s; `slopes` are as in `EffectRegression.timing`. The result is None for a drive
    without a lag, for a voltage, which is logged before the lag, and if the model contains a delay.
    The current may be read before or after its update. The record contains the mean of both cases,
    weighted by their probabilities (`motion_record.py`). The shift is therefore 0, and its half
    width follows from the probabilities of the two cases.
    """
    lag = bench.actuator.logged_lag_s
    late = next((one for one in plain.free if one.term == DELAY), None)
    if lag == 0.0 or late is None:
        return None
    before, _, after = effort_weights(period, lag)
    held = effort_weights(period, 0.0)
    apart = period * (after - before - (held[2] - held[0]))
    share = late_reading(period, lag)
    quantile = float(scipy.special.ndtri(0.5 + 0.5 * plain.confidence))
    half = quantile * math.sqrt(share * (1.0 - share)) * apart
    rates = plain.rates(late)
    rates |= {name: one for name, one in slopes.items() if name in rates}
    return AcceptedEffects(
        (late.what,),
        1.0,
        dict.fromkeys(rates, 0.0),
        scatter={name: half * abs(one) for name, one in rates.items()},
    )


def _of_fitted_lag(
    records: Sequence[MotionRecord], bench: Bench, regression: EffectRegression
) -> list[AcceptedEffects]:
    """Return the possible shifts of the parameters because a fitted lag is uncertain.

    A second shift is added: the change of the inertia if the lag and the time constant
    inertia/viscous are exchanged. The result is empty if no lag was fitted, or if the model
    contains a delay.
    """
    late = next((one for one in regression.free if one.term == DELAY), None)
    if late is None or all(fitted_sensor_lag(one, bench) == 0.0 for one in records):
        return []
    rest = regression.intervals([late]).get(DELAY)
    if rest is None:
        return []
    rates = regression.rates(late)
    shift = {name: rest.value * one for name, one in rates.items()}
    scatter = {name: rest.half_width * abs(one) for name, one in rates.items()}
    out = [AcceptedEffects((late.what,), 1.0, shift, scatter=scatter)]
    found = regression.intervals()
    lag = max(one.sensor_lag for one in records)
    other = exchanged_inertia(found, lag, bench)
    if other is not None and "inertia" in found:
        change = {"inertia": other - found["inertia"].value}
        out.append(AcceptedEffects((late.what,), 1.0, change, one_sided=True))
    return out


def _of_sampling(
    records: Sequence[MotionRecord], plain: EffectRegression | None, viscous: float
) -> list[AcceptedEffects]:
    """Return the shift of the inertia by the sample period T if the model contains a delay.

    The velocity is a mean over 2 T, but the effort is a mean with a triangular window of the length
    2 T. To second order in T, this difference acts like the delay -viscous T^2/(12 inertia). This
    delay increases the fitted inertia by (viscous T)^2/(12 inertia); the shift is this value with a
    negative sign.
    """
    if plain is None or all(one.term != DELAY for one in plain.used):
        return []
    inertia = plain.intervals().get("inertia")
    if inertia is None or inertia.value <= 0.0:
        return []
    shift = -((viscous * max(one.period for one in records)) ** 2) / (12.0 * inertia.value)
    return [AcceptedEffects((), 1.0, {"inertia": shift}, one_sided=True)]


def _rates(
    fit: SlidingFit,
    records: Sequence[MotionRecord],
    bench: Bench,
    confidence: float,
    apart: float,
) -> dict[str, float]:
    """Return the change of each parameter per second of delay, for the method of stroke means.

    The fit is repeated with the effort delayed by `apart` [s], because stroke means do not weight
    the samples as the regression does. The result is empty for other methods.
    """
    if fit.method != STROKE_MEANS:
        return {}
    settings = IdentificationSettings(confidence)
    early = [delayed(one, apart) for one in records]
    try:
        before, after = (
            refit(list(part), bench, settings, fit, fit.fixed) for part in (records, early)
        )
    except UnusableLogs:
        return {}
    return {
        name: (before.parameters[name].value - one.value) / apart
        for name, one in after.parameters.items()
        if name != "inertia" and name in before.parameters
    }


def _hull(one: Interval, other: Interval) -> Interval:
    return replace(one, low=min(one.low, other.low), high=max(one.high, other.high))


def _with_shift(
    interval: Interval, shift: float, scatter: float, one_sided: bool, known: Quantity | None
) -> Interval:
    """Return the interval of a parameter, widened for a shift whose half width is `scatter`.

    The end opposite to the shift moves, too, unless the shift is `one_sided`. If the interval in
    bench.yaml, `known`, overlaps `interval`, no end moves beyond `known`.
    """
    below = np.hypot(interval.value - interval.low, scatter)
    above = np.hypot(interval.high - interval.value, scatter)
    opposite = 0.0 if one_sided else shift
    low = interval.value + min(shift - below, -np.hypot(below, opposite))
    high = interval.value + max(shift + above, np.hypot(above, opposite))
    if one_sided and shift != 0.0:
        low = interval.low if shift > 0.0 else low
        high = interval.high if shift < 0.0 else high
    if not contradicts(interval, known) and known is not None and known.low is not None:
        low = max(low, known.low)
        high = min(high, known.interval[1])
    return _hull(interval, Interval(interval.value, float(low), float(high)))
