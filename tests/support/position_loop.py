"""The position loop of the minimax trial: a constant controller of order 4 that holds the specified
margin at all 16 vertices."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import tf2ss

from frictool.adapters.model_polytope import polytope
from frictool.plant.generalised_plant import (
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti, tustin
from frictool.plant.parameter_box import corners, enclosing_box
from studies.rigs.clutch_model import clutch_model

LAG, PERIOD = 0.003, 1e-3
WEIGHTS = PlantWeights(template(20.0, 0.5, 2 / 63), 0.1, 0.05)
CLUTCH = polytope(clutch_model())
BOX = enclosing_box(CLUTCH.vertices)
CORNERS = corners(BOX)


def minimax_controller() -> Lti:
    """k (1 + s/z1)(1 + 2 a s/wz + s^2/wz^2)/(s (1 + s/p1)(1 + 2 c s/wp + s^2/wp^2)); k is an
    effort, in N m per rad."""
    k, z1, wz, p1, wp, a, c = (
        0.2294 / CLUTCH.centre.constant,
        16.77,
        68.0,
        197.3,
        2003.0,
        2.151,
        0.659,
    )
    numerator = k * np.polymul([1 / z1, 1.0], [1 / wz**2, 2 * a / wz, 1.0])
    denominator = np.polymul([1.0, 0.0], np.polymul([1 / p1, 1.0], [1 / wp**2, 2 * c / wp, 1.0]))
    return Lti(*tf2ss(numerator, denominator), 0.0)


def plant(period: float = 0.0, delay: int = 0) -> Callable[[AxisRates], GeneralisedPlant]:
    return lambda rates: generalised_plant("position", rates, LAG, WEIGHTS, period, delay)


def corner_loops(controller: Lti, delay: int = 0) -> list[Lti]:
    """At the corners of inertia, constant and viscous; sampled where the controller is."""
    return [plant(controller.period, delay)(corner.rates).closed(controller) for corner in CORNERS]


def sampled(controller: Lti) -> Lti:
    return tustin(controller, PERIOD)
