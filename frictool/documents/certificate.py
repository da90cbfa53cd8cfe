"""Certificate of a controller: the bounds that `frictool verify` proves again.

A certificate contains the parameter intervals, the weights of the norm and the value of each bound.
The proof needs no other data and no search (verify/zero_exclusion.py). A certificate contains no
digest, because the proof depends on the coefficients alone.
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
    """Intervals [low, high] of the parameters (SI).

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
    - `zero`, `pole`: Angular frequency [rad/s]. By default infinite.
    """

    gain: Amplitude
    zero: PositiveNumber | None = None
    pole: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if self.zero is not None and self.pole is None:
            raise ValueError("a weight with a zero needs a pole")


class CertifiedWeights(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Weights of the generalised plant whose norm is bounded (docs/theory/plants.md).

    - `error`: Error weight W2.
    - `disturbance`: Disturbance weight W1.
    - `drive`: Weight W3 on the drive that reaches the actuator.
    - `command`: Weight on the commanded drive.
    - `noise`: Noise weight W4.
    - `eta`: Weight on the input eta of the linear controller.
    """

    error: Filter
    disturbance: Amplitude
    drive: Amplitude
    command: Amplitude = 0.0
    noise: Filter = Filter(0.0)
    eta: Amplitude = 0.0


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Part of a proof of version 1. It is read, but not used.

    - `drive_rate`: [low, high] of constant/inertia (SI).
    - `viscous_rate`: [low, high] of viscous/inertia (SI).
    - `at_low`, `at_high`: Lyapunov matrix at this end of the drive rate.
    """

    drive_rate: Row
    viscous_rate: Row
    at_low: str
    at_high: str


class Bound(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Upper bound of a property of the loop.

    - `of`: `norm`: the norm from the weighted inputs to the weighted outputs. `sensitivity`: the
      largest sensitivity, the inverse of the modulus margin.
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
        """Return the modulus margin that a sensitivity bound implies; None for a norm."""
        return 1.0 / self.below if self.of == "sensitivity" else None


class RestCheck(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One hypothesis of the proof of rest.

    - `name`: `breakaway`: the least friction of all plants is above 0 [N m | N]. `band`: the band
      is not narrower than an encoder count [rad | m]. `released_effort`: the largest effort of the
      released drive is below half of the least friction [N m | N]. `count_pulse`: the largest
      effort in response to one encoder count is below half of the least friction.
      `frozen_integrator`: integrators keep their values while the drive is released.
      `arrival_speed`: the axis stops within the band from the speed at which the drive is released
      [rad/s | m/s]. `stable_loop`: a bound of the linear loop's largest sensitivity is proved.
    - `state`: `holds`, `fails`, or `undecided` if a sufficient but not necessary condition fails.
    - `value`: Value of the checked quantity for this controller.
    - `limit`: Value that `value` is compared with.
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
    """Proof for every plant of the certificate: an axis inside the band comes to rest and stays.

    - `verdict`: `proved` if all checks hold, except perhaps `arrival_speed` and `stable_loop`; else
      `undecided`.
    - `disturbance`: Largest sum of disturbance and offset at which a resting axis stays at rest [N
      m | N].
    - `stopping_disturbance`: Disturbance up to which `speed` and `stop_time_s` are valid [N m | N].
    - `speed`: Largest speed [rad/s | m/s] at the target from which the axis, with the drive at 0,
      stops inside the band. It is 0 for a limiter with condition `energy`.
    - `stop_time_s`: Longest time until an axis that moves at `speed` stands still.
    - `checks`: Hypotheses with their figures.
    """

    verdict: Literal["proved", "undecided"]
    disturbance: Amplitude
    stopping_disturbance: Amplitude
    speed: Amplitude
    stop_time_s: Amplitude
    checks: tuple[RestCheck, ...]


class Cycle(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Limit cycle of the nominal plant in a simulation.

    - `reference`: Constant position reference [rad | m].
    - `amplitude`: Half the peak-to-peak value of the position [rad | m].
    - `period_s`: Time between turning points on the same side.
    """

    reference: float
    amplitude: Amplitude
    period_s: Amplitude


class Certificate(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Parameter intervals, weights and bounds of a certificate.

    - `version`: Version of this layout. Both versions state the same bounds, and `verify` proves
      both in the same way.
    - `box`: Intervals of the parameters.
    - `weights`: Weights of the norm.
    - `bounds`: Bounds that are proved.
    - `not_proved`: Name of each bound without a proof, and the reason.
    - `rest`: Proof of rest inside the band; absent without a band.
    - `cycle`: Limit cycle of a controller without a band, if the simulation has one.
    """

    version: Literal[1, 2]
    box: Box
    weights: CertifiedWeights
    bounds: tuple[Bound, ...]
    not_proved: dict[str, str] = {}
    rest: RestProof | None = None
    cycle: Cycle | None = None
