"""Test whether the encoder is too coarse to identify the inertia with a differentiating filter.

The test is thesis (4.3) (`assess/quantisation.py`) with the filter's impulse response h in place of
the second difference. Quantisation changes the acceleration by at most D_a = step/2 sum|h|, which
shifts the inertia J by up to J D_a/a. Here a is the rms of the acceleration that the other
regressors do not explain: if all strokes have the same speed, a is small, because the acceleration
is nearly proportional to the difference between the velocity and this speed. Identifying the
inertia is useful only if the shift is less than half the width of its interval in bench.yaml.
"""

from __future__ import annotations

import math
from dataclasses import replace

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity, si_unit
from frictool.identify.assess.quantisation import acceleration_error, inertia_error
from frictool.identify.fit_result import SlidingFit
from frictool.identify.motion_record import MotionRecord
from frictool.typing import Vector


def unresolved_inertia(
    record: MotionRecord, bench: Bench, response: Vector, acceleration: float, smoothing: str
) -> str | None:
    """Return why the encoder is too coarse to identify the inertia, or None.

    - response: impulse response from the position (1/s^2) or the measured velocity (1/s) to the
      acceleration
    - acceleration: rms acceleration that the other regressors do not explain, rad/s^2 | m/s^2
    - smoothing: description of the filter for the message
    """
    prior = bench.mechanics.inertia
    # without an interval in bench.yaml, an inertia with an error of up to 100 % is still useful
    known = _known(prior)
    error = acceleration_error(record.count, response)
    bound = prior.value * error / acceleration if acceleration > 0.0 else math.inf
    effort = bench.actuator.constant.value * bench.actuator.limit.value
    raw = inertia_error(prior.value, record.resolution, record.period, effort)
    ranged = " (range in the bench)" if prior.interval[0] < prior.interval[1] else ""
    if bound >= known:
        return (
            f"quantisation can change the inertia by {_percent(bound, prior.value)} after "
            f"smoothing {smoothing} ({_percent(raw, 1.0)} without smoothing); needed: below "
            f"{_percent(known, prior.value)}{ranged}"
        )
    return None


def hidden_by_noise(noise: float, unexplained: float, bench: Bench) -> bool:
    """Return True if noise can change the inertia by at least the half width in bench.yaml.

    `unexplained` is the rms acceleration [rad/s^2 | m/s^2] that the other regressors do not
    explain. Noise with the rms `noise`, which is a part of `unexplained`, multiplies the fitted
    inertia by 1 - (noise/unexplained)^2.
    """
    prior = bench.mechanics.inertia
    return prior.value * noise**2 >= _known(prior) * (unexplained**2 - noise**2)


def _known(prior: Quantity) -> float:
    """Return the half width of the interval of `prior`; without an interval, return the value."""
    return 0.5 * (prior.interval[1] - prior.interval[0]) or prior.value


def refuse_hidden_inertia(
    fit: SlidingFit,
    record: MotionRecord,
    bench: Bench,
    response: Vector,
    acceleration: float,
    smoothing: str,
) -> SlidingFit:
    """Remove the inertia from the fit if the encoder is too coarse to identify the inertia.

    The field `refused` of the result then contains the reason from `unresolved_inertia`.
    """
    reason = unresolved_inertia(record, bench, response, acceleration, smoothing)
    if reason is None or "inertia" not in fit.parameters:
        return fit
    explanation = (
        f"the fit gives {fit.parameters['inertia'].value:.4g} "
        f"{si_unit('inertia', bench.axis)}; {reason}"
    )
    kept = {name: interval for name, interval in fit.parameters.items() if name != "inertia"}
    return replace(fit, parameters=kept, refused={**fit.refused, "inertia": explanation})


def _percent(part: float, whole: float) -> str:
    return f"+-{100.0 * part / whole:.3g} %"
