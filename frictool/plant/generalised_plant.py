"""Generalised plants for synthesis, continuous or sampled (figures 5.11, 5.25, annex C's figure 5).

    structure        error e         reference                     measured
    position (5.11)  s - x           s                             s - x + noise
    speed (5.25)     v_c - v         v_c, with s its integral      s - x + noise

    inputs w   reference; friction times W1; noise through W4; w_Delta of an uncertainty channel
    outputs z  W2 e; W3 i; and, for each weight that exists, W_u u; W_eta eta; W5 z_Delta

s and x are reference and position, v_c and v reference and actual value of the speed, i is the
drive after its lag, and u the commanded drive. W1 to W5, W_u and W_eta are weights
(`PlantWeights`).

A sampled plant includes the computational delay. Both structures measure eta = s - x, so that the
controller has the same input in both structures. The weights are discretised by Tustin's method.
Without the weight W_u, as in the thesis, D12 is 0 and the optimum is not attained: one encoder
count causes a drive of hundreds of times the drive limit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.linear_axis import INPUTS, OUTPUTS, AxisRates, linear_axis
from frictool.plant.lti import Lti, delay, gain, tustin
from frictool.typing import Matrix

Controlled = Literal["position", "speed"]


@dataclass(frozen=True)
class FirstOrderWeight:
    """Weight W(s) = gain (s/zero + 1)/(s/pole + 1).

    - zero, pole: angular frequencies [rad/s]; inf if the weight has no zero or no pole
    """

    gain: float
    zero: float = np.inf
    pole: float = np.inf

    def system(self, period: float) -> Lti:
        """Return the weight in continuous time (period 0) or its Tustin equivalent.

        Raises ValueError for a zero without a pole, since such a weight is not proper.
        """
        if np.isinf(self.pole):
            if np.isfinite(self.zero):
                raise ValueError("a weight with a zero needs a pole, else it is not proper")
            return gain(self.gain, period)
        high = self.gain * self.pole / self.zero
        a, b, c, d = (
            np.array([[value]]) for value in (-self.pole, self.pole, self.gain - high, high)
        )
        continuous = Lti(a, b, c, d, 0.0)
        return tustin(continuous, period) if period else continuous


@dataclass(frozen=True)
class PlantWeights:
    """Weights of the closed loop's signals.

    - error: W2 (thesis 5.56), of the error
    - disturbance: W1, of the friction
    - drive: W3 (5.58), of the drive
    - command: W_u, of the commanded drive
    - noise: W4, of the measurement noise [rad or m]
    - eta: W_eta, of the measured signal
    - uncertainty: W5, of the uncertainty channel; not used if the plant has no such channel
    """

    error: FirstOrderWeight
    disturbance: float
    drive: float
    command: float = 0.0
    noise: FirstOrderWeight = FirstOrderWeight(0.0)
    eta: float = 0.0
    uncertainty: FirstOrderWeight = FirstOrderWeight(1.0)


def template(bandwidth: float, modulus_margin: float, static_error: float) -> FirstOrderWeight:
    """Return the weight W2 (thesis 5.56) of the error.

    - bandwidth: zero z2 of W2 [rad/s]
    - modulus_margin: smallest allowed modulus margin M_mod
    - static_error: largest allowed relative static error e_stat

    By thesis (5.57), the pole is p2 = z2 M_mod e_stat and the gain is G2 = M_mod z2/p2.
    """
    pole = bandwidth * modulus_margin * static_error
    return FirstOrderWeight(modulus_margin * bandwidth / pole, bandwidth, pole)


@dataclass(frozen=True)
class UncertaintyChannel:
    """Uncertainty channel z_Delta = (drive i + viscous v + friction w)/d of one real Delta.

    i, v and w are the drive, the speed and the friction input. The feedback w_Delta = Delta z_Delta
    of the real uncertainty Delta, |Delta| <= 1, closes the channel (annex C of the thesis, (22) and
    (29)). The scale d of the channel is the field `unit` of UncertainPlant.
    """

    drive: float
    viscous: float
    friction: float


@dataclass(frozen=True)
class GeneralisedPlant:
    """Generalised plant: external inputs w, controls u, outputs z and measurements y.

        x' | x+ = a x + b1 w + b2 u;  z = c1 x + d11 w + d12 u;  y = c2 x + d21 w

           w ──▶┌─────┐──▶ z
                │  P  │
        ┌─ u ──▶└─────┘──▶ y ─┐
        └──────[  K  ]◀───────┘

    The period [s] is 0 in continuous time.
    """

    a: Matrix
    b1: Matrix
    b2: Matrix
    c1: Matrix
    c2: Matrix
    d11: Matrix
    d12: Matrix
    d21: Matrix
    period: float

    @staticmethod
    def of(system: Lti, measured: int = 1, controls: int = 1) -> GeneralisedPlant:
        """Return `system` as a plant.

        The last `measured` outputs of `system` are y; the last `controls` inputs of `system` are
        u. Raises ValueError if a control acts on a measurement without delay (D22 not zero).
        """
        w, z = system.b.shape[1] - controls, system.c.shape[0] - measured
        if np.any(system.d[z:, w:]):
            raise ValueError("the control acts on the measurement without delay: D22 must be zero")
        return GeneralisedPlant(
            system.a,
            system.b[:, :w],
            system.b[:, w:],
            system.c[:z],
            system.c[z:],
            system.d[:z, :w],
            system.d[:z, w:],
            system.d[z:, :w],
            system.period,
        )

    def transformed(self, t: Matrix) -> GeneralisedPlant:
        """Return the same plant with the new state x_new, where x = t x_new."""
        inverse = np.linalg.inv(t)
        return replace(
            self,
            a=inverse @ self.a @ t,
            b1=inverse @ self.b1,
            b2=inverse @ self.b2,
            c1=self.c1 @ t,
            c2=self.c2 @ t,
        )

    def closed(self, k: Lti) -> Lti:
        """Return the system from w to z with the controller u = k y.

        The states of the plant come first, then the states of the controller k.
        """
        direct = self.b2 @ k.d
        a = np.block([[self.a + direct @ self.c2, self.b2 @ k.c], [k.b @ self.c2, k.a]])
        b = np.vstack([self.b1 + direct @ self.d21, k.b @ self.d21])
        c = np.hstack([self.c1 + self.d12 @ k.d @ self.c2, self.d12 @ k.c])
        return Lti(a, b, c, self.d11 + self.d12 @ k.d @ self.d21, self.period)


def generalised_plant(
    controlled: Controlled,
    axis: AxisRates | DiagramBlock,
    lag: float,
    weights: PlantWeights,
    period: float = 0.0,
    delay_samples: int = 0,
    uncertainty: UncertaintyChannel | None = None,
) -> GeneralisedPlant:
    """Return the generalised plant of one vertex; `lag` and `period` are in s.

    If `axis` is a DiagramBlock, `lag` is not used. Ports of `axis` that `linear_axis` lacks become
    the first inputs and outputs of the plant. Raises ValueError for a delay in continuous time.
    """
    if delay_samples and not period:
        raise ValueError("a delay in samples needs a sampled plant")
    speed = controlled == "speed"
    blocks = {
        "delay": DiagramBlock(delay(delay_samples, period), ("u",), ("command",)),
        "axis": axis if isinstance(axis, DiagramBlock) else linear_axis(axis, lag, period),
        "W2": DiagramBlock(weights.error.system(period), ("error",), ("z_error",)),
        "W4": DiagramBlock(weights.noise.system(period), ("noise",), ("disturbing_noise",)),
    }
    sums = {
        "friction": {"friction_signal": weights.disturbance},
        "measured": {"eta": 1.0, "disturbing_noise": 1.0}
        if speed
        else {"reference": 1.0, "eta": 1.0, "disturbing_noise": 1.0},
        "error": {"speed_reference": 1.0, "speed": -1.0}
        if speed
        else {"reference": 1.0, "eta": 1.0},
        "z_drive": {"drive": weights.drive},
        "z_command": {"u": weights.command},
        "z_eta": {"eta": weights.eta},
    }
    further = [name for name in blocks["axis"].inputs if name not in INPUTS]
    inputs = [*further, "speed_reference" if speed else "reference", "friction_signal"]
    if not speed:
        sums["speed_reference"] = {}
    if weights.noise.gain:
        inputs.append("noise")
    else:
        sums["noise"] = {}
    outputs = [name for name in blocks["axis"].outputs if name not in OUTPUTS]
    outputs += (
        ["z_error", "z_drive"]
        + ["z_command"] * bool(weights.command)
        + ["z_eta"] * bool(weights.eta)
    )
    if uncertainty is None:
        sums["uncertain_effort"] = {}
    else:
        inputs.append("uncertain_effort")
        outputs.append("z_uncertain")
        terms = {
            "drive": uncertainty.drive,
            "speed": uncertainty.viscous,
            "friction": uncertainty.friction,
        }
        sums["z_uncertain_raw"] = terms
        blocks["W5"] = DiagramBlock(
            weights.uncertainty.system(period), ("z_uncertain_raw",), ("z_uncertain",)
        )
    return GeneralisedPlant.of(connect(blocks, sums, (*inputs, "u"), (*outputs, "measured")))
