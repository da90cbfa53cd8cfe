"""Profile and feedforward of a design, and rules for values that the design leaves out.

speed           the top speed in bench.yaml
acceleration    (share K u_max - F_c - load - sigma_v speed)/J, the smallest value of all vertices;
                u_max is the smallest of the drive's limit, the specified peak, and the current
                that supply voltage and back-EMF allow at that speed
jerk            2 acceleration/(N T) for a moving average over N samples; N T is a tenth of
                speed/acceleration (at least 4 T), or one period of the lowest resonance, where the
                moving average has a zero
feedforward     the model's values; the Coulomb term switches on at the speed of one encoder step in
                10 samples, and off at half of this speed

K is the actuator's constant, F_c the Coulomb friction, sigma_v the viscous friction, J the inertia,
T the sample period, and share the design's `drive_share`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from frictool.adapters.model_polytope import polytope
from frictool.control.jerk_limited_profile import ProfileLimits
from frictool.documents import controller as stored
from frictool.documents.design import Design
from frictool.documents.design_blocks import MOST_SMOOTHING, FeedforwardDesign, ProfileDesign
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.errors import FrictoolError, NoSolutionError
from frictool.synth.load_disturbance import disturbance

RecordDerived = Callable[[str, float, str, str], float]

SMOOTHED = 0.1  # duration that the smoothing adds to a move, relative to the time to the top speed
LEAST_SMOOTHING = 4  # samples
STEP_SAMPLES = 10.0  # samples in which a reference at the switching speed moves one encoder step
OFF = 0.5  # share of the switching speed at which the Coulomb term switches off


def outside_notes(design: Design) -> tuple[str, ...]:
    """Return a note that no margin depends on profile and feedforward.

    The result is empty if the design has neither a profile nor a feedforward.
    """
    blocks = [name for name in ("profile", "feedforward") if getattr(design, name) is not None]
    words = f"{' and '.join(blocks)}: outside the loop, so that no margin depends on it"
    return (f"{words}; simulate includes it",) if blocks else ()


def stored_profile(
    model: Model, requested: ProfileDesign, drive_peak: float, record_derived: RecordDerived
) -> stored.Profile:
    """Return the profile of a design in its stored form.

    `record_derived` records a derived value by name, value, unit and source, and returns the value.
    Raises FrictoolError if the speed is missing or the jerk too small, NoSolutionError if no effort
    is left for the acceleration.
    """
    units = {name: si_unit(name, model.axis) for name in ("velocity", "acceleration", "jerk")}
    top = model.bench.mechanics.top_speed
    if requested.speed is not None:
        speed = requested.speed.value
    elif top is not None:
        speed = record_derived(
            "profile.speed", top.value, units["velocity"], "the bench's top speed"
        )
    else:
        raise FrictoolError(
            "profile.speed: missing, and the bench has no mechanics.top_speed; write one of "
            "these keys"
        ).at("design", "profile.speed")
    if requested.acceleration is not None:
        acceleration = requested.acceleration.value
    else:
        acceleration = record_derived(
            "profile.acceleration",
            *_least_acceleration(model, speed, requested.drive_share, drive_peak),
        )
    period = model.bench.sample_period_s
    if requested.jerk is not None:
        samples = max(math.ceil(2.0 * acceleration / (requested.jerk.value * period) - 1e-9), 2)
        if samples > MOST_SMOOTHING:
            least = ProfileLimits(speed, acceleration, MOST_SMOOTHING).jerk(period)
            raise FrictoolError(
                f"profile.jerk: found {requested.jerk.value:.4g} {units['jerk']}; allowed: at "
                f"least {least:.4g} {units['jerk']}, which smooths over {MOST_SMOOTHING} samples; "
                "lower profile.acceleration, or raise profile.jerk"
            ).at("design", "profile.jerk")
    else:
        samples, source = _smoothing(model, speed / acceleration)
        jerk = ProfileLimits(speed, acceleration, samples).jerk(period)
        record_derived("profile.jerk", jerk, units["jerk"], source)
    return stored.Profile(speed, acceleration, samples)


def _least_acceleration(
    model: Model, speed: float, share: float, drive_peak: float
) -> tuple[float, str, str]:
    """Return an acceleration that all vertices can reach at `speed`, its unit, and an explanation.

    The acceleration uses the fraction `share` of the drive's limit, or of `drive_peak` if that is
    smaller.
    """
    actuator = model.bench.actuator
    load = disturbance(model).total
    rates = []
    for vertex in polytope(model).vertices:
        most = min(actuator.limit.value, drive_peak)
        if actuator.winding is not None:
            left = actuator.winding.voltage_v - vertex.constant * speed
            most = min(most, left / actuator.winding.resistance_ohm)
        effort = share * vertex.constant * most
        rest = effort - vertex.coulomb - load - vertex.viscous * speed
        rates.append((rest / vertex.inertia, rest, effort, vertex))
    acceleration, rest, effort, vertex = min(rates, key=lambda one: one[0])
    unit = si_unit("effort", model.axis)
    words = (
        f"{share:g} of the drive leaves {effort:.4g} {unit}, friction and load at "
        f"{speed:.4g} {si_unit('velocity', model.axis)} take {effort - rest:.4g} {unit}, inertia "
        f"{vertex.inertia:.4g} {si_unit('inertia', model.axis)}"
    )
    if acceleration <= 0.0:
        raise NoSolutionError(
            f"profile.speed: no effort is left to accelerate at this speed ({words}); lower "
            "profile.speed, or narrow the intervals of coulomb and viscous"
        ).at("design", "profile.speed")
    return acceleration, si_unit("acceleration", model.axis), f"worst plant: {words}"


def _smoothing(model: Model, rise: float) -> tuple[int, str]:
    """Return the number of samples of the moving average, and the source of this number.

    rise: (top speed)/(acceleration) [s].
    """
    period = model.bench.sample_period_s
    if model.resonances is not None:
        lowest = min(pole.rad_s for pole in model.resonances.poles)
        samples = math.ceil(2.0 * math.pi / (lowest * period))
        return min(samples, MOST_SMOOTHING), f"one period of the resonance at {lowest:.4g} rad/s"
    samples = max(round(SMOOTHED * rise / period), LEAST_SMOOTHING)
    return min(samples, MOST_SMOOTHING), (
        f"a move becomes longer by {SMOOTHED:.0%} of the time to the top speed, but at least by "
        f"{LEAST_SMOOTHING} samples"
    )


def stored_feedforward(
    model: Model, requested: FeedforwardDesign, record_derived: RecordDerived
) -> stored.Feedforward:
    """Return the feedforward of a design in its stored form.

    `record_derived` records a derived value by name, value, unit and source, and returns the value.
    Raises FrictoolError if the bandwidth of the filter is at least 2/T.
    """
    period = model.bench.sample_period_s
    bandwidth = requested.filter_rad_s or 0.0
    if bandwidth * period >= 2.0:
        raise FrictoolError(
            f"feedforward.filter_rad_s: found {bandwidth:g}; allowed: below {2.0 / period:g} rad/s "
            "(2/T); a faster filter alternates from sample to sample"
        ).at("design", "feedforward.filter_rad_s")
    values = {}
    for name, dimension in (("inertia", "inertia"), ("viscous", "viscous"), ("coulomb", "effort")):
        provided = getattr(requested, name)
        values[name] = (
            record_derived(
                f"feedforward.{name}",
                getattr(model.parameters, name).value,
                si_unit(dimension, model.axis),
                "the model",
            )
            if provided is None
            else provided.value
        )
    if requested.switch_on_speed is not None:
        switch_on = requested.switch_on_speed.value
    else:
        switch_on = record_derived(
            "feedforward.switch_on_speed",
            model.bench.encoder.resolution / (STEP_SAMPLES * period),
            si_unit("velocity", model.axis),
            f"one encoder step in {STEP_SAMPLES:g} samples",
        )
    return stored.Feedforward(
        **values,
        switch_on_speed=switch_on,
        switch_off_speed=OFF * switch_on,
        filter_rad_s=bandwidth,
    )
