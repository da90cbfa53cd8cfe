"""Bandwidth of a reduction for a controller: ten times the highest crossover frequency."""

from __future__ import annotations

import math

from frictool.documents.controller import Controller
from frictool.errors import NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.verify.feedback_loops import feedbacks_of, open_loop
from frictool.verify.margins import loop_margins

ABOVE = 10.0  # bandwidth relative to the crossover frequency


def bandwidth_of(controller: Controller) -> float:
    """Return ten times the highest crossover frequency of the controller's loops [rad/s].

    Raises NoSolutionError if no loop has a crossover.
    """
    lag = controller.bench.actuator.loop_time_constant_s
    frequencies = []
    for vertex in controller.verified.vertices:
        point = PlantPoint(
            vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant
        )
        frequencies += [
            loop_margins(open_loop(loop, point.rates, lag, controller.delay_samples)).crossing
            for loop in feedbacks_of(controller)
        ]
    crossings = [one for one in frequencies if math.isfinite(one)]
    if not crossings:
        raise NoSolutionError(
            f"{controller.name}: no loop has a crossover frequency (gain 1), "
            "which determines the bandwidth; give --bandwidth"
        )
    return ABOVE * max(crossings)
