"""Certificate of a controller: the bounds that `frictool verify` proves again.

A certificate contains the parameter intervals, the weights of the norm and the value of each bound.
The proof needs no other data and no search (verify/zero_exclusion.py). A certificate contains no
digest, because the proof depends only on the controller's coefficients.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import PositiveNumber

Row = tuple[float, ...]
Amplitude = Annotated[float, msgspec.Meta(ge=0)]


def _increasing(name: str, interval: Row) -> None:
    if len(interval) != 2 or interval[0] > interval[1]:
        raise ValueError(f"{name}: found {list(interval)}; allowed: [low, high] with low <= high")


class Box(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Intervals [low, high] of the plant parameters (SI).

    Both ends are equal for an exactly known parameter.
    """

    inertia: Row
    viscous: Row
    coulomb: Row
    constant: Row

    def __post_init__(self) -> None:
        for name in ("inertia", "viscous", "coulomb", "constant"):
            _increasing(name, getattr(self, name))
        for name in ("inertia", "constant"):
            if getattr(self, name)[0] <= 0.0:
                raise ValueError(f"{name}: found {list(getattr(self, name))}; allowed: > 0")


class Filter(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Weight that equals gain (s/zero + 1)/(s/pole + 1), discretised by Tustin's rule.

    - `gain`: Gain at frequency 0.
    - `zero`, `pole`: Angular frequency of the zero and of the pole [rad/s]. The default is
      infinity.
    """

    gain: Amplitude
    zero: PositiveNumber | None = None
    pole: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if self.zero is not None and self.pole is None:
            raise ValueError(
                "found `zero` without `pole`, so that the weight is not proper; write both"
            )


class CertifiedWeights(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Weights of the closed loop's inputs and outputs (docs/theory/plants.md).

    The certificate bounds the norm from the weighted inputs to the weighted outputs.

    - `error`: Error weight W2.
    - `disturbance`: Disturbance weight W1.
    - `drive`: Weight W3 on the drive that reaches the actuator.
    - `command`: Weight on the commanded drive.
    - `noise`: Noise weight W4.
    - `eta`: Weight on eta, the position error that is the input of the linear controller.
    """

    error: Filter
    disturbance: Amplitude
    drive: Amplitude
    command: Amplitude = 0.0
    noise: Filter = Filter(0.0)
    eta: Amplitude = 0.0


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Cell of the parameter box in a proof of version 1. It is read, but not used.

    - `drive_rate`: [low, high] of constant/inertia (SI).
    - `viscous_rate`: [low, high] of viscous/inertia (SI).
    - `at_low`, `at_high`: Lyapunov matrix at the lower and at the upper end of `drive_rate`.
    """

    drive_rate: Row
    viscous_rate: Row
    at_low: str
    at_high: str


class Bound(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Proved upper bound of a property of the closed loop.

    - `of`: Bounded property. `norm` is the norm from the weighted inputs to the weighted outputs.
      `sensitivity` is the peak of the sensitivity function; the inverse of this peak is the modulus
      margin.
    - `below`: Value of the bound.
    - `bits`, `factor`, `cells`: Matrices of a proof of version 1. They are read, but not used.
    """

    of: Literal["norm", "sensitivity"]
    below: PositiveNumber
    bits: Annotated[int, msgspec.Meta(ge=1, le=64)] | None = None
    factor: tuple[Row, ...] = ()
    cells: tuple[Cell, ...] = ()

    @property
    def modulus_margin(self) -> float | None:
        """Return the modulus margin that follows from the bound; None for a bound of the norm."""
        return 1.0 / self.below if self.of == "sensitivity" else None


class RestCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One hypothesis of the proof that the axis comes to rest in the rest band (see RestProof).

    - `name`: Name of the hypothesis. `breakaway`: the smallest friction of all plants is above 0
      [N m | N]. `band`: the half-width of the rest band is at least one encoder count [rad | m].
      `released_effort`: the largest effort of the virtual friction, which still acts when the drive
      is switched off, is below half of the smallest friction [N m | N]. `count_pulse`: the largest
      effort in response to one encoder count is below half of the smallest friction [N m | N].
      `frozen_integrator`: integrators keep their values while the drive is switched off.
      `arrival_speed`: the axis stops within the rest band from the speed at which the drive is
      switched off [rad/s | m/s]. `stable_loop`: a bound of the sensitivity of the linear loop is
      proved.
    - `state`: `holds` or `fails`; `undecided` if only a sufficient condition fails.
    - `value`: Value of the checked quantity for this controller.
    - `limit`: Value with which `value` is compared.
    """

    # the hypotheses of propositions 5.2.1 and 5.2.2
    name: Literal[
        "breakaway",
        "band",
        "released_effort",
        "count_pulse",
        "frozen_integrator",
        "arrival_speed",
        "stable_loop",
    ]
    state: Literal["holds", "fails", "undecided"]
    value: float
    limit: float


class RestProof(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Proof that an axis inside the rest band stops and stays at rest, for every plant.

    The rest band is the range of position errors around the target in which the controller switches
    the drive off. The proof covers the plants of the certificate.

    - `verdict`: `proved` if all checks hold, except perhaps `arrival_speed` and `stable_loop`; else
      `undecided`.
    - `disturbance`: Largest sum of disturbance and offset at which a resting axis stays at rest [N
      m | N].
    - `stopping_disturbance`: Disturbance up to which `speed` and `stop_time_s` are valid [N m | N].
    - `speed`: Largest speed [rad/s | m/s] at the target from which the axis stops inside the rest
      band while the drive is off. The value is 0 for a limiter with condition `energy`.
    - `stop_time_s`: Longest time that an axis with the speed `speed` takes to stop.
    - `checks`: Hypotheses of the proof, each with its value and limit.
    """

    verdict: Literal["proved", "undecided"]
    disturbance: Amplitude
    stopping_disturbance: Amplitude
    speed: Amplitude
    stop_time_s: Amplitude
    checks: tuple[RestCheck, ...]


class Cycle(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Limit cycle of the nominal plant, found by a simulation.

    - `reference`: Constant position reference [rad | m].
    - `amplitude`: Half the peak-to-peak value of the position [rad | m].
    - `period_s`: Time between two successive maxima of the position.
    """

    reference: float
    amplitude: Amplitude
    period_s: Amplitude


class Certificate(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Parameter intervals, weights and bounds of a certificate.

    - `version`: Version of this layout. Version 1 also contains matrices of an older proof, which
      are ignored. `verify` proves both versions in the same way.
    - `box`: Intervals of the parameters.
    - `weights`: Weights of the norm.
    - `bounds`: Bounds that are proved.
    - `not_proved`: Reason for each bound that could not be proved.
    - `rest`: Proof that the axis comes to rest; absent if the controller has no rest band (position
      error below which it switches the drive off).
    - `cycle`: Limit cycle that a simulation shows for a controller without a rest band; absent if
      the simulation shows no limit cycle.
    """

    version: Literal[1, 2]
    box: Box
    weights: CertifiedWeights
    bounds: tuple[Bound, ...]
    not_proved: dict[str, str] = {}
    rest: RestProof | None = None
    cycle: Cycle | None = None
