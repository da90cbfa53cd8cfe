"""The vertices as the text linearises them, beside the exact ones.

    exact         k = K/J, s = sigma_v/J, f = F_c/J
                  (5.48)
    inertia       the same with 1/J replaced by (1 - dJ/J0)/J0, its tangent at the centre; products
                  stay    (5.49), read with its 1/m
    first_order   (p0 + dp - p0 dJ/J0)/J0 for p = K, sigma_v, F_c: affine in the parameters
                  (5.50), with the 1 of A_m in A_0

p0 = centre, dp = p - p0. `first_order` is affine in the parameters. `exact` is affine in the rates
(k, s, f), and every plant of the box is in the hull of its vertices' rates (for one J they fill a
box, and between two J they lie on lines): nothing is lost without the linearisation. The linearised
forms miss 1/J by (dJ/J0)^2 of it: 2.5 % at the ends of table 5.2. What is verified is always the
exact plant.
"""

from __future__ import annotations

from typing import Literal

from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import AxisRates
from frictool.plant.polytope import PlantPoint, Polytope

Form = Literal["exact", "inertia", "first_order"]


def rates_of(point: PlantPoint, centre: PlantPoint, form: Form = "exact") -> AxisRates:
    """The plant at `point` as a polytope around `centre` has it.

    Raises NoSolutionError where the linearisation leaves no positive inertia or drive: its interval
    is too wide to be linearised.
    """
    if form == "exact":
        return point.rates
    nominal = centre.inertia
    deviation = (point.inertia - nominal) / nominal

    def rate(value: float, middle: float) -> float:
        if form == "inertia":
            return value * (1.0 - deviation) / nominal
        return (value - middle * deviation) / nominal

    found = AxisRates(
        rate(point.constant, centre.constant),
        rate(point.viscous, centre.viscous),
        rate(point.coulomb, centre.coulomb),
    )
    if found.drive <= 0.0:
        raise NoSolutionError(
            f"the plant linearised at {point.name} (inertia {point.inertia:.4g}, constant {point.constant:.4g}) has no positive gain: the "
            "intervals are too wide for (5.49)-(5.50); take the exact vertices"
        )
    return found


def vertex_rates(box: Polytope, form: Form = "exact") -> tuple[AxisRates, ...]:
    """`rates_of` every vertex, in their order."""
    return tuple(rates_of(point, box.centre, form) for point in box.vertices)
