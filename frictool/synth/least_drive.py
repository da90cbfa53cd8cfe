"""Least drive that moves an axis through the steps of a test: a bound for every controller.

At the start, the axis rests at p_0. At the end of step j it is within `error` of its target p_j.
The drive is at most D, and the load is at most L and conservative. Two bounds follow:

    start     K D > B - L                               K: drive constant, B: breakaway
    energy    K D path >= F path - L distance           F: Coulomb friction

path is the sum of |p_k - p_(k-1)| up to step j, and distance is |p_j - p_0|. The drive supplies the
work of the friction, less the energy that the load releases between the two positions. After a step
forward and back, the distance is almost 0. The bound allows for `error` at each target, which
shortens the path and lengthens the distance. Without a specified static error, the axis must move,
but need not reach its targets. The second bound then uses distance <= path.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from frictool.documents.model import Model
from frictool.documents.quantity import drive_dimension, si_unit
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth.load_disturbance import disturbance

LABELS = {"coulomb": "Coulomb friction", "breakaway": "breakaway"}
MOVING = ("response_time_95_s", "rise_time_s")  # requirements that an axis at rest violates


class LeastDrive(NamedTuple):
    """Largest drive that is too weak for a test, and the friction that makes it too weak.

    - drive: drive signal, A | V; 0 if there is no bound
    - parameter: name of the friction, `coulomb` or `breakaway`
    - friction: value of this parameter, N m | N
    - constant: drive constant, N m/A or N/A | N m/V or N/V
    """

    drive: float
    parameter: str
    friction: float
    constant: float


def check_least_drive(
    model: Model, spec: Spec, scenario: Scenario, plants: Sequence[Mapping[str, float]]
) -> None:
    """Raise NoSolutionError if the drive cannot move a plant through the steps of a test.

    The largest drive is the drive's limit, or `drive_peak` of the specification if that is smaller.

    Parameters
    ----------
    model, spec
        Model of the axis, and requirements.
    scenario
        Steps of the test.
    plants
        Parameters of each plant by name, SI; plants without values are not checked.
    """
    limit, peak = model.bench.actuator.limit.value, spec.drive_peak
    low_peak = peak is not None and peak.value < limit
    largest = peak.value if low_peak else limit
    least = least_drive(model, spec, scenario, plants)
    if largest > least.drive:
        return
    key = "drive_peak" if low_peak else "actuator.limit"
    effort = si_unit("effort", model.axis)
    unit = si_unit(drive_dimension(model.bench.actuator.drive, constant=False), model.axis)
    friction = f"{LABELS[least.parameter]} of {least.friction:.4g} {effort}"
    error = NoSolutionError(
        f"{key}: found {largest:.4g} {unit}; allowed: above {least.drive:.4g} {unit}, to overcome "
        f"a {friction} with {least.constant:.4g} {effort}/{unit}; raise {key}, or narrow "
        f"mechanics.{least.parameter}"
    )
    raise error.at("spec", key) if low_peak else error.at("model", f"bench.{key}")


def least_drive(
    model: Model, spec: Spec, scenario: Scenario, plants: Sequence[Mapping[str, float]]
) -> LeastDrive:
    """Return the largest drive that is too weak to move one of the plants through the test.

    `check_least_drive` describes the parameters. There is no bound (drive 0) if the friction may be
    less than the Coulomb friction. This is possible if the friction depends on the position, or if
    the model has presliding or a backlash. There is also no bound if the scenario contains
    disturbances, drifts, a temperature, sensor faults or commands. If the breakaway depends on the
    time at rest, its bound is left out.
    """
    targets = _targets(spec, scenario)
    share = _load_share(model, spec, targets)
    if share is None or _unbounded(model, scenario):
        return LeastDrive(0.0, "coulomb", 0.0, math.nan)
    load = disturbance(model).total
    bounds = [LeastDrive(0.0, "coulomb", 0.0, math.nan)]
    for coulomb, breakaway, constant in _frictions(model, plants):
        moving = (coulomb - share * load) / constant
        bounds.append(LeastDrive(moving, "coulomb", coulomb, constant))
        if model.laws is None or model.laws.dwell is None:
            starting = (breakaway - load) / constant
            bounds.append(LeastDrive(starting, "breakaway", breakaway, constant))
    return max(bounds)


def _unbounded(model: Model, scenario: Scenario) -> bool:
    laws = model.laws
    return bool(
        model.bench.mechanics.backlash is not None
        or model.presliding is not None
        or (laws is not None and laws.position is not None)
        or scenario.disturbances
        or scenario.drifts is not None
        or scenario.temperature is not None
        or scenario.sensor_faults
        or scenario.commands
    )


def _frictions(
    model: Model, plants: Sequence[Mapping[str, float]]
) -> Iterator[tuple[float, float, float]]:
    """Yield friction levels [N m | N] and drive constant of each plant that has values.

    The levels are Coulomb friction and breakaway, each the smaller of both directions.
    """
    today, backward = model.parameters, model.laws.backward if model.laws is not None else None
    opposite = [backward.coulomb, backward.breakaway] if backward is not None else [None, None]
    coulomb, breakaway = (
        (one.value, one.value if other is None else other.value)
        for one, other in zip((today.coulomb, today.breakaway), opposite, strict=True)
    )
    for plant in plants:
        if not plant or min(coulomb) <= 0.0 or breakaway[0] <= 0.0:
            continue
        # the Coulomb friction of a plant is the mean of both directions (friction_levels.py)
        factor = plant["coulomb"] / (0.5 * sum(coulomb))
        start = plant.get("breakaway", factor * breakaway[0]) * min(
            1.0, breakaway[1] / breakaway[0]
        )
        yield factor * min(coulomb), start, plant["constant"]


def _targets(spec: Spec, scenario: Scenario) -> list[float]:
    """Return the start and the targets of the steps, [start, targets ...] [rad | m].

    Steps of kind `hold_s` have no target. The list ends before the first step that has no reference
    or is shorter than the specified response time, because a report cannot judge this step.
    """
    assert scenario.start is not None
    targets = [scenario.start.value]
    for step in scenario.steps:
        if step.hold_s is not None:
            continue
        if step.reference is None or step.seconds < (spec.response_time_95_s or 0.0):
            break
        targets.append(step.reference.value)
    return targets


def _load_share(model: Model, spec: Spec, targets: Sequence[float]) -> float | None:
    """Return the least quotient distance/path, as defined in the module docstring.

    The result is None if the specification requires no motion.
    """
    count = model.bench.encoder.resolution
    steps = [abs(after - before) for before, after in pairwise(targets)]
    moves = any(getattr(spec, key) is not None for key in MOVING)
    shares = [1.0] if moves and max(steps, default=0.0) > count else []
    if spec.static_error is not None:
        error, path = spec.static_error.value + count, 0.0
        for target, step in zip(targets[1:], steps, strict=True):
            path += max(0.0, step - 2.0 * error)
            if path > 0.0:
                shares.append(min(1.0, (abs(target - targets[0]) + error) / path))
    return min(shares, default=None)
