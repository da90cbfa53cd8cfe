"""Design of the tracking observer (control/tracking_observer.py) by its bandwidth.

    L1 = 1 - p^3      L2 = 3/2 (1 - p)^2 (1 + p)/T      L3 = J (1 - p)^3/T^2      p = exp(-w T)
    w = RATE sqrt(delta_a/step), at most 1/T
    delta_a = (unsure (largest effort) + uncertainty of friction + noise)/J

w is the bandwidth, T the period, J the inertia, `unsure` its relative uncertainty, `step` the
encoder step, and delta_a the possible error of the acceleration. The model in slip is x'' = (effort
+ d)/J, d' = 0 with the position x and the disturbance effort d. The gains L1 to L3 place all three
poles of the estimation error at p.

An error delta_a causes a speed error of about delta_a/w, until the estimate of d compensates
delta_a. An innovation of one encoder step causes a speed error of about w times `step`. The sum of
the two errors has a flat minimum at w = sqrt(delta_a/step), where both errors are equal. A
parameter sweep gave the values of RATE and CELL, the dead zone in encoder steps
(docs/theory/velocity.md).
"""

from __future__ import annotations

import math

from frictool.documents.model import Model
from frictool.documents.observer import Knee, Observer, ObserverBacklash, Tracking
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity, si_unit
from frictool.observe.design.friction_map import friction_map
from frictool.observe.design.switched_settings import UnsuitableSetting

RATE = 0.6  # bandwidth relative to sqrt(delta_a/step)
CELL = 0.5  # dead zone of the innovation, relative to an encoder step
LEAST_UNSURE = 0.02  # smallest relative uncertainty of the inertia that is assumed
ASSUMED_BREAKAWAY = 1.0  # breakaway relative to the friction in slip, for a model without friction


def design_tracking(
    model: Model,
    provenance: Provenance,
    bandwidth_rad_s: float | None = None,
    drive_noise: float = 0.0,
    cell: float = CELL,
    inertia: float | None = None,
) -> Observer:
    """Design the tracking observer for a model, at the bench's sample period.

    - bandwidth_rad_s: bandwidth w [rad/s]; None for the value of `bandwidth_of`
    - drive_noise: standard deviation of the measured drive [A | V]
    - cell: dead zone of the innovation, in encoder steps
    - inertia: inertia J [kg m2 | kg]; None for the model's inertia

    Raises UnsuitableSetting if the bandwidth is above 1/period.
    """
    bench = model.bench
    believed = model.parameters.inertia.value if inertia is None else inertia
    period = bench.sample_period_s
    fastest = 1.0 / bench.sample_period_s
    bandwidth = (
        bandwidth_of(model, drive_noise, believed) if bandwidth_rad_s is None else bandwidth_rad_s
    )
    if not 0.0 < bandwidth <= fastest:
        raise UnsuitableSetting(
            f"bandwidth: found {bandwidth:g} rad/s; allowed: above 0 and at most {fastest:g} rad/s "
            "(1/sample_period_s of the bench); the default is "
            f"{bandwidth_of(model, drive_noise, believed):.4g} rad/s"
        )
    return Observer(
        format="observer/1",
        name=model.name,
        axis=model.axis,
        sample_period_s=period,
        inertia=Quantity(believed, unit=si_unit("inertia", model.axis)),
        friction=friction_map(model),
        bench=bench,
        provenance=provenance,
        tracking=Tracking(
            gains=gains(bandwidth, period, believed),
            bandwidth_rad_s=bandwidth,
            cell=cell * bench.encoder.resolution,
            breakaway_ratio=_breakaway(model),
            knees=_knees(model),
            backlash=_backlash(model),
        ),
    )


def gains(bandwidth: float, period: float, inertia: float) -> tuple[float, float, float]:
    """Return the gains L1 [1], L2 [1/s] and L3 [N m/rad | N/m] for a bandwidth [rad/s]."""
    pole = math.exp(-bandwidth * period)
    rest = -math.expm1(-bandwidth * period)
    return 1.0 - pole**3, 1.5 * rest**2 * (1.0 + pole) / period, inertia * rest**3 / period**2


def bandwidth_of(model: Model, drive_noise: float = 0.0, inertia: float | None = None) -> float:
    """Return the default bandwidth w [rad/s] of a tracking observer.

    `drive_noise` is the standard deviation of the measured drive [A | V].
    """
    bench = model.bench
    period = model.bench.sample_period_s
    believed = model.parameters.inertia.value if inertia is None else inertia
    constant = bench.actuator.constant.value
    inertia_part, friction = spread(model)
    wrong = (
        inertia_part * constant * bench.actuator.limit.value + friction + constant * drive_noise
    ) / believed
    return min(RATE * math.sqrt(wrong / bench.encoder.resolution), 1.0 / period)


def spread(model: Model) -> tuple[float, float]:
    """Return the relative uncertainty of the inertia and the uncertainty of dry friction [N m | N].

    An uncertainty is half the width of the model's interval. Without an interval, the range over
    the product's life in bench.yaml is used. The first result is at least LEAST_UNSURE.
    """
    known = model.bench.mechanics
    today = model.parameters
    inertia = _half_width(today.inertia) or _half_width(known.inertia)
    friction = _half_width(today.coulomb) or _half_width(known.coulomb)
    return max(inertia / today.inertia.value, LEAST_UNSURE), friction


def _half_width(quantity: Quantity) -> float:
    low, high = quantity.interval
    return 0.5 * (high - low)


def _breakaway(model: Model) -> float:
    today = model.parameters
    if today.coulomb.value == 0.0:
        return ASSUMED_BREAKAWAY
    return max(1.0, today.breakaway.value / today.coulomb.value)


def _knees(model: Model) -> tuple[Knee, ...]:
    """Return each speed at which the viscous coefficient changes, and the change.

    The coefficients are means of both directions.
    """
    laws, today = model.laws, model.parameters
    if laws is None:
        return ()
    opposite = (
        laws.backward.viscous
        if laws.backward is not None and laws.backward.viscous is not None
        else today.viscous
    )
    before = 0.5 * (today.viscous.value + opposite.value)
    knees = []
    for regime in laws.regimes:
        slope = 0.5 * (regime.viscous.value + (regime.backward or regime.viscous).value)
        knees.append(
            Knee(Quantity(regime.above.value, unit=si_unit("velocity", model.axis)), slope - before)
        )
        before = slope
    return tuple(knees)


def _backlash(model: Model) -> ObserverBacklash | None:
    known = model.bench.mechanics
    if known.backlash is None or known.backlash.value == 0.0:
        return None
    backward = model.laws.backward if model.laws is not None else None
    today = model.parameters.coulomb.value
    least = min(
        today,
        backward.coulomb.value if backward is not None and backward.coulomb is not None else today,
    )
    return ObserverBacklash(
        known.backlash.value,
        min(known.backlash_coulomb.value, least) if known.backlash_coulomb else least,
    )
