"""Complex variable p = scale (s - shift) in which a synthesis is solved, for regions of poles.

    continuous            p = s T              Re p < 0      T scales fast modes to about one
    discrete              p = z                abs(p) < 1
    half-plane of poles   p = (s + decay) T    Re p < 0      Re s < -decay
    disc of poles         p = (s - c)/r        abs(p) < 1    abs(s - c) < r

c and r are centre and radius of a disc, and decay is the least decay rate of the poles. For sampled
plants s stands for z.

If every pole is inside the region, a bound of the gain on the region's boundary also holds on the
imaginary axis or the unit circle (maximum modulus). A single inequality in p therefore guarantees
two properties: every pole is inside the region, and the norm is below its bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti

# relative smallest singular value of [A - pole, B2] below which feedback does not move a pole
UNREACHED = 1e-9


@dataclass(frozen=True)
class PoleHalfPlane:
    """Region Re s < -decay [rad/s] for the poles of a closed loop in continuous time."""

    decay: float


@dataclass(frozen=True)
class PoleDisc:
    """Region abs(s - centre) < radius for the poles of a closed loop.

    The disc lies in the left half-plane (centre and radius in rad/s). For sampled plants, s stands
    for z, and the disc lies in the unit disc.
    """

    centre: float
    radius: float


PoleRegion = PoleHalfPlane | PoleDisc


@dataclass(frozen=True)
class TransformVariable:
    """Complex variable p = scale (s - shift), or scale (z - shift) for sampled plants.

    The region of the poles is abs(p) < 1 if `disc` is True, else Re p < 0.
    """

    shift: float
    scale: float
    disc: bool

    def plant(self, plant: GeneralisedPlant) -> GeneralisedPlant:
        """Return the plant as a function of p; it is sampled (period 1) if the region is a disc."""
        root = np.sqrt(self.scale)
        return replace(
            plant,
            a=self.scale * (plant.a - self.shift * np.eye(len(plant.a))),
            b1=root * plant.b1,
            b2=root * plant.b2,
            c1=root * plant.c1,
            c2=root * plant.c2,
            period=1.0 if self.disc else 0.0,
        )

    def back(self, k: Lti, period: float) -> Lti:
        """Return the controller `k`, a function of p, as a function of s (`period` 0) or z."""
        root = np.sqrt(self.scale)
        return Lti(
            k.a / self.scale + self.shift * np.eye(k.order), k.b / root, k.c / root, k.d, period
        )

    def inside(self, pole: complex) -> bool:
        """Return True if a pole, given in s or z, is inside the region."""
        p = self.scale * (pole - self.shift)
        return abs(p) < 1.0 if self.disc else p.real < 0.0


def frame(plants: Sequence[GeneralisedPlant], region: PoleRegion | None) -> TransformVariable:
    """Return the change of variable that maps the region of poles to a disc or half-plane.

    The image of the region is the unit disc or the left half-plane. If `region` is None, the region
    contains all stable poles. Raises ValueError if the region contains unstable poles, or if it is
    a half-plane and the plants are sampled.
    """
    sampled = plants[0].period > 0.0
    if isinstance(region, PoleDisc):
        reach = abs(region.centre) + region.radius if sampled else region.centre + region.radius
        if region.radius <= 0.0 or reach > (1.0 if sampled else 0.0):
            where = "the unit disc" if sampled else "the left half-plane"
            raise ValueError(
                f"the disc of poles, centre {region.centre:g} and radius {region.radius:g}, is "
                f"not within {where}"
            )
        return TransformVariable(region.centre, 1.0 / region.radius, True)
    if isinstance(region, PoleHalfPlane) and (sampled or region.decay < 0.0):
        raise ValueError(
            "a half-plane of poles needs a plant in continuous time and a decay of 0 rad/s or "
            "more; try a disc"
        )
    if sampled:
        return TransformVariable(0.0, 1.0, True)
    fastest = max(float(np.max(np.abs(np.linalg.eigvals(plant.a)))) for plant in plants)
    return TransformVariable(
        -region.decay if region else 0.0, 1.0 / fastest if fastest else 1.0, False
    )


def refuse_fixed_modes(framed: Sequence[GeneralisedPlant], frame: TransformVariable) -> None:
    """Raise NoSolutionError if a pole lies outside the region and feedback cannot move it.

    An example is the pole of a weight. `framed`: plants as functions of p, the variable of `frame`,
    with states of similar size.
    """
    for plant in framed:
        identity = np.eye(len(plant.a))
        for p in np.linalg.eigvals(plant.a).astype(np.complex128):
            pole = p / frame.scale + frame.shift
            if frame.inside(pole):
                continue
            inner = p * identity - plant.a
            sides = {
                "controllable by the command": np.hstack([inner, plant.b2]),
                "observable in the measurement": np.vstack([inner, plant.c2]),
            }
            for what, side in sides.items():
                values = np.linalg.svd(side, compute_uv=False)
                if values[-1] <= UNREACHED * values[0]:
                    raise NoSolutionError(
                        f"the pole at {pole if pole.imag else pole.real:.4g} is not {what} and is "
                        "outside the requested region: no controller exists; give the weights "
                        "stable poles within the region, or widen the region"
                    )
