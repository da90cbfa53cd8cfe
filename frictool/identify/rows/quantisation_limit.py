"""What the encoder's quantisation leaves of a parameter, whatever filter a method differentiates
with.

(4.3) (`assess/quantisation.py`), with the gain of the filter in place of the double difference's:
the largest error that quantisation can leave on the acceleration, D_a = step/2 sum|h|, moves the
inertia by up to J D_a/rms(a). Identification is of use only where that is less than what is known
without it (4.2.1), the half width of the bench's own interval.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.assess.quantisation import acceleration_error, inertia_error
from frictool.identify.fit_result import SlidingFit
from frictool.identify.motion_record import MotionRecord, Vector


def unresolved_inertia(
    record: MotionRecord, bench: Bench, response: Vector, acceleration: Vector, smoothing: str
) -> str | None:
    """Why the inertia is not to be had from this encoder, or None.

    response: from position to acceleration, 1/s^2, or from a measured velocity, 1/s, one number a
    sample. acceleration (n,): of the samples used. smoothing: the filter, for people.
    """
    prior = bench.mechanics.inertia
    known = 0.5 * (prior.interval[1] - prior.interval[0])
    if known == 0.0:
        known = (
            prior.value
        )  # the bench gives no interval: anything better than a factor of two is of use
    bound = (
        prior.value
        * acceleration_error(record.count, response)
        / float(np.sqrt(np.mean(acceleration**2)))
    )
    effort = bench.actuator.constant.value * bench.actuator.limit.value
    raw = inertia_error(prior.value, record.resolution, record.period, effort)
    if bound >= known:
        return (
            f"quantisation can move it by {_percent(bound, prior.value)} after smoothing {smoothing} "
            f"({_percent(raw, 1.0)} by (4.3) without), and the bench knows it to {_percent(known, prior.value)}"
        )
    return None


def refuse_hidden_inertia(
    fit: SlidingFit,
    record: MotionRecord,
    bench: Bench,
    response: Vector,
    acceleration: Vector,
    smoothing: str,
) -> SlidingFit:
    """The fit, its inertia moved to what is refused where `unresolved_inertia` says why."""
    reason = unresolved_inertia(record, bench, response, acceleration, smoothing)
    if reason is None or "inertia" not in fit.parameters:
        return fit
    told = f"the fit gives {fit.parameters['inertia'].value:.4g} {si_unit('inertia', bench.axis)}; {reason}"
    kept = {name: interval for name, interval in fit.parameters.items() if name != "inertia"}
    return replace(fit, parameters=kept, refused={**fit.refused, "inertia": told})


def _percent(part: float, whole: float) -> str:
    return f"+-{100.0 * part / whole:.2g} %"
