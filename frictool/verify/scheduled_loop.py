"""Norm and margin of a scheduled controller, interpolated between the corners (thesis 5.64).

The matrices of the controller are weighted sums of the matrices of the corners (thesis 5.46).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.adapters.state_space import read_state_space
from frictool.documents.controller import Corner
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.plant.parameter_box import enclosing_box
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import smallest
from frictool.verify.interior_search import interior_points
from frictool.verify.speed_loop import check_loop, performance

POINTS = 100  # plants between the corners
SEED = 2


@dataclass(frozen=True)
class ScheduledFigures:
    """Largest norm `gamma` and smallest modulus margin of a scheduled loop.

    The margin is 0 if a loop is unstable.

    - at: plant with the smallest margin
    - points: number of plants between the corners
    """

    gamma: float
    modulus_margin: float
    points: int
    at: PlantPoint


def scheduled_figures(
    corners: Sequence[Corner],
    names: Sequence[str],
    plant: Callable[[AxisRates], GeneralisedPlant],
    lag: float,
    delay: int,
    period: float,
) -> ScheduledFigures:
    """Return the worst norm and margin of a scheduled controller, at and between the corners.

    - corners: controllers at the corners
    - names: scheduled parameters, for which the controller is interpolated at each plant
    - plant: function from AxisRates (parameters divided by the inertia) to the weighted plant
    - lag: time constant of the drive [s]
    - delay: computational delay [samples]
    - period: sample period [s]
    """
    controllers = [read_state_space(corner.discrete, period) for corner in corners]
    plants = [
        PlantPoint(f"corner {k}", one.inertia, one.viscous, one.coulomb, one.constant)
        for k, one in enumerate(corners)
    ]
    points = (*plants, *interior_points(enclosing_box(plants), POINTS, SEED))
    gamma = 0.0
    margins = []
    for point in points:
        k = interpolate_controller(controllers, weights(corners, names, point))
        check = check_loop(k, point.rates, lag, delay)
        margins.append(check.modulus_margin if check.stable else 0.0)
        gamma = max(gamma, performance(k, plant(point.rates)))
    margin, worst = smallest(margins)
    return ScheduledFigures(gamma, margin, POINTS, points[worst])


def weights(
    corners: Sequence[Corner | PlantPoint], names: Sequence[str], point: PlantPoint
) -> NDArray[np.float64]:
    """Return the weights alpha_i (k,) of the corners (thesis 5.46), nonnegative with sum 1.

    alpha_i is a product with one factor per parameter: the distance to the opposite end of the
    interval, divided by the width of the interval. A parameter outside its interval is replaced by
    the nearer end; an interval of width zero contributes no factor.
    """
    shares = np.ones(len(corners))
    for name in names:
        values = np.array([getattr(corner, name) for corner in corners])
        low, high = float(values.min()), float(values.max())
        if high > low:
            share = (min(max(getattr(point, name), low), high) - low) / (high - low)
            shares *= np.where(values == high, share, 1.0 - share)
    return shares


def interpolate_controller(controllers: Sequence[Lti], alpha: NDArray[np.float64]) -> Lti:
    """Return the sum of the controllers' matrices with the weights `alpha` (thesis 5.64)."""
    a, b, c, d = (
        sum(
            (x * getattr(k, part) for x, k in zip(alpha, controllers, strict=True)),
            start=np.zeros(()),
        )
        for part in "abcd"
    )
    return Lti(a, b, c, d, controllers[0].period)
