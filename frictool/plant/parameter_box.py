"""Smallest box of parameters that contains a set of plants, and the corners of a box.

In the linear plant the Coulomb friction is only the scale of the disturbance input w. Its sign does
not change the norm of the loop; bounds therefore use its largest magnitude.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

from frictool.plant.polytope import PlantPoint

Box = Mapping[str, tuple[float, float]]
DYNAMIC = ("inertia", "constant", "viscous")  # parameters that change the axis's dynamics


def enclosing_box(points: Sequence[PlantPoint]) -> dict[str, tuple[float, float]]:
    """Return the smallest interval (low, high) of each parameter that contains all points."""
    return {
        name: (min(getattr(p, name) for p in points), max(getattr(p, name) for p in points))
        for name in (*DYNAMIC, "coulomb")
    }


def largest_coulomb(box: Box) -> float:
    """Return the largest magnitude of the Coulomb friction [N m or N] in the box.

    The friction may be negative if it is the intercept of a tangent (plant/regime_tangents.py).
    """
    return max(abs(value) for value in box["coulomb"])


def moving(box: Box) -> tuple[str, ...]:
    """Return the dynamic parameters (inertia, constant, viscous) that vary in the box."""
    return tuple(name for name in DYNAMIC if box[name][1] > box[name][0])


def corners(box: Box) -> tuple[PlantPoint, ...]:
    """Return the corners of the box, in the order of itertools.product.

    The parameters that `moving` returns differ between corners; the Coulomb friction has the
    largest magnitude in the box.
    """
    ends = [box[name] if name in moving(box) else box[name][:1] for name in DYNAMIC]
    return tuple(
        PlantPoint(f"c{index}", inertia, viscous, largest_coulomb(box), constant)
        for index, (inertia, constant, viscous) in enumerate(product(*ends), start=1)
    )
