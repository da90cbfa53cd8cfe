"""Search for a controller by the judge alone, to find out which actuators have a solution.

The controllers are those of cascade.c. A candidate is a point in the unit cube; RANGES gives the
meaning of its coordinates, relative to the actuator. A candidate with too small a modulus margin is
slowed down until it has the margin. A third of the candidates are random; the others are near the
best ones. A candidate is simulated on a few extreme plants. If it meets the specification there, it
is simulated on all plants, and a plant on which it fails is added to the extreme ones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictool.typing import ComplexVector, Vector
from studies.actuators.drawing import CORNERS, Actuator, Plant
from studies.actuators.judge import Verdict, judge, limits, plant_figures
from studies.actuators.margin import MOTION, POSITION, cascade_margin, responses, sampled_axis
from studies.actuators.native import cascade

CANDIDATES = 300
RANDOM = 100  # candidates that are drawn at random
KEPT = 6  # best candidates near which others are drawn
SLOWER = 0.85  # factor on the bandwidth of a candidate without the margin
SLOWEST = 30
ANGLES = np.geomspace(1e-4 * math.pi, math.pi, 250)  # angles of the quick margin [rad per sample]
RESERVE = 1.01  # factor on the margin that the quick margin must reach
MISSED = 0.01  # added to the violation of a candidate that fails on plants that are not extreme
JOINING = 3  # plants that join the extreme ones after such a candidate

# low and high end of each coordinate; all but the damping on a logarithmic scale
RANGES = {
    "bandwidth": (0.05, 1.0),  # bandwidth of the speed loop, times the loop's delay
    "integral": (0.01, 0.6),  # rate of the integral, divided by the bandwidth
    "gain": (0.08, 0.8),  # gain of the position law, divided by the bandwidth
    "low_pass": (1.5, 20.0),  # low-pass of the speed, divided by the bandwidth
    "braking": (0.15, 1.0),  # divided by the deceleration at full drive with the least friction
    "prefilter": (4.0, 60.0),  # natural frequency, times the response time
    "damping": (0.7, 1.2),
    "band": (0.1, 1.0),  # divided by the static error
    "settled": (0.01, 1.0),  # speed of the prefilter, divided by step/response time
    "rest": (0.01, 2.0),  # speed, divided by step/response time
}


@dataclass(frozen=True)
class Solution:
    """Result of the search: the controller that meets all requirements, and its verdict."""

    solved: bool
    candidates: int
    parameters: tuple[float, ...]
    verdict: Verdict | None


def search(actuator: Actuator, plants: Sequence[Plant], candidates: int = CANDIDATES) -> Solution:
    """Return the first controller that meets all requirements and the margin on all plants."""
    rng = np.random.default_rng(0)
    loops = _QuickMargin(actuator, plants)
    active = _extreme(plants)
    tried: list[tuple[float, Vector]] = []
    for number in range(candidates):
        point = _candidate(rng, tried, number)
        parameters = loops.with_margin(point)
        if parameters is None:
            tried.append((math.inf, point))
            continue
        violation = _violation(actuator, parameters, active)
        tried.append((violation, point))
        if violation > 0.0:
            continue
        margins = [cascade_margin(actuator, plant, parameters) for plant in plants]
        verdict = judge(actuator, cascade(parameters), plants, margins)
        if verdict.all_met:
            return Solution(True, number + 1, tuple(parameters.tolist()), verdict)
        failed = [p for p, good in zip(plants, verdict.plants, strict=True) if not good]
        active += [plant for plant in failed if plant not in active][:JOINING]
        tried[-1] = (_violation(actuator, parameters, active) + MISSED, point)
    return Solution(False, candidates, (), None)


def cascade_parameters(actuator: Actuator, values: dict[str, float]) -> Vector:
    """Return the first fields of cascade.c's record for values in the units of RANGES."""
    delay = actuator.period * (actuator.delay + 1.0) + actuator.lag
    bandwidth = values["bandwidth"] / delay
    inertia = math.sqrt(actuator.inertia.low * actuator.inertia.high)
    proportional = inertia * bandwidth / actuator.constant.value
    deceleration = (
        actuator.constant.low * actuator.limit + actuator.coulomb.low
    ) / actuator.inertia.high
    speed = actuator.amplitude / actuator.response
    return np.array(
        [
            actuator.period,
            actuator.limit,
            values["prefilter"] / actuator.response,
            values["damping"],
            values["gain"] * bandwidth,
            values["braking"] * deceleration,
            proportional,
            proportional * values["integral"] * bandwidth,
            1.0 - math.exp(-values["low_pass"] * bandwidth * actuator.period),
            values["band"] * actuator.static_error,
            values["settled"] * speed,
            values["rest"] * speed,
        ]
    )


