"""The sampled speed loop, rebuilt in physical units from the coefficients that run on the target.
No solver takes part.

eta = s - position (s = integral of the speed reference, outside the loop);  drive u = C(z) eta,
applied `delay` samples later. Loop gain L(z) = C(z) P(z) z^-delay,  P from u to the position.
Sensitivity S = 1/(1 + L): from s to s - position. Modulus margin = min |1 + L| over the unit circle
= 1/max |S|, the distance of the Nyquist curve from -1 (5.57).
"""

from __future__ import annotations

from dataclasses import dataclass

from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.plant.lti import Lti, delay
from frictool.verify.hinf_norm import norm, spectral_radius


@dataclass(frozen=True)
class LoopCheck:
    """Spectral radius of the closed loop (stable below 1) and modulus margin (0 when unstable) at
    one computational delay."""

    delay_samples: int
    spectral_radius: float
    modulus_margin: float

    @property
    def stable(self) -> bool:
        """Whether every closed-loop pole is inside the unit circle."""
        return self.spectral_radius < 1.0


def closed_loop(controller: Lti, rates: AxisRates, lag: float, delay_samples: int) -> Lti:
    """From s to s - position around one plant: its sensitivity."""
    period = controller.period
    blocks = {
        "controller": DiagramBlock(controller, ("error",), ("u",)),
        "delay": DiagramBlock(delay(delay_samples, period), ("u",), ("command",)),
        "axis": linear_axis(rates, lag, period),
    }
    nothing: dict[str, float] = {}
    sums = {
        "speed_reference": nothing,
        "friction": nothing,
        "uncertain_effort": nothing,
        "error": {"s": 1.0, "eta": 1.0},
    }
    return connect(blocks, sums, ("s",), ("error",))


def check_loop(controller: Lti, rates: AxisRates, lag: float, delay_samples: int) -> LoopCheck:
    """Stability and modulus margin of the loop around one plant."""
    loop = closed_loop(controller, rates, lag, delay_samples)
    return LoopCheck(delay_samples, spectral_radius(loop.a), 1.0 / norm(loop)[0])


def performance(controller: Lti, plant: GeneralisedPlant) -> float:
    """H-infinity norm from w to z of the generalised plant closed by the controller, in their
    domain; inf where that is unstable."""
    return norm(plant.closed(controller))[0]
