"""Shortest step response that the drive of a rig allows, for its fastest and slowest plants."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.plant.polytope import PlantPoint
from frictool.plant.time_optimal import DrivenAxis, step_zone, time_optimal_response


class ShortestStepTimes(NamedTuple):
    """Lower bounds [s] of the time to 95 % of a step, for every controller with the same drive.

    - length: length of the step [rad | m]
    - best, worst: bounds for the fastest and for the slowest plant; infinite if the drive cannot
      overcome the friction
    """

    length: float
    best: float
    worst: float

    def words(self, bench: Bench) -> str:
        """Return a text with the length of the step and the bound for the slowest plant."""
        step = f"a step of {self.length:.4g} {si_unit('position', bench.axis)}"
        if math.isinf(self.worst):
            return f"at the drive's limit, {step} is not possible on the slowest plant"
        return (
            f"at the drive's limit, {step} takes at least {1e3 * self.worst:.4g} ms on the "
            "slowest plant"
        )


def driven_axis(bench: Bench, plant: PlantPoint) -> DrivenAxis:
    """Return a plant with the drive of `bench` at its limit, without backlash."""
    actuator = bench.actuator
    return DrivenAxis(
        plant.inertia,
        plant.viscous,
        plant.coulomb,
        plant.constant * actuator.limit.value,
        actuator.loop_time_constant_s,
    )


def shortest_step_times(
    bench: Bench,
    plants: Sequence[PlantPoint],
    length: float,
    overshoot: float | None = None,
) -> ShortestStepTimes:
    """Return the shortest response times that any controller can reach on the bench.

    Parameters
    ----------
    bench
        Drive with its limit and lag, sample period, delay, and encoder.
    plants
        Plants, at least one: the vertices of a model, of a controller, or of intervals in
        bench.yaml.
    length
        Length of the step, rad | m, above 0.
    overshoot
        Largest overshoot relative to the length; None to allow 5 % of the length, or one encoder
        step if this is larger.

    Returns
    -------
    ShortestStepTimes
        The times of the fastest and of the slowest plant (plant/time_optimal.py). The backlash is
        assumed to be closed when the step begins.
    """
    zone = step_zone(length, bench.encoder.resolution, overshoot)
    times = [
        time_optimal_response(
            driven_axis(bench, plant), zone, bench.sample_period_s, bench.delay_samples
        )
        for plant in plants
    ]
    return ShortestStepTimes(length, min(times), max(times))