class _QuickMargin:
    """Least |1 + L| at ANGLES over the corners of inertia, viscous friction and constant."""

    def __init__(self, actuator: Actuator, plants: Sequence[Plant]) -> None:
        self._actuator = actuator
        corners = {(plant.inertia, plant.viscous, plant.constant): plant for plant in plants}
        ends = actuator.inertia[1:], actuator.viscous[1:], actuator.constant[1:]
        extreme = [
            plant
            for key, plant in corners.items()
            if all(value in pair for value, pair in zip(key, ends, strict=True))
        ]
        axes = [responses(sampled_axis(actuator, plant), ANGLES) for plant in extreme]
        self._positions = np.array([axis[POSITION] for axis in axes])
        self._motions = np.array([axis[MOTION] for axis in axes])
        self._circle: ComplexVector = np.exp(1j * ANGLES)

    def with_margin(self, point: Vector) -> Vector | None:
        """Return the parameters of a candidate, slowed down to the margin; None if impossible."""
        values = _values(point)
        for _ in range(SLOWEST):
            parameters = cascade_parameters(self._actuator, values)
            if self._least(parameters) >= RESERVE * self._actuator.margin:
                return parameters
            values["bandwidth"] *= SLOWER
        return None

    def _least(self, parameters: Vector) -> float:
        _, _, _, _, gain, _, proportional, integral, low_pass, *_ = parameters
        period, z = self._actuator.period, self._circle
        pi = proportional + integral * period / (z - 1.0)
        seen = 0.5 * low_pass * (z + 1.0) / (z - 1.0 + low_pass) / period
        inner = pi * seen * self._motions
        outer = inner + pi * gain * self._positions
        return float(min(np.abs(1.0 + inner).min(), np.abs(1.0 + outer).min()))


def _candidate(
    rng: np.random.Generator, tried: Sequence[tuple[float, Vector]], number: int
) -> Vector:
    """Return a point of the unit cube: at random, or near one of the best candidates."""
    if number < RANDOM:
        return rng.random(len(RANGES))
    best = sorted(tried, key=lambda one: one[0])[:KEPT]
    _, point = best[int(rng.integers(len(best)))]
    width = 0.25 * 0.1 ** ((number - RANDOM) / CANDIDATES)
    changed = rng.random(len(RANGES)) < 0.5
    moved = np.where(changed, point + width * rng.standard_normal(len(RANGES)), point)
    return np.asarray(np.clip(moved, 0.0, 1.0))


def _values(point: Vector) -> dict[str, float]:
    ends = zip(RANGES.items(), point.tolist(), strict=True)
    return {name: low * (high / low) ** share for (name, (low, high)), share in ends}


def _extreme(plants: Sequence[Plant]) -> list[Plant]:
    """Return the nominal plant and extreme corners, such as the slowest and the fastest one."""
    nominal, corners = plants[0], plants[1 : 1 + CORNERS]

    def corner(*signs: int) -> Plant:
        return max(
            corners,
            key=lambda plant: sum(
                sign * value / reference if reference else 0.0
                for sign, value, reference in zip(signs, plant[:4], nominal[:4], strict=True)
            ),
        )

    return [
        corner(1, 1, 1, -1),
        corner(-1, -1, -1, 1),
        corner(1, -1, -1, 1),
        corner(1, -1, -1, -1),
        corner(-1, 1, 1, -1),
        nominal,
    ]


def _violation(actuator: Actuator, parameters: Vector, plants: Sequence[Plant]) -> float:
    """Return the sum of all relative excesses over limits, each at most 1; 0 if all are met."""
    limit, controller = limits(actuator)[:-1], cascade(parameters)
    total = 0.0
    for plant in plants:
        excess = plant_figures(actuator, controller, plant) / limit - 1.0
        total += float(np.clip(excess - 1e-9, 0.0, 1.0).sum())
    return total
