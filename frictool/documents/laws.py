"""`laws` of `model.yaml`: friction by direction, speed, position, time at rest and temperature.

The laws also contain position-dependent loads.
"""

from __future__ import annotations

import itertools
from math import fsum, inf, nan
from typing import Annotated

import msgspec

from frictool.documents.quantity import (
    ChangePerKelvin,
    ChangePerSquareKelvin,
    EffortEstimate,
    NonNegativeEffort,
    NonNegativeEffortEstimate,
    PositionSpan,
    PositiveLength,
    PositiveVelocity,
    StiffnessEstimate,
    Temperature,
    TemperatureSpan,
    ViscousEstimate,
)

Ends = tuple[float, float]  # low, high
MOST_REGIMES, MOST_COEFFICIENTS = 4, 8


class Backward(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Friction levels of the negative direction.

    If a level is present here, the level of this name under `parameters` applies to the positive
    direction only. A level that is absent here is the same in both directions.
    """

    viscous: ViscousEstimate | None = None
    coulomb: NonNegativeEffortEstimate | None = None
    breakaway: NonNegativeEffortEstimate | None = None


class Regime(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Viscous friction at speeds above `above`; the friction is continuous at this speed.

    - `above`: Speed at which the viscous friction changes.
    - `viscous`: Viscous friction above this speed.
    - `backward`: Viscous friction of the negative direction. The default is `viscous`.
    """

    # figure 4.10
    above: PositiveVelocity
    viscous: ViscousEstimate
    backward: ViscousEstimate | None = None


class Polynomial(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Polynomials of the position [rad | m] for both directions of motion.

    Each polynomial has 1 to 8 coefficients, lowest power first.

    - `forward`: Coefficients of the positive direction.
    - `backward`: Coefficients of the negative direction. The default is `forward`.
    - `forward_interval`, `backward_interval`: Interval [low, high] of each coefficient, if it was
      identified.
    """

    forward: tuple[float, ...]
    backward: tuple[float, ...] | None = None
    forward_interval: tuple[Ends, ...] | None = None
    backward_interval: tuple[Ends, ...] | None = None

    def __post_init__(self) -> None:
        for side in (self.forward, self.backward or self.forward):
            if not 1 <= len(side) <= MOST_COEFFICIENTS:
                raise ValueError(
                    f"found {len(side)} coefficients; allowed: 1 to {MOST_COEFFICIENTS}"
                )
        for name in ("forward", "backward"):
            ends = getattr(self, f"{name}_interval")
            side = getattr(self, name)
            if ends is not None and (side is None or len(ends) != len(side)):
                raise ValueError(
                    f"{name}_interval: found {len(ends)} intervals; allowed: one interval "
                    f"for each coefficient of {name}"
                )


class FrictionOverPosition(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Position-dependent friction over a travel; the friction is constant beyond the travel.

    Each polynomial is divided by its mean over the travel. The result is the factor by which the
    model's parameter of the same name is multiplied. The interval of this parameter scales the
    whole curve.

    - `over`: Travel on which the polynomials apply.
    - `coulomb`: Polynomials of the Coulomb friction.
    - `breakaway`: Polynomials of the breakaway. The default is the polynomials of `coulomb`.
    """

    # (4.44); without breakaway (4.41)
    over: PositionSpan
    coulomb: Polynomial
    breakaway: Polynomial | None = None

    def __post_init__(self) -> None:
        if not self.over.low < self.over.high:
            raise ValueError(
                f"over: found {self.over.low:g} to {self.over.high:g}; allowed: low < high"
            )
        for name, curve in (("coulomb", self.coulomb), ("breakaway", self.breakaway)):
            for side in ("forward", "backward"):
                mean = (
                    1.0
                    if curve is None
                    else _mean(getattr(curve, side) or curve.forward, self.over.low, self.over.high)
                )
                if not 0.0 < mean < inf:
                    raise ValueError(
                        f"{name}.{side}: found a mean of {mean:g} over the travel; allowed: > 0, "
                        "because the polynomial is divided by its mean"
                    )


def _mean(coefficients: tuple[float, ...], low: float, high: float) -> float:
    try:
        return fsum(
            b * (high**power - low**power) / power for power, b in enumerate(coefficients, start=1)
        ) / (high - low)
    except (OverflowError, ValueError):
        return nan


class Dwell(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Increase of the breakaway with the time at rest.

    - `fresh`: Breakaway just after a stop, divided by the breakaway after a long rest.
    - `rise_time_s`: Time at rest after which half of the increase is reached.
    - `fresh_interval`, `rise_time_interval_s`: Interval [low, high], if the value was identified.
    """

    fresh: Annotated[float, msgspec.Meta(gt=0, le=1)]
    rise_time_s: Annotated[float, msgspec.Meta(gt=0, le=1e6)]
    fresh_interval: Ends | None = None
    rise_time_interval_s: Ends | None = None


class TemperatureChange(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Factor by which a friction parameter changes with the temperature.

    The factor is exp(slope h + curvature h^2), where h is the temperature minus the reference
    temperature.

    - `slope`: Relative change per kelvin at h = 0. For example, a friction that halves over 50 K
      has the slope -0.0139 per kelvin.
    - `curvature`: Coefficient of h^2. The default is 0, so that each kelvin changes the friction by
      the same ratio.
    """

    slope: ChangePerKelvin
    curvature: ChangePerSquareKelvin | None = None


class FrictionOverTemperature(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Change of the friction with temperature, and temperature for which `parameters` are valid.

    - `reference`: Temperature for which the parameters and the other laws are valid.
    - `over`: Temperatures of the logs. Beyond them the friction is extrapolated.
    - `viscous`: Change of the viscous friction. By default the viscous friction is constant.
    - `coulomb`: Change of the Coulomb friction and of the breakaway. By default, both are constant.
    """

    reference: Temperature
    over: TemperatureSpan
    viscous: TemperatureChange | None = None
    coulomb: TemperatureChange | None = None

    def __post_init__(self) -> None:
        if not self.over.low <= self.reference.value <= self.over.high:
            raise ValueError(
                f"reference: found {self.reference.value:g} degC; allowed: {self.over.low:g} to "
                f"{self.over.high:g} degC, the temperatures of `over`"
            )


class Gravity(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Gravity effort of an unbalanced arm on a rotary axis.

    The effort is sine sin(x) + cosine cos(x) at the angle x [rad].

    - `sine`, `cosine`: Amplitude of the sine term and of the cosine term.
    """

    sine: EffortEstimate
    cosine: EffortEstimate


class Ripple(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Effort ripple of motor poles, motor slots or gear teeth, periodic in the position x.

    The effort is sine sin(2 pi cycles x / per) + cosine cos(2 pi cycles x / per).

    - `cycles`: Number of periods in the distance `per`.
    - `per`: Distance that contains `cycles` periods.
    - `sine`, `cosine`: Amplitude of the sine term and of the cosine term.
    """

    cycles: Annotated[float, msgspec.Meta(gt=0, le=1e6)]
    per: PositiveLength
    sine: EffortEstimate
    cosine: EffortEstimate


class TotalLoad(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Sum of the offset and of all loads over the position, with the uncertainty of the sum.

    On a short travel, the logs determine the sum better than its terms.

    - `least`, `largest`: Smallest and largest sum at any of the positions.
    - `error`: Largest uncertainty of the sum at any of the positions.
    - `over`: Positions for which the values are valid; by default all positions.
    """

    least: EffortEstimate
    largest: EffortEstimate
    error: NonNegativeEffort
    over: PositionSpan | None = None


class Load(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Position-dependent load; a positive load opposes a positive effort, as `offset` does.

    - `stiffness`: Stiffness of a spring that is relaxed at position 0; a preload is part of the
      offset. For a model with a spring, the design of a controller needs the travel in bench.yaml.
    - `gravity`: Gravity of an unbalanced arm.
    - `ripple`: Effort ripple.
    - `harmonics`: Ripple components with other periods than `ripple`, such as harmonics.
    - `total`: Sum of the offset and of these loads. `synth` uses this sum if its bound is smaller
      than the sum of the bounds of its terms.
    """

    stiffness: StiffnessEstimate | None = None
    gravity: Gravity | None = None
    ripple: Ripple | None = None
    harmonics: tuple[Ripple, ...] = ()
    total: TotalLoad | None = None

    @property
    def ripples(self) -> tuple[Ripple, ...]:
        """Return all components of the effort ripple."""
        return (() if self.ripple is None else (self.ripple,)) + self.harmonics


class Laws(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Optional friction and load laws of a model.

    - `backward`: Friction levels of the negative direction that differ from the positive direction.
    - `regimes`: Viscous friction that changes above certain speeds; at most 4 regimes, in rising
      order of the speeds.
    - `position`: Position-dependent friction.
    - `stribeck_exponent`: Exponent of the Stribeck curve.
    - `dwell`: Increase of the breakaway with the time at rest.
    - `restitution`: Speed after an impact on an end of the travel in bench.yaml, divided by the
      speed before the impact.
    - `load`: Position-dependent load.
    - `temperature`: Temperature for which the model is valid, and change of friction with
      temperature.
    """

    # the exponent is delta of (2.34)
    backward: Backward | None = None
    regimes: tuple[Regime, ...] = ()
    position: FrictionOverPosition | None = None
    stribeck_exponent: Annotated[float, msgspec.Meta(ge=0.5, le=4)] = 2.0
    dwell: Dwell | None = None
    restitution: Annotated[float, msgspec.Meta(ge=0, le=0.95)] = 0.0
    load: Load | None = None
    temperature: FrictionOverTemperature | None = None

    def __post_init__(self) -> None:
        if len(self.regimes) > MOST_REGIMES:
            raise ValueError(f"regimes: found {len(self.regimes)}; allowed: at most {MOST_REGIMES}")
        for slower, faster in itertools.pairwise(regime.above.value for regime in self.regimes):
            if slower >= faster:
                raise ValueError(
                    f"regimes: found above {faster:g} after above {slower:g}; allowed: rising "
                    "values of above"
                )
