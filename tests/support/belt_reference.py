"""Two pulleys and an elastic belt: the transfers of thesis 2.1.5, derived from the free bodies of
figure 2.5.

    J_A w_A' = u - F        J_B w_B' = F        F = K_r (theta_A - theta_B) + K_v (w_A - w_B)
                            pulleys of radius 1

The second entry of the last row of (2.6) has the wrong sign, and the denominator of (2.7) does not
follow from either. Rightly:

    theta_B/u = (K_v s + K_r) / (s^2 (J_A J_B s^2 + (J_A + J_B) (K_v s + K_r)))   (2.7)
    K_v -> 0:    1 / (J_A J_B/K_r s^4 + (J_A + J_B) s^2)
                 (2.8)
    K_r -> oo:   1 / ((J_A + J_B) s^2)
                 (2.9)
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from frictool.adapters.mechanism.assembly import assemble
from frictool.typing import ComplexVector, Vector
from tests.support.mechanism_text import mechanism


@dataclass(frozen=True)
class Belt:
    """J_A, J_B [kg m2]; K_r [N m/rad], K_v [N m s/rad] of pulleys of equal radius."""

    inertia_a: float
    inertia_b: float
    stiffness: float
    damping: float

    def transfer(self, s: ComplexVector) -> ComplexVector:
        """theta_B/u [rad/(N m)], (2.7) as it follows."""
        link = self.damping * s + self.stiffness
        return np.asarray(
            link
            / (
                s**2
                * (
                    self.inertia_a * self.inertia_b * s**2
                    + (self.inertia_a + self.inertia_b) * link
                )
            )
        )

    def undamped(self, s: ComplexVector) -> ComplexVector:
        """(2.8)"""
        return np.asarray(
            1.0
            / (
                self.inertia_a * self.inertia_b / self.stiffness * s**4
                + (self.inertia_a + self.inertia_b) * s**2
            )
        )

    def rigid(self, s: ComplexVector) -> ComplexVector:
        """(2.9)"""
        return np.asarray(1.0 / ((self.inertia_a + self.inertia_b) * s**2))

    def step(self, times: Vector) -> Vector:
        """theta_B [rad] at `times` after a torque of 1 N m from rest: the rigid motion and the
        belt's decaying oscillation."""
        whole = self.inertia_a + self.inertia_b
        # stretch e = theta_A - theta_B: e'' + c e' + k e = 1/J_A
        c, k = (
            one * whole / (self.inertia_a * self.inertia_b)
            for one in (self.damping, self.stiffness)
        )
        roots = np.roots([1.0, c, k]).astype(complex)
        rest = 1.0 / (self.inertia_a * k)
        first = rest * roots[1] / (roots[0] - roots[1])
        second = -rest - first
        stretch = rest + np.real(
            first * np.exp(roots[0] * times) + second * np.exp(roots[1] * times)
        )
        return 0.5 * times**2 / whole - self.inertia_a / whole * stretch


BELT = """
format: mechanism/1
name: belt
blocks:
  a: {{inertia: {{value: {a!r}, unit: kg m^2}}}}
  b: {{inertia: {{value: {b!r}, unit: kg m^2}}}}
links:
  belt:
    kind: belt
    between: [a, b]
    radius_a: {{value: {radius_a!r}, unit: m}}
    radius_b: {{value: {radius_b!r}, unit: m}}
    compliance: {{stiffness: {{value: {k!r}, unit: N/m}}, damping: {{value: {c!r}, unit: N s/m}}}}
sources:
  torque: {{on: a, drive: effort}}
sensors:
  out: {{on: b}}
"""


def belt(
    a: float,
    b: float,
    k: float = math.inf,
    c: float = 0.0,
    radius_a: float = 1.0,
    radius_b: float = 1.0,
):
    """The belt as a mechanism, put together; without compliance for k = inf."""
    text = BELT if math.isfinite(k) else re.sub(r" *compliance:.*\n", "", BELT)
    return assemble(
        mechanism(text.format(a=a, b=b, k=k, c=c, radius_a=radius_a, radius_b=radius_b))
    )
