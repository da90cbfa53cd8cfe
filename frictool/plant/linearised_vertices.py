"""Rates of the plant at the vertices of the polytope, exact or linearised.

    exact         k = K/J, s = sigma_v/J, f = F_c/J                                       (5.48)
    inertia       as exact, but 1/J is replaced by its tangent at the centre,
                  (1 - dJ/J0)/J0; products of deviations from the centre are kept         (5.49)
    first_order   (p0 + dp - p0 dJ/J0)/J0 for p = K, sigma_v, F_c                         (5.50)

linear_axis.py defines the rates k, s, f and the parameters K, J, sigma_v, F_c. p0 is the value at
the centre and dp = p - p0. Two misprints of the thesis are corrected: (5.49) lacks a factor 1/m,
and the 1 in A_m of (5.50) belongs in A_0.

`first_order` is affine in the parameters, and `exact` is affine in the rates (k, s, f). For a fixed
J each rate fills an interval, and all rates together fill a box. As J varies, each corner of the
box moves along a straight line. The hull of the exact vertices therefore contains every plant with
parameters in the intervals, without approximation. The linearised forms have a relative error of
(dJ/J0)^2 in 1/J, 2.5 % at the ends of table 5.2. Verification always uses the exact plant.
"""

from __future__ import annotations

from typing import Literal

from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import AxisRates
from frictool.plant.polytope import PlantPoint, Polytope

Form = Literal["exact", "inertia", "first_order"]


def rates_of(point: PlantPoint, centre: PlantPoint, form: Form = "exact") -> AxisRates:
    """Return the rates of the plant at `point` in a polytope around `centre`.

    form: exact, inertia or first_order (module docstring). Raises NoSolutionError if the intervals
    are so wide that the linearised gain k = K/J is not positive.
    """
    if form == "exact":
        return point.rates
    nominal = centre.inertia
    deviation = (point.inertia - nominal) / nominal

    def rate(value: float, middle: float) -> float:
        if form == "inertia":
            return value * (1.0 - deviation) / nominal
        return (value - middle * deviation) / nominal

    rates = AxisRates(
        rate(point.constant, centre.constant),
        rate(point.viscous, centre.viscous),
        rate(point.coulomb, centre.coulomb),
    )
    if rates.drive <= 0.0:
        raise NoSolutionError(
            f"the plant linearised at {point.name} (inertia {point.inertia:.4g}, "
            f"constant {point.constant:.4g}) has no positive gain: the "
            "intervals are too wide for linearised vertices; write vertices: exact"
        )
    return rates


def vertex_rates(box: Polytope, form: Form = "exact") -> tuple[AxisRates, ...]:
    """Return the rates of the plant at every vertex, in the order of the polytope's vertices."""
    return tuple(rates_of(point, box.centre, form) for point in box.vertices)
