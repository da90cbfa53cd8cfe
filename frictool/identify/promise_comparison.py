"""Comparison of the identified half widths with the half widths in the test's `promise.yaml`.

`promise.yaml` states for each parameter the half width to expect from a test of `frictool excite`.
An identified half width can exceed the expected one for three reasons: the log is too short; drive
or position are too noisy; or the Cramér-Rao bound of the recorded strokes is too large. If these
reasons do not explain the ratio of the half widths, the logs contain an effect that the simulations
of the test lack, such as friction that varies with position (`shown_effects`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.name_list import listed
from frictool.documents.promise import Promise
from frictool.documents.quantity import Quantity
from frictool.errors import InputFileError
from frictool.identify.assess.recorded_motion import recorded_facts
from frictool.identify.axis_logs import SLIDING_LOG
from frictool.identify.excite.cramer_rao import SLIDING, SensorPrecision, cramer_rao
from frictool.identify.excite.precise_strokes import QUANTILE
from frictool.identify.excite.stroke_candidates import worst_axis
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.from_logs import IdentifiedModel
from frictool.identify.identification import Identification
from frictool.identify.model_document import unit_of
from frictool.identify.rows.effects import WHAT

MORE = 1.2  # least ratio of the log's noise or bound to the promise's that is a reason
SHORT = 0.95  # share of the test's duration below which a log counts as shorter than the test


@dataclass(frozen=True)
class PromisedParameter:
    """Comparison of the promised and the identified half width of one parameter, in SI units.

    - promised: half width in `promise.yaml`
    - reached: half width of the identified interval; None if the parameter was refused
    - reasons: reasons for a larger half width; empty if the half width is not larger
    """

    parameter: str
    promised: float
    reached: float | None
    unit: str
    reasons: tuple[str, ...]

    @property
    def kept(self) -> bool:
        """Return True if the identified half width is at most the half width in `promise.yaml`."""
        return self.reached is not None and self.reached <= self.promised

    def line(self) -> str:
        """Return the comparison as text."""
        reached = (
            "not identified"
            if self.reached is None
            else f"identified to +-{self.reached:.3g} {self.unit}"
        )
        verdict = "kept" if self.kept else f"missed: {'; '.join(self.reasons)}"
        return (
            f"{self.parameter}: promised +-{self.promised:.3g} {self.unit}, {reached}: "
            f"promise {verdict}"
        )

    def view(self) -> dict[str, Any]:
        """Return the comparison as JSON values."""
        return {
            "parameter": self.parameter,
            "promised": self.promised,
            "reached": self.reached,
            "unit": self.unit,
            "kept": self.kept,
            "reasons": list(self.reasons),
        }


def compare_with_promise(
    outcome: IdentifiedModel, bench: Bench, promise: Promise
) -> list[PromisedParameter]:
    """Compare the identified half width of each parameter with the half width in `promise`.

    Parameters
    ----------
    outcome
        Identification of the logs of the test.
    bench
        Bench of the identification.
    promise
        Half widths to expect from the test.

    Returns
    -------
    list of PromisedParameter
        One entry per parameter.

    Raises
    ------
    InputFileError
        If the promise belongs to another bench.
    """
    if (promise.name, promise.axis) != (bench.name, bench.axis):
        raise InputFileError(
            "--promise",
            f"belongs to the bench {promise.name} ({promise.axis}); allowed: a promise of "
            f"{bench.name} ({bench.axis})",
        )
    out = []
    for name in msgspec.structs.asdict(promise.half_widths):
        half: Quantity | None = getattr(promise.half_widths, name)
        if half is None:
            continue
        found = outcome.result.identified.get(name)
        reached = None if found is None else found.half_width
        kept = reached is not None and reached <= half.value
        reasons = () if kept else _reasons(name, reached, outcome, bench, promise)
        unit = unit_of(name, bench)
        out.append(PromisedParameter(name, half.value, reached, unit, reasons))
    return out


def shown_effects(result: Identification) -> tuple[str, ...]:
    """Return the names of the effects that the logs show beyond inertia and constant friction."""
    names = [] if result.fit is None else [one.what for one in result.fit.explanations]
    if result.laws is not None and result.laws.position is not None:
        names.append(WHAT["friction_over_position"])
    return tuple(dict.fromkeys(names))


def _reasons(
    name: str,
    reached: float | None,
    outcome: IdentifiedModel,
    bench: Bench,
    promise: Promise,
) -> tuple[str, ...]:
    result = outcome.result
    reasons = [result.refused[name]] if name in result.refused else []
    if name not in SLIDING:
        ramp = result.ramp
        onsets = "no ramps were passed" if ramp is None else f"{ramp.onsets} onsets were detected"
        return (*reasons, onsets)
    sliding = [one for one in outcome.records if result.kinds.get(one.name) == SLIDING_LOG]
    if not sliding:
        return (*reasons, "no log of sliding motion was passed")
    lasting = sum(one.time.size * one.period for one in sliding)
    if lasting < SHORT * promise.duration.value and promise.half_widths.breakaway is None:
        reasons.append(f"the logs last {lasting:.4g} s, the test {promise.duration.value:.4g} s")
    try:
        facts = recorded_facts(sliding, bench)
    except UnusableLogs as error:
        return (*reasons, str(error))
    constant = bench.actuator.constant
    step = bench.encoder.resolution
    assumed = SensorPrecision(
        facts.sensing.period, step, promise.drive_noise.value * constant.interval[1]
    )
    axis = replace(worst_axis(bench), loads=facts.axis.loads)
    bound = QUANTILE * float(cramer_rao(list(facts.strokes), axis, assumed)[SLIDING.index(name)])
    planned: Quantity | None = getattr(promise.bounds, name)
    worse = 1.0 if planned is None else max(bound / planned.value, 1.0)
    noise = facts.sensing.noise / constant.value
    coarse = max(noise / promise.drive_noise.value, facts.sensing.step / step, 1.0)
    half = getattr(promise.half_widths, name).value
    effects = shown_effects(result)
    ratio = np.inf if reached is None else reached / half
    if effects and ratio > MORE * worse:
        return (*reasons, f"the logs show {listed(effects)}, which the promise does not contain")
    if noise > MORE * promise.drive_noise.value:
        reasons.append(
            f"the measured drive has a noise of {noise:.3g} {promise.drive_noise.unit}, but the "
            f"promise assumes {promise.drive_noise.value:.3g}"
        )
    if facts.sensing.step > MORE * step:
        reasons.append(
            f"the position is as noisy as with an encoder step of "
            f"{facts.sensing.step:.3g}, but the bench states {step:.3g}"
        )
    if worse > MORE or not np.isfinite(worse):
        allowed = f"at best +-{bound:.3g}" if np.isfinite(bound) else "unlimited"
        assert planned is not None
        reasons.append(
            f"the half width is {allowed} with the recorded strokes, "
            f"+-{planned.value:.3g} with the planned strokes: "
            "the recorded strokes are slower, shorter or fewer"
        )
    if not reasons or ratio > MORE * worse * coarse:
        planned_alike = "length, noise and strokes are as planned: " if not reasons else ""
        reasons.append(
            f"{planned_alike}the residual probably contains an effect that the model lacks, "
            "such as a load, friction that varies with position, or a lag of the drive"
        )
    return tuple(reasons)
