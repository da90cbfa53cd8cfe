"""Check before the design for requirements that no controller can meet on this rig.

A rest band is the position error below which the controller switches the drive off. The rest bands
of a design are compared with the encoder step and with the specified static error. The specified
times are compared with the shortest time of a step (plant/time_optimal.py): the drive accelerates
and then brakes at its limit, with its lag and the delay in bench.yaml. The assumptions favour the
controller:

- The axis stops short of the target by static_error and one encoder count.
- The step begins with the backlash open.
- Load, back-EMF and resonances are neglected. If `drive_peak` of the specification is below the
  drive's limit, it replaces the limit, and the largest load over the position helps the drive.
- For the rise time, the axis need not stop, and the drive has no lag.

Method `auto` simulates steps of a known length. The time constant of the slowest plant's speed loop
(`loop_allowance`) is then added to the shortest time.

A specification does not state the length of a step. The drive must therefore manage a step of
length 20 static_error, limited to the range from 20 encoder counts to the travel. If it cannot, the
specification is rejected. A note states the longest step that is possible in the specified time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from msgspec import structs

from frictool.adapters.model_polytope import polytope
from frictool.adapters.shortest_step import driven_axis
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.quantity import PositiveLength, si_unit
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.plant.root_search import sign_change
from frictool.plant.time_optimal import (
    ZONE,
    DrivenAxis,
    StepZone,
    shortest_time,
    time_optimal_response,
)
from frictool.synth.load_disturbance import disturbance

RISE = (0.1, 0.9)  # fractions of the step at which rise_time_s begins and ends
LENGTHS = 20  # bisections in the search for the longest step
LEAST_MARGIN = 0.3  # modulus margin if the specification has none
ANGLES = np.linspace(0.01, math.pi, 2000)  # frequencies times the dead time, rad
ShortestTime = Callable[[DrivenAxis, float], float]  # (axis, length [rad | m]) -> time [s]


class SlowestStep(NamedTuple):
    """Shortest time [s] of a step for the slowest plant of a model, and this plant."""

    time: float
    plant: PlantPoint


def check_feasible(model: Model, spec: Spec, design: Design) -> tuple[str, ...]:
    """Return a note for each specified time that the drive can meet in short steps only.

    Raises FrictoolError if a rest band is below the encoder step or above the specified static
    error, and NoSolutionError if the drive cannot meet a specified time.
    """
    _check_bands(model, spec, design)
    notes = []
    for key, least in (
        ("response_time_95_s", _response(model, spec)),
        ("rise_time_s", _rise),
    ):
        if getattr(spec, key) is not None:
            notes += _check_time(key, spec, least, model)
    return tuple(notes)


def check_played_step(model: Model, spec: Spec, length: float, dead_time: float) -> None:
    """Raise NoSolutionError if a step cannot be completed within the specified response time.

    - length: length of the longest step that the search simulates [rad | m]
    - dead_time: dead time of the speed loop with its fastest filter [s]
    """
    required = spec.response_time_95_s
    if required is None:
        return
    limited, limit = _with_drive_peak(model, spec)
    slowest = slowest_step(limited, _response(model, spec), length)
    allowance = loop_allowance(model, spec.modulus_margin or LEAST_MARGIN, dead_time)
    if required >= slowest.time + allowance:
        return
    raise NoSolutionError(
        f"response_time_95_s: found {required:.4g} s; a step of {length:.4g} "
        f"{si_unit('position', model.axis)} needs up to {slowest.time + allowance:.4g} s "
        f"(drive alone {slowest.time:.4g} s); raise it or {limit}, or shorten steps (--scenario)"
    ).at("spec", "response_time_95_s")


def loop_allowance(model: Model, margin: float, dead_time: float) -> float:
    """Return the time constant [s] of the slowest plant's speed loop.

    The loop gain of the fastest plant is k exp(-s dead_time)/s, where k is determined by the
    modulus margin `margin`. The slowest plant's loop is slower by the ratio of the two plants'
    gains.
    """
    gains = [point.constant / point.inertia for point in polytope(model).vertices]

    def excess(product: float) -> float:
        loop = product * np.exp(-1j * ANGLES) / (1j * ANGLES)
        return float(np.abs(1.0 + loop).min()) - margin

    product = sign_change(excess, float(ANGLES[0]), 0.5 * math.pi)
    return dead_time / product * max(gains) / min(gains)


def _check_bands(model: Model, spec: Spec, design: Design) -> None:
    law = design.position_law
    limiter = design.limiter
    unit = si_unit("position", model.axis)
    step = model.bench.encoder.resolution
    if law is not None and law.band is not None and law.band.value < step:
        raise FrictoolError(
            f"position_law.band: found {law.band.value:.6g} {unit}; allowed: at least the "
            f"encoder's step, {step:.6g} {unit}; write a larger "
            "band, or remove the key for a band of one step"
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
                f"{spec.static_error.value:.6g} {unit}; narrow the band, or widen static_error"
            ).at("design", f"{name}.band")


def _with_drive_peak(model: Model, spec: Spec) -> tuple[Model, str]:
    """Return the model with its drive limit lowered to `drive_peak`, and the key of the limit.

    The key is `drive_peak`, or `actuator.limit` if the model is returned unchanged. First, the
    largest load that depends on the position is added to `drive_peak`, since the load may help the
    drive. The model is unchanged if the sum is not below the drive limit, or if the friction
    depends on the position. It is also unchanged if `drive_peak` does not overcome the friction,
    which synth/least_drive.py checks.
    """
    unchanged = (model, "actuator.limit")
    actuator, peak = model.bench.actuator, spec.drive_peak
    if peak is None or (model.laws is not None and model.laws.position is not None):
        return unchanged
    try:
        load = disturbance(model)
    except NoSolutionError:  # the callers reject this load
        return unchanged
    helping = load.gravity + load.ripple + load.spring
    reduced = peak.value + helping / actuator.constant.interval[0]
    slowest = min(plant.constant * reduced - plant.coulomb for plant in polytope(model).vertices)
    if reduced >= actuator.limit.value or slowest <= 0.0:
        return unchanged
    limit = structs.replace(actuator.limit, value=reduced, low=None, high=None)
    lag = 0.0 if helping > 0.0 else actuator.loop_time_constant_s  # a load acts without lag
    drive = structs.replace(actuator, limit=limit, rms_limit=None, loop_time_constant_s=lag)
    bench = structs.replace(model.bench, actuator=drive)
    return structs.replace(model, bench=bench), "drive_peak"


def resting_error(model: Model, spec: Spec) -> float:
    """Return the largest allowed error at rest [rad | m]: static_error or one encoder count.

    The larger of the two values is returned.
    """
    return max(model.bench.encoder.resolution, _static_error(spec))


def shortest_step(model: Model, spec: Spec) -> float:
    """Return the length [rad | m] of the shortest step to which a response time can apply."""
    travel = model.bench.mechanics.travel
    longest = math.inf if travel is None else travel.high - travel.low
    return min(resting_error(model, spec) / ZONE, longest)


def _static_error(spec: Spec) -> float:
    return 0.0 if spec.static_error is None else float(spec.static_error.value)


def _response(model: Model, spec: Spec) -> ShortestTime:
    bench = model.bench
    count = bench.encoder.resolution

    def least(axis: DrivenAxis, length: float) -> float:
        final = length - min(_static_error(spec), length)
        around = max(ZONE * length, count) + count
        zone = StepZone(final - around, final + around)
        return time_optimal_response(axis, zone, bench.sample_period_s, bench.delay_samples)

    return least


def _rise(axis: DrivenAxis, length: float) -> float:
    at_once = replace(axis, lag=0.0)
    low, high = (shortest_time(at_once, StepZone(share * length, math.inf)) for share in RISE)
    return high - low


def slowest_step(model: Model, least: ShortestTime, length: float) -> SlowestStep:
    """Return the plant that needs the longest time for a step, and this time.

    - least: function from an axis and a length to the shortest time [s]
    - length: step length [rad | m]

    The plants are the vertices of the model; the drive must be able to move each of them
    (synth/load_disturbance.py).
    """
    times = [
        SlowestStep(least(_opened(model, vertex), length), vertex)
        for vertex in polytope(model).vertices
    ]
    return max(times, key=lambda one: one.time)


def _opened(model: Model, vertex: PlantPoint) -> DrivenAxis:
    axis, known = driven_axis(model.bench, vertex), model.bench.mechanics
    if known.backlash is None or known.backlash_coulomb is None:
        return axis
    friction = min(vertex.coulomb, known.backlash_coulomb.value)
    return replace(axis, backlash=known.backlash.interval[1], backlash_coulomb=friction)


def _check_time(key: str, spec: Spec, least: ShortestTime, model: Model) -> list[str]:
    """Return a note on the longest step that the axis can complete in the required time.

    Raises NoSolutionError if even the shortest step takes longer.

    - key: requirement on a time
    - least: function from an axis and a length to the shortest time
    """
    unit = si_unit("position", model.axis)
    required, shortest = getattr(spec, key), shortest_step(model, spec)
    model, limit = _with_drive_peak(model, spec)
    slowest = slowest_step(model, least, shortest)
    if required < slowest.time:
        raise NoSolutionError(
            f"{key}: found {required:.4g} s; the drive needs at least {slowest.time:.4g} s "
            f"even for a step of {shortest:.4g} {unit} "
            f"({_described(slowest.plant, model)}); raise {key} or {limit}"
        ).at("spec", key)
    travel = model.bench.mechanics.travel
    if travel is None:
        return []
    whole = slowest_step(model, least, travel.high - travel.low)
    if required >= whole.time:
        return []
    longest = _longest_step(model, least, required, (shortest, travel.high - travel.low))
    return [
        f"no controller meets {key} {required:.4g} s for steps above {longest:.4g} {unit}; "
        "the whole travel takes at least "
        f"{whole.time:.4g} s ({_described(whole.plant, model)})"
    ]


def _longest_step(
    model: Model, least: ShortestTime, required: float, between: tuple[float, float]
) -> float:
    """Return the length [rad | m] of the longest step that is possible in `required` seconds.

    between: length of a possible step, and length of an impossible step [rad | m].
    """
    possible, impossible = between
    for _ in range(LENGTHS):
        middle = 0.5 * (possible + impossible)
        if slowest_step(model, least, middle).time <= required:
            possible = middle
        else:
            impossible = middle
    return possible


def _described(plant: PlantPoint, model: Model) -> str:
    effort, axis = si_unit("effort", model.axis), driven_axis(model.bench, plant)
    return (
        f"at most {axis.effort:.4g} {effort}, inertia {plant.inertia:.4g} "
        f"{si_unit('inertia', model.axis)}, Coulomb friction {plant.coulomb:.4g} {effort}"
    )
