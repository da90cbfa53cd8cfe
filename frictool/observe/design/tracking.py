"""The observer for a coarse encoder (control/tracking_observer.py), designed from a model by one
number, its bandwidth.

    gains       three poles at p = exp(-w T) of the error in slip, where the model is x'' = (e +
                d)/J, d' = 0:
                L1 = 1 - p^3      L2 = 3/2 (1 - p)^2 (1 + p)/T      L3 = J (1 - p)^3/T^2
    bandwidth   w = RATE sqrt(delta_a/step), at most 1/T
                delta_a = (spread of the inertia x most effort + spread of the friction + noise)/J

An acceleration that is wrong by delta_a is a wrong speed of about delta_a/w until the disturbance
has taken it up; an innovation within one encoder step is a wrong speed of about step w. The two are
equal at sqrt(delta_a/step), and their sum is flat around it. RATE and CELL, the part of a step
inside which nothing is corrected, are from the sweep in docs/theory/velocity.md.
"""

from __future__ import annotations

import math

from frictool.documents.model import Model
from frictool.documents.observer import Knee, Observer, ObserverBacklash, Tracking
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity, si_unit
from frictool.observe.design.friction_map import friction_map
from frictool.observe.design.settings import UnsuitableSetting

RATE = 0.6
CELL = 0.5
LEAST_UNSURE = 0.02  # of an inertia that is given without an interval
ASSUMED_BREAKAWAY = 1.0  # over the friction in slip, of a model without friction


def design_tracking(
    model: Model,
    provenance: Provenance,
    bandwidth_rad_s: float | None = None,
    drive_noise: float = 0.0,
    cell: float = CELL,
    inertia: float | None = None,
) -> Observer:
    """The observer of a model, at the bench's period.

    bandwidth_rad_s: in place of the rule's. drive_noise: standard deviation of the measured drive
    [A | V]. cell: part of an encoder step. inertia [kg m2 | kg]: in place of the model's. Raises
    UnfitSetting where the bandwidth is none that the period can have.
    """
    bench = model.bench
    believed = model.parameters.inertia.value if inertia is None else inertia
    period, fastest = bench.sample_period_s, 1.0 / bench.sample_period_s
    bandwidth = (
        bandwidth_of(model, drive_noise, believed) if bandwidth_rad_s is None else bandwidth_rad_s
    )
    if not 0.0 < bandwidth <= fastest:
        raise UnsuitableSetting(
            f"bandwidth: found {bandwidth:g} rad/s; allowed: above 0, at most {fastest:g} rad/s, one over the bench's period; without it "
            f"the rule gives {bandwidth_of(model, drive_noise, believed):.4g} rad/s"
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
    """L1 [1], L2 [1/s], L3 [N m/rad | N/m] of a bandwidth [rad/s]."""
    pole = math.exp(-bandwidth * period)
    rest = -math.expm1(-bandwidth * period)
    return 1.0 - pole**3, 1.5 * rest**2 * (1.0 + pole) / period, inertia * rest**3 / period**2


def bandwidth_of(model: Model, drive_noise: float = 0.0, inertia: float | None = None) -> float:
    """The rule's w [rad/s]; drive_noise [A | V]."""
    bench, period = model.bench, model.bench.sample_period_s
    believed = model.parameters.inertia.value if inertia is None else inertia
    constant = bench.actuator.constant.value
    inertia_part, friction = spread(model)
    wrong = (
        inertia_part * constant * bench.actuator.limit.value + friction + constant * drive_noise
    ) / believed
    return min(RATE * math.sqrt(wrong / bench.encoder.resolution), 1.0 / period)


def spread(model: Model) -> tuple[float, float]:
    """Half the width of what the inertia may be off by, as a part of it, and of the dry friction [N
    m | N].

    By the model's intervals; of a parameter that has none, by the bench's range over the product's
    life.
    """
    known, today = model.bench.mechanics, model.parameters
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
    """What the slope grows by at each knee, the mean of both directions."""
    laws, today = model.laws, model.parameters
    if laws is None:
        return ()
    opposite = (
        laws.backward.viscous
        if laws.backward is not None and laws.backward.viscous is not None
        else today.viscous
    )
    before, found = 0.5 * (today.viscous.value + opposite.value), []
    for regime in laws.regimes:
        slope = 0.5 * (regime.viscous.value + (regime.backward or regime.viscous).value)
        found.append(
            Knee(Quantity(regime.above.value, unit=si_unit("velocity", model.axis)), slope - before)
        )
        before = slope
    return tuple(found)


def _backlash(model: Model) -> ObserverBacklash | None:
    """As plant/axis_model.py: where the bench does not say what friction there is inside, it is all
    of it."""
    known = model.bench.mechanics
    if known.backlash is None or known.backlash.value == 0.0:
        return None
    own = model.laws.backward if model.laws is not None else None
    today = model.parameters.coulomb.value
    least = min(today, own.coulomb.value if own is not None and own.coulomb is not None else today)
    return ObserverBacklash(
        known.backlash.value,
        min(known.backlash_coulomb.value, least) if known.backlash_coulomb else least,
    )
