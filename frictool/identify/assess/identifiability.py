"""Choice of the method that identifies a parameter precisely enough (thesis, figure 4.4).

The target is the requested relative half width. The methods are tried in this order:

    differentiation   least squares, if the worst-case error (4.3) | (4.4) is within the target
    filtered          least squares after the slowest low-pass filter that the a-priori time
                      constant of the axis permits, if the error (4.8) | (4.9) is within the target
    otherwise         inertia: the weak form, if its standard deviation is small enough
                      viscous, Coulomb: sines on a position loop (4.38), without a velocity

(4.3) and (4.8) of the thesis apply to the inertia, (4.4) and (4.9) to viscous and Coulomb friction.

One decision differs from the thesis. If (4.8) exceeds the target for the inertia, the thesis uses
the a-priori value. Here the weak form is tried first. The weak form is least squares over smoothing
windows, in which the errors of the counts average out; (4.8) adds these errors with the worst sign.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import scipy

from frictool.identify.assess.assessment_inputs import AssessmentInputs
from frictool.identify.assess.noise_filter import LARGEST_RATIO, filter_for, noise_ratio
from frictool.identify.assess.quantisation import inertia_error, viscous_error
from frictool.identify.assess.ramp_precision import ramp_precision
from frictool.identify.assess.sines_precision import sines_half_width
from frictool.identify.assess.weak_form_precision import weak_deviation
from frictool.identify.excite.cramer_rao import SLIDING, PlannedStroke, PriorAxis, SensorPrecision

CONFIDENCE = 0.95
QUANTILE = float(scipy.special.ndtri(0.5 + 0.5 * CONFIDENCE))
SINES_COUNTS = 20.0  # least length of a stroke minus the backlash, in encoder counts
# identification methods that a verdict proposes
NO_LOADS = "the weak form cannot fit load.terms"
DIFFERENTIATION, WEAK_FORM, STROKE_MEANS = "least-squares", "weak", "sines"
SINES = "excite --kind sines"
RAMPS = "excite --kind breakaway"
LOOPS = "slow effort up and down below the breakaway"


@dataclass(frozen=True)
class Identifiability:
    """Verdict: can a bench identify one parameter? Precisions are relative to the a-priori value.

    - identifiable: True if the expected precision meets the target
    - precision: half width of the expected 95 % interval; None if it cannot be computed
    - bound: largest error that the encoder's quantisation can cause; None if quantisation causes no
      error
    - why: reason for the verdict, as text
    - method, test: proposed method and test, or None
    - filter: time constant of the proposed low-pass filter, s; None if no filter is proposed
    """

    identifiable: bool
    precision: float | None
    bound: float | None
    why: str
    method: str | None = None
    test: str | None = None
    filter: float | None = None


def verdict(parameter: str, facts: AssessmentInputs, wanted: float) -> Identifiability:
    """Return whether a parameter is identifiable to the relative half width `wanted`, and how.

    `parameter` is inertia, viscous, coulomb, breakaway or presliding.
    """
    if facts.value(parameter) <= 0.0:
        return Identifiability(False, None, None, "the bench states the value 0")
    return _JUDGES[parameter](facts, wanted)


def differentiation(
    parameter: str, facts: AssessmentInputs, wanted: float
) -> Identifiability | None:
    """Return the verdict for least squares on differences of samples, with a filter if needed.

    Return None if the worst-case error or the expected precision exceeds the target, even with the
    slowest filter that the a-priori time constant of the axis permits.
    """
    raw = raw_bound(parameter, facts)
    precision = statistical(facts)[parameter]
    if max(raw, precision) <= wanted:
        return Identifiability(True, precision, raw, worst_case(raw), DIFFERENTIATION, SINES)
    if not facts.dynamics_known:
        return None
    slowest = noise_ratio(facts.fastest, facts.sensing.period)
    if max(raw * math.sqrt(slowest), precision) > wanted:
        return None
    tau = filter_for(min(max((wanted / raw) ** 2, slowest), LARGEST_RATIO), facts.sensing.period)
    bound = raw * math.sqrt(noise_ratio(tau, facts.sensing.period))
    why = f"{worst_case(raw)}, {up_to(bound)} after a low-pass with time constant {tau:.3g} s"
    return Identifiability(True, precision, bound, why, DIFFERENTIATION, SINES, tau)


def refusal_of_differentiation(parameter: str, facts: AssessmentInputs) -> str:
    """Return why least squares on differences of samples are too imprecise, as text."""
    raw = raw_bound(parameter, facts)
    precision = statistical(facts)[parameter]
    if facts.dynamics_known:
        best = raw * math.sqrt(noise_ratio(facts.fastest, facts.sensing.period))
        behind = f"with the slowest low-pass (time constant {facts.fastest:.3g} s): {up_to(best)}"
    else:
        known = time_constants_text(facts)
        behind = f"inertia/viscous ({known}) is too uncertain to choose a low-pass filter"
    averaged = (
        f"; least squares over windows of {best_window(facts)} samples: {percent(precision)} "
        "expected"
        if math.isfinite(precision)
        else ""
    )
    return f"{worst_case(raw)}; {behind}{averaged}"


def time_constants_text(facts: AssessmentInputs) -> str:
    """Return the a-priori range of inertia/viscous as text, in seconds."""
    if math.isfinite(facts.slowest):
        return f"{facts.fastest:.3g} to {facts.slowest:.3g} s"
    return f"{facts.fastest:.3g} s or more"


def worst_case(bound: float) -> str:
    """Return a text on the worst-case relative error `bound` of differences of samples."""
    return f"encoder counts change an estimate from differences of samples by {up_to(bound)}"


def up_to(bound: float) -> str:
    """Return "up to ... %" for a relative bound."""
    return f"up to {100.0 * bound:.3g} %"


def raw_bound(parameter: str, facts: AssessmentInputs) -> float:
    """Return the worst-case relative error of differences of samples, thesis (4.3) or (4.4)."""
    if parameter == "inertia":
        return inertia_error(
            facts.axis.inertia, facts.sensing.step, facts.sensing.period, facts.effort
        )
    return viscous_error(facts.sensing.step, facts.sensing.period, facts.speed)


def statistical(facts: AssessmentInputs) -> dict[str, float]:
    """Return the relative 95 % half width that the weak form is expected to give each parameter."""
    return _statistical(facts.strokes, facts.axis, facts.sensing)[0]


def best_window(facts: AssessmentInputs) -> int:
    """Return the length [samples] of the window with the smallest error of the inertia."""
    return _statistical(facts.strokes, facts.axis, facts.sensing)[1]


@lru_cache(maxsize=256)
def _statistical(
    strokes: tuple[PlannedStroke, ...], axis: PriorAxis, sensing: SensorPrecision
) -> tuple[dict[str, float], int]:
    deviation, window = weak_deviation(list(strokes), axis, sensing)
    values = (axis.inertia, axis.viscous, axis.coulomb)
    precision = {
        name: QUANTILE * float(d) / v if v > 0.0 else math.inf
        for name, d, v in zip(SLIDING, deviation, values, strict=False)
    }
    return precision, window


def _inertia(facts: AssessmentInputs, wanted: float) -> Identifiability:
    accuracy = differentiation("inertia", facts, wanted)
    if accuracy is not None:
        return accuracy
    precision = statistical(facts)["inertia"]
    refusal = refusal_of_differentiation("inertia", facts)
    bound = raw_bound("inertia", facts)
    if not facts.axis.loads.plain:
        why = f"{refusal}; {NO_LOADS}"
        return Identifiability(False, precision, bound, why)
    if precision <= wanted:
        why = f"{refusal} (weak form)"
        return Identifiability(True, precision, bound, why, WEAK_FORM, SINES)
    unseen = (
        "" if math.isfinite(precision) else "; no stroke is longer than a window of the weak form"
    )
    return Identifiability(False, precision, bound, f"{refusal}{unseen}")


def _friction(parameter: str, facts: AssessmentInputs, wanted: float) -> Identifiability:
    accuracy = differentiation("viscous", facts, wanted)
    precision = statistical(facts)[parameter]
    if accuracy is not None and precision <= wanted:
        # quantisation does not bias Coulomb friction: the mean error of sign(v) is 0 (4.2.1.1)
        bound = accuracy.bound if parameter == "viscous" else None
        return replace(accuracy, precision=precision, bound=bound)
    bound = raw_bound("viscous", facts) if parameter == "viscous" else None
    refusal = (
        refusal_of_differentiation(parameter, facts)
        if accuracy is None
        else f"least squares is expected to reach {percent(precision)}"
    )
    if not facts.axis.loads.plain:
        fine = precision <= wanted
        why = (
            f"{refusal}; least squares over windows, because the method of sines cannot fit "
            "load.terms"
        )
        method = DIFFERENTIATION if fine else None
        return Identifiability(fine, precision, bound, why, method, SINES)
    distance = facts.strokes[0].distance
    need = facts.axis.backlash + SINES_COUNTS * facts.sensing.step
    if distance < need:
        why = f"{refusal}; sines need strokes of {need:.3g}, the travel has {distance:.3g}"
        return Identifiability(False, None, bound, why)
    by_sines = float(
        sines_half_width(facts, QUANTILE)[("viscous", "coulomb").index(parameter)]
    ) / facts.value(parameter)
    why = (
        f"{refusal}; means over strokes: {percent(by_sines)} expected, if the position loop keeps "
        "the speed within 3 %"
    )
    fine = by_sines <= wanted
    return Identifiability(fine, by_sines, bound, why, STROKE_MEANS if fine else None, SINES)


def _breakaway(facts: AssessmentInputs, wanted: float) -> Identifiability:
    onset_precision = ramp_precision(
        facts.rate, facts.sensing.step, facts.sensing.period, facts.inertia, facts.onsets
    )
    late = onset_precision.latest / facts.breakaway
    precision = QUANTILE * onset_precision.deviation / facts.breakaway
    why = (
        f"in a ramp of {facts.rate:.3g} N m/s or N/s, the onset shows when the effort is "
        f"{up_to(late)} above the breakaway; the mean over {facts.onsets:g} onsets is corrected"
    )
    fine = precision <= wanted
    return Identifiability(fine, precision, late, why, "ramps" if fine else None, RAMPS)


def _presliding(facts: AssessmentInputs, wanted: float) -> Identifiability:
    counts = facts.presliding / facts.sensing.step
    fine = 1.0 / counts <= wanted
    why = f"an expected presliding distance of {facts.presliding:.3g} is {counts:.3g} counts"
    proposed = ("loops", LOOPS) if fine else (None, None)
    return Identifiability(fine, 1.0 / counts, 1.0 / counts, why, *proposed)


def percent(part: float) -> str:
    """Return a relative half width as text, in per cent."""
    return f"+-{100.0 * part:.3g} %"


_JUDGES = {
    "inertia": _inertia,
    "viscous": lambda facts, wanted: _friction("viscous", facts, wanted),
    "coulomb": lambda facts, wanted: _friction("coulomb", facts, wanted),
    "breakaway": _breakaway,
    "presliding": _presliding,
}
PARAMETERS = tuple(_JUDGES)
