"""Text view of an identification: parameters, then laws, measurements and refusals."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from pathlib import Path

import numpy as np

from frictool.adapters.temperature_factors import temperature_factors
from frictool.documents.laws import FrictionOverTemperature, Load, TotalLoad
from frictool.documents.measurement import MEASURED
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Span, si_unit
from frictool.identify.absolute_intervals import parameter_intervals
from frictool.identify.breakaway.rate_table import rate_lines
from frictool.identify.breakaway.stribeck_velocity import StribeckVelocityRange
from frictool.identify.estimators.servo_simulation import servo_quantities
from frictool.identify.fit_result import PARAMETERS, Explanation
from frictool.identify.from_logs import IdentifiedModel
from frictool.identify.methods import METHODS
from frictool.identify.rows.effects import EFFECTS
from frictool.identify.rows.position_orders import FITTED_ORDERS
from frictool.presentation.line_breaking import bounded

FIRMWARE = "fit of a simulation, in which the firmware of the bench's servo follows the logged goal"
REMOVED = frozenset(effect.term for effect in EFFECTS if not effect.needs_temperature)


def law_lines(model: Model) -> list[str]:
    """Return lines of text on the laws of friction and load."""
    if model.laws is None:
        return []
    lines = []
    today = model.parameters
    laws = model.laws
    for regime in laws.regimes:
        speed, viscous = regime.above, regime.viscous
        lines.append(
            f"from {speed.value:.4g} {speed.unit} [{speed.low:.4g}, {speed.high:.4g}] on, viscous "
            f"is {viscous.value:.4g} {viscous.unit} [{viscous.low:.4g}, {viscous.high:.4g}]"
        )
    if laws.position is not None:
        over, curve = laws.position.over, laws.position.coulomb
        orders = (
            f"{len(curve.forward) - 1} forward, {len(curve.backward or curve.forward) - 1} backward"
        )
        lines.append(
            f"friction over {over.low:.4g} to {over.high:.4g} {over.unit} as polynomials of "
            f"order {orders}"
        )
        for side, powers in (
            ("forward", curve.forward),
            ("backward", curve.backward or curve.forward),
        ):
            lines.append(
                f"  breakaway {side}, b0 first: {', '.join(f'{power:.5g}' for power in powers)}"
            )
    if laws.backward is not None:
        backward = {
            name: getattr(laws.backward, name) for name in ("viscous", "coulomb", "breakaway")
        }
        backward = {name: estimate for name, estimate in backward.items() if estimate is not None}
        lines.append(
            f"backward: {', '.join(shown(name, estimate) for name, estimate in backward.items())}; "
            f"the values of {', '.join(backward)} above are for forward motion"
        )
    if laws.temperature is not None:
        lines += temperature_lines(laws.temperature)
    if laws.load is not None:
        lines.append(f"load in addition to friction: {load_line(laws.load)}")
        if laws.load.total is not None:
            known = model.logged_positions if laws.load.stiffness is not None else None
            lines.append(total_line(laws.load.total, known))
    if laws.position is not None and today.coulomb.value > 0.0:
        lines.append(
            "breakaway relative to friction in slip: "
            f"{today.breakaway.value / today.coulomb.value:.4g}"
        )
    return lines


def temperature_lines(law: FrictionOverTemperature) -> list[str]:
    """Return lines of text on the reference temperature and on friction over temperature."""
    low, high = law.over.low, law.over.high
    changes = {"viscous": law.viscous, "coulomb": law.coulomb}
    known = {name: one for name, one in changes.items() if one is not None}
    unchanged = "" if known else "; the logs show no change with the temperature"
    lines = [
        f"the parameters are valid at {law.reference.value:.4g} degC; the logs are at {low:.4g} to "
        f"{high:.4g} degC{unchanged}"
    ]
    ends = dict(zip(changes, temperature_factors(law, np.array([low, high])), strict=True))
    for name, change in known.items():
        slope = change.slope
        cold, hot = ends[name]
        lines.append(
            f"  {name} changes by {100.0 * slope.value:.3g} % per K "
            f"[{100.0 * slope.interval[0]:.3g}, {100.0 * slope.interval[1]:.3g}]: factor "
            f"{cold:.3g} at {low:.4g} degC, factor {hot:.3g} at {high:.4g} degC"
        )
    return lines


def shown(name: str, estimate: Estimate) -> str:
    """Return a parameter with its unit and its interval as text."""
    low, high = estimate.interval
    return f"{name} {estimate.value:.5g} {estimate.unit} [{low:.5g}, {high:.5g}]"


def load_line(load: Load) -> str:
    """Return the load laws as text."""
    parts = [] if load.stiffness is None else [shown("spring", load.stiffness)]
    if load.gravity is not None:
        parts += [
            shown("gravity sine", load.gravity.sine),
            shown("gravity cosine", load.gravity.cosine),
        ]
    for ripple in load.ripples:
        cycles, per = ripple.cycles, ripple.per
        parts += [
            shown(
                f"ripple of {cycles:g} {'cycle' if cycles == 1.0 else 'cycles'} per "
                f"{per.value:.5g} {per.unit} sine",
                ripple.sine,
            ),
            shown("cosine", ripple.cosine),
        ]
    return ", ".join(parts)


def total_line(total: TotalLoad, known: Span | None = None) -> str:
    """Return the range of offset and load over the position as text.

    known: positions of the logs, if the load beyond them may differ; else None
    """
    over = (
        "at all positions"
        if total.over is None
        else (f"from {total.over.low:.4g} to {total.over.high:.4g} {total.over.unit}")
    )
    least, largest = total.least, total.largest
    beyond = ""
    if known and total.over and (known.low > total.over.low or known.high < total.over.high):
        beyond = (
            f", if the spring outside the logs ({known.low:.4g} to {known.high:.4g} {known.unit}) "
            "is the same"
        )
    return (
        f"offset and load together, {over}: {least.value:.4g} to {largest.value:.4g} {least.unit}, "
        f"within [{least.low:.4g}, {largest.high:.4g}]; uncertainty at most "
        f"{total.error.value:.3g} at any position{beyond}"
    )


def measurement_lines(model: Model) -> list[str]:
    """Return lines of text on the measured properties of the bench."""
    measured = model.measurement
    if measured is None:
        return []
    lines = []
    for name in MEASURED:
        one: Estimate | None = getattr(measured, name)
        if one is not None:
            lines.append(f"measured: {shown(name, one)}")
    return lines + [f"not measured: {name}: {reason}" for name, reason in measured.refused.items()]


def presliding_lines(model: Model) -> list[str]:
    """Return lines of text on presliding friction."""
    presliding = model.presliding
    if presliding is None:
        return []
    lines = [
        f"presliding, by {presliding.law}, which predicts best: "
        f"{shown('z_max', presliding.limit)}, {shown('stiffness', presliding.stiffness)}"
    ]
    for name in ("lugre", "elasto_plastic", "maxwell_slip"):
        law = getattr(presliding, name)
        if law is not None:
            limit = getattr(law, "elastic_limit", None)
            elastic = "" if limit is None else f", {shown('elastic limit', limit)}"
            unseen = (
                f"force error {100.0 * law.held_out:.3g} % of the breakaway on branches left out "
                "of the fit"
            )
            lines.append(f"  {name}: {shown('stiffness', law.stiffness)}{elastic}; {unseen}")
    if presliding.preisach is not None:
        size = presliding.preisach
        lines.append(
            f"  preisach: {len(size.table) // 2} amplitudes, {shown('up to', size.limit)}, "
            f"{shown('saturation', size.saturation)}"
        )
    return lines + [
        f"  {name}: not determined: {reason}" for name, reason in presliding.refused.items()
    ]


def force_line(error: float | None) -> str:
    """Return a line of text on the force error."""
    return (
        "force error unknown: no sample certainly slips, or the drive was off"
        if error is None
        else f"force error {100 * error:.3g} %"
    )


def dropped_lines(dropped: Sequence[str]) -> list[str]:
    """Return lines of text on the parameters that the fit sets to 0."""
    weak = [name for name in dropped if name in FITTED_ORDERS]
    useless = [name for name in dropped if name not in weak]
    reasons = {
        "they do not improve the prediction of strokes left out of the fit": useless,
        "the log does not determine them (the intervals include their effect)": weak,
    }
    return [
        f"set to 0, because {reason}: {', '.join(names)}"
        for reason, names in reasons.items()
        if names
    ]


def explanation_place(one: Explanation) -> str:
    """Return text that says whether a part of the effort is modelled, removed or unexplained."""
    if one.state == "left":
        return "left in the residual"
    return (
        "removed from the effort, and not in the model" if one.name in REMOVED else "in the model"
    )


def explanation_line(one: Explanation, unit: str) -> str:
    """Return a line of text on one explanation of the effort."""
    place = explanation_place(one)
    verb = "predicts" if len(one.rivals) == 1 else "predict"
    names = " and ".join(one.rivals)
    rivals = (
        f". {names[0].upper()}{names[1:]} {verb} these strokes equally well, and this motion "
        "cannot distinguish between them"
        if names
        else ""
    )
    settle = "" if place == "in the model" else f". To decide, {one.settle}"
    return (
        f"{place}: {one.what}, {one.effort:.3g} {unit} rms. It changes the prediction error on "
        f"strokes left out of the fit by a factor of {one.held_out:.2g}{rivals}{settle}"
    )


def fall_line(fall: StribeckVelocityRange, unit: str) -> str:
    """Return a line on the Stribeck velocities for which the breakaway's interval is valid.

    If no fit gives the Stribeck velocity, the line also says how to narrow the interval.
    """
    if fall.known:
        return (
            f"the interval of the breakaway is valid for Stribeck velocities in the interval of "
            f"the fit, [{fall.low:.3g}, {fall.high:.3g}] {unit}"
        )
    upper = f"up to {fall.high:.2g} {unit}" if isfinite(fall.high) else "of any size"
    lower = f" from {fall.low:.2g}" if fall.low > 0.0 else ""
    return (
        f"the interval of the breakaway is valid for Stribeck velocities{lower} {upper}, which the "
        "encoder cannot separate; for a narrower interval, use a finer encoder, a slower ramp, or "
        "runs at constant speeds (--method stribeck-curve)"
    )


def parameter_lines(model: Model) -> list[str]:
    """Return the table of the parameters as lines of text.

    The intervals are valid for the nominal drive constant. If the bench states an interval of the
    constant, another column contains intervals that include the uncertainty of the constant.
    """
    rows = parameter_intervals(model)
    constant = model.bench.actuator.constant
    interval = constant.interval
    with_absolute = interval[0] < interval[1]
    width = max(len(row.name) for row in rows) + 2
    absolute = f"{'absolute interval':<28}" if with_absolute else ""
    lines = [
        f"{'parameter':<{width}}{'value':>12}  "
        f"{f'interval at {100 * model.confidence:g} %':<28}{absolute}{'unit':<12}source"
    ]
    for row in rows:
        estimate = row.estimate
        known = estimate.low is not None and estimate.high is not None and not row.assumed
        own = f"[{estimate.low:.5g}, {estimate.high:.5g}]" if known else "unknown"
        ends = f"[{row.absolute.low:.5g}, {row.absolute.high:.5g}]" if known else "unknown"
        absolute = f"{ends:<28}" if with_absolute else ""
        lines.append(
            f"{row.name:<{width}}{estimate.value:>12.5g}  "
            f"{own:<28}{absolute}{estimate.unit:<12}{estimate.source}"
        )
    return lines + [
        f"{row.name}: assumed from {row.estimate.low:.5g} to "
        f"{row.estimate.high:.5g} {row.estimate.unit}, which is no interval at "
        f"{100 * model.confidence:g} %"
        for row in rows
        if row.assumed
    ]


def servo_lines(outcome: IdentifiedModel) -> list[str]:
    """Return lines of text on the constants of a servo and on the position error."""
    fit = outcome.result.fit
    assert fit is not None
    rms, mean = (fit.details[f"position_error_{name}"] for name in ("rms", "mean"))
    lines = []
    for name, one in servo_quantities(outcome.model.bench).items():
        low, high = one.interval
        ends = f" [{low:.5g}, {high:.5g}]" if low < high else ""
        source = "bench" if name not in fit.constants else "identified"
        lines.append(f"servo: {name} {one.value:.5g} {one.unit}{ends}, {source}")
    return [
        *lines,
        f"position error along the goals: {rms:.4g} rad rms, {mean:.4g} rad on average; "
        f"condition number {fit.condition:.3g}; {fit.samples} samples",
    ]


def table(outcome: IdentifiedModel) -> str:
    """Return the whole identification as text."""
    model, result = outcome.model, outcome.result
    lines = [f"{Path(name).name}: log of kind {kind}" for name, kind in result.kinds.items()]
    servo = model.bench.actuator.servo is not None and result.fit is not None
    what = FIRMWARE if servo else METHODS[result.method].what
    lines.append(f"{result.method}: {what}")
    chosen = result.fit is not None and result.fit.why
    lines.append(f"  chosen: {chosen}" if chosen else f"  right for {METHODS[result.method].when}")
    lines += parameter_lines(model)
    if servo:
        lines += servo_lines(outcome)
    elif result.fit is not None:
        lines.append(
            f"{force_line(result.fit.force_error)}; condition number {result.fit.condition:.3g}; "
            f"{result.fit.samples} samples"
        )
    if result.ramp is not None:
        unit = model.parameters.breakaway.unit
        lines.append(
            f"breakaway from {result.ramp.onsets} onsets of motion; until the encoder shows an "
            f"onset, the effort rises by {result.ramp.delay:.3g} {unit} on average (corrected)"
        )
        lines.append(fall_line(result.ramp.fall, si_unit("velocity", model.axis)))
    if result.over_rate is not None:
        lines += rate_lines(result.over_rate, model.parameters.breakaway.unit)
    if result.fit is not None:
        lines += dropped_lines(result.fit.dropped)
    if result.fit is not None:
        unit = model.parameters.offset.unit
        lines += [explanation_line(one, unit) for one in result.fit.explanations]
    lines += result.notes
    lines += law_lines(model) + presliding_lines(model) + measurement_lines(model)
    ordered = dict.fromkeys((*PARAMETERS, *result.refused))
    lines += [
        f"not identified: {name}: {result.refused[name]}"
        for name in ordered
        if name in result.refused
    ]
    return bounded(lines)
