"""Check, before the design, for requirements that no controller can reach on this bench.

Bands are compared with the encoder and the specification, times with the drive's limit. The
shortest time t(s) for a step of length s from rest follows from bang-bang control of a plant with
inertia J, Coulomb friction F and the actuator's effort E at its limit:

    a+ = (E - F)/J    acceleration
    a- = (E + F)/J    deceleration
    x1 = 1.05 s a-/(a+ + a-)    switching position, so that the axis stops at 1.05 s

The axis may overshoot by 5 % of s; t is the time at which it passes 0.95 s, and grows with the
square root of s. Inside a backlash only the motor's smaller friction acts during the acceleration.
Viscous friction, the drive's lag and, in one of the two directions, a load can only lengthen t; all
three are neglected.

A specification does not state the length of its steps. The drive must be able to make the shortest
step to which the specification can apply (else exit 4). The length of this step is 20 times
static_error (at least 20 encoder counts), but at most the travel. A note names the length above
which steps are not possible in the specified time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from frictool.adapters.model_polytope import polytope
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.quantity import PositiveLength, si_unit
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError, NoSolutionError

WITHIN = 0.05  # share of the step: error band of response_time_95_s
RISE = (0.1, 0.9)  # shares of the step between which rise_time_s counts


class FastestStep(NamedTuple):
    """Slowest plant of the bench with its drive at the limit.

    `effort` [N m | N], `inertia` and `coulomb` in SI units; `per_root` is t(s)/sqrt(s).
    """

    effort: float
    inertia: float
    coulomb: float
    per_root: float


def check_feasible(model: Model, spec: Spec, design: Design) -> tuple[str, ...]:
    """Return notes on specified times that the drive can reach in short steps only.

    Raises FrictoolError if a band contradicts the encoder or the specification, NoSolutionError if
    the drive cannot reach a time.
    """
    _check_bands(model, spec, design)
    notes = []
    delay = model.bench.delay_samples * model.bench.sample_period_s
    for key, part, before in (
        ("response_time_95_s", _settling, delay),
        ("rise_time_s", _rising, 0.0),
    ):
        required = getattr(spec, key)
        if required is not None:
            notes += _check_time(
                (key, required, before), model, shortest_step(model, spec), fastest(model, part)
            )
    return tuple(notes)


def _check_bands(model: Model, spec: Spec, design: Design) -> None:
    law = design.position_law
    limiter = design.limiter
    unit = si_unit("position", model.axis)
    step = model.bench.encoder.resolution
    if law is not None and law.band is not None and law.band.value < step:
        raise FrictoolError(
            f"position_law.band: found {law.band.value:.6g} {unit}; allowed: at least the "
            f"encoder's step, {step:.6g} {unit}, below which "
            "no error is measured; write a larger band, or leave the key out for one step"
        ).at("design", "position_law.band")
    bands: dict[str, PositiveLength | None] = {} if limiter is None else {"limiter": limiter.band}
    bands |= {} if law is None or law.action == "none" else {"position_law": law.band}
    for name, length in bands.items():
        band = step if length is None else length.value
        if spec.static_error is not None and band > spec.static_error.value:
            finding = (
                f"the encoder's step is {band:.6g} {unit}"
                if length is None
                else f"found {band:.6g} {unit}"
            )
            raise FrictoolError(
                f"{name}.band: {finding}; allowed: at most static_error of the specification, "
                f"{spec.static_error.value:.6g} {unit}: the "
                "drive is released anywhere in the band; narrow the band, or widen static_error"
            ).at("design", f"{name}.band")


def shortest_step(model: Model, spec: Spec) -> float:
    """Return the shortest step [rad | m] to which a specified response time can apply."""
    resolution, travel = model.bench.encoder.resolution, model.bench.mechanics.travel
    error = resolution if spec.static_error is None else max(resolution, spec.static_error.value)
    return min(error / WITHIN, math.inf if travel is None else travel.high - travel.low)


def _settling(up: float, down: float) -> float:
    """Return the shortest time until a step of length 1 stays within 5 %.

    `up` and `down` are the largest acceleration and deceleration.
    """
    turning = (1.0 + WITHIN) * down / (up + down)
    if turning >= 1.0 - WITHIN:
        return math.sqrt(2.0 * (1.0 - WITHIN) / up)
    fastest_speed = math.sqrt(2.0 * up * turning)
    return fastest_speed / up + (fastest_speed - math.sqrt(4.0 * WITHIN * down)) / down


def _rising(up: float, down: float) -> float:
    """Return the shortest time from 10 % to 90 % of a step of length 1; braking comes later."""
    low, high = RISE
    return math.sqrt(2.0 * high / up) - math.sqrt(2.0 * low / up)


def fastest(model: Model, part: Callable[[float, float], float]) -> FastestStep:
    """Return the slowest vertex of the model's polytope, with the drive at its limit.

    `part` maps the largest acceleration and deceleration to the time of a step of length 1. The
    drive can move every vertex, since synth/load_disturbance.py raises an error otherwise.
    """
    known = model.bench.mechanics
    limit = model.bench.actuator.limit.value
    rates = []
    loose = (
        known.backlash_coulomb.value
        if known.backlash is not None and known.backlash_coulomb is not None
        else math.inf
    )
    for vertex in polytope(model).vertices:
        effort = vertex.constant * limit
        up = (effort - min(vertex.coulomb, loose)) / vertex.inertia
        down = (effort + vertex.coulomb) / vertex.inertia
        rates.append(FastestStep(effort, vertex.inertia, vertex.coulomb, part(up, down)))
    return max(rates, key=lambda one: one.per_root)


def _check_time(
    requirement: tuple[str, float, float], model: Model, shortest: float, slowest: FastestStep
) -> list[str]:
    """Return a note on longer steps, or raise NoSolutionError if the shortest one is too slow.

    `requirement` is the key, its time and the delay before the axis moves [s]; `shortest` is the
    length of the shortest step [rad | m].
    """
    (key, required, delay), bench, axis = requirement, model.bench, model.axis
    unit, effort = si_unit("position", axis), si_unit("effort", axis)
    plant = (
        f"{slowest.effort:.4g} {effort} at its limit, inertia {slowest.inertia:.4g} "
        f"{si_unit('inertia', axis)}, Coulomb friction "
        f"{slowest.coulomb:.4g} {effort}"
    )
    least = delay + slowest.per_root * math.sqrt(shortest)
    if required < least:
        raise NoSolutionError(
            f"{key} of the specification is {required:.4g} s; the drive needs at least "
            f"{least:.4g} s for a step of {shortest:.4g} {unit}, the "
            f"shortest that it can mean ({plant}); raise {key}, take a drive with a higher "
            "actuator.limit, or narrow the "
            "intervals of inertia and coulomb"
        ).at("spec", key)
    longest = ((required - delay) / slowest.per_root) ** 2
    travel = bench.mechanics.travel
    if travel is None or longest >= travel.high - travel.low:
        return []
    return [
        f"{key} of {required:.4g} s: for steps longer than {longest:.4g} {unit} no controller "
        "reaches it; the whole travel takes at least "
        f"{delay + slowest.per_root * math.sqrt(travel.high - travel.low):.4g} s ({plant})"
    ]
