"""Sampled speed loop in physical units, from the coefficients that run on the target hardware.

eta = s - position               s: integral of the speed reference, outside the loop
u = C(z) eta                     the drive, applied `delay` samples later
L(z) = C(z) P(z) z^-delay        the loop gain; P from u to the position
S = 1/(1 + L)                    the sensitivity, from s to s - position
min |1 + L| = 1/max |S|          the modulus margin: distance of the Nyquist curve
                                 from -1, along the unit circle (thesis 5.57)
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
    """Spectral radius and modulus margin of a loop with one delay; margin 0 if it is unstable."""

    delay_samples: int
    spectral_radius: float
    modulus_margin: float

    @property
    def stable(self) -> bool:
        """Return True if every closed-loop pole is inside the unit circle."""
        return self.spectral_radius < 1.0


def is_required(checked: int, delay: int) -> bool:
    """Return True if loops must be stable at a delay of `checked` samples.

    Loops must be stable at `delay`, the delay in bench.yaml, and at longer delays. A loop that is
    unstable at a shorter delay is reported, but allowed.
    """
    return checked >= delay


def closed_loop(controller: Lti, rates: AxisRates, lag: float, delay_samples: int) -> Lti:
    """Return the sensitivity with one plant: the system from s to s - position.

    s is the integral of the speed reference.

    - lag: time constant of the drive [s]
    """
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
    """Return the spectral radius and the modulus margin of the loop with one plant.

    lag: time constant of the drive [s].
    """
    loop = closed_loop(controller, rates, lag, delay_samples)
    return LoopCheck(delay_samples, spectral_radius(loop.a), 1.0 / norm(loop)[0])


def performance(controller: Lti, plant: GeneralisedPlant) -> float:
    """Return the H-infinity norm of the generalised plant with the controller; inf if unstable.

    Generalised plant and controller are both continuous, or both sampled.
    """
    return norm(plant.closed(controller))[0]
