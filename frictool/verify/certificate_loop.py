"""Closed loop whose norm or sensitivity a certificate bounds, with the stored coefficients.

generalised_plant.py defines the loop, linear_axis.py the sampled axis. The computational delay is
at the input of the axis.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from frictool.documents.certificate import CertifiedWeights, Filter
from frictool.documents.controller import StateSpace, Velocity

Quantity = Literal["norm", "sensitivity"]
SENSITIVITY = CertifiedWeights(error=Filter(1.0), disturbance=0.0, drive=0.0)  # (5.54)


@dataclass(frozen=True)
class SpeedFeedback:
    """Feedback of the speed: drive = C(z) (F(z) m + position_gain eta), with eta = -position.

    m is minus the measured speed.

    - velocity: settings of the filter F, and source of the speed (differences of positions, or a
      sensor)
    - position_gain: gain [1/s] of the proportional law around the speed loop; 0 if there is no such
      law
    """

    velocity: Velocity
    position_gain: float


@dataclass(frozen=True)
class CertificateLoop:
    """Properties of a closed loop that are the same for all plants.

    - controller: linear controller
    - controlled: quantity whose error is weighted
    - delay: computational delay [samples]
    - lag: time constant of the drive [s]
    - period: sample period [s]
    - sections: second-order sections b0 b1 b2 a0 a1 a2 with a0 = 1, which replace the matrices of
      `controller` if the target hardware runs sections
    - speed: feedback of the speed; None if eta is the controller's only input
    """

    controller: StateSpace
    controlled: Literal["position", "speed"]
    delay: int
    lag: float
    period: float
    weights: CertifiedWeights
    sections: tuple[tuple[float, ...], ...] = ()
    speed: SpeedFeedback | None = None

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Return the quantities that a certificate bounds: norm and sensitivity.

        The norm is not defined for a loop that feeds back the speed.
        """
        return ("norm", "sensitivity") if self.speed is None else ("sensitivity",)


def quantity_loops(loop: CertificateLoop, of: Quantity) -> tuple[CertificateLoop, ...]:
    """Return the loops whose largest H-infinity norm is the quantity `of`: norm or sensitivity.

    For the norm, the result is `loop`. For the sensitivity, the result contains the unweighted
    loops: the position or speed loop and, with a proportional law, also the outer loop.
    """
    if of == "norm":
        return (loop,)
    unweighted = replace(loop, controlled="position", weights=SENSITIVITY)
    if loop.speed is None or not loop.speed.position_gain:
        return (unweighted,)
    return replace(unweighted, speed=replace(loop.speed, position_gain=0.0)), unweighted
