"""Blocks of `design.yaml` that surround the linear controller."""

from __future__ import annotations

from math import isfinite
from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import PositiveNumber
from frictool.documents.quantity import (
    Inertia,
    NonNegativeEffort,
    PositiveAcceleration,
    PositiveEffort,
    PositiveJerk,
    PositiveLength,
    PositiveVelocity,
    Viscous,
)

# longest moving average of a profile; each sample of it is a state of the program
MOST_SMOOTHING = 200
SmoothingSamples = Annotated[int, msgspec.Meta(ge=2, le=MOST_SMOOTHING)]


class PositionLawDesign(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Speed reference as a function of the position error, and the action inside the rest band.

    The rest band is the range of position errors up to `band`.

    - `action`: Action inside the rest band. `cut`: the drive is switched off. `brake`: the speed
      reference is 0 until the measured speed is below `rest_speed`, then the drive is switched off.
      `none`: the loop stays closed.
    - `kind`: `square_root`: the speed reference is proportional to the square root of the error.
      `proportional`: it is `gain_per_s` times the error.
    - `formula`: Gain of the square-root law: sqrt(2F/J), or the lower gain sqrt(F/J). F is the
      model's Coulomb friction and J its inertia.
    - `gain_per_s`: Gain of the proportional law.
    - `band`: Half-width of the rest band. The default is the encoder's step.
    - `settled_speed`: `cut` and `brake` act only if the speed of the prefilter or profile is below
      this value.
    - `rest_speed`: Measured speed below which `brake` switches the drive off.
    - `virtual_coulomb_factor`: Factor by which F is multiplied in the square-root law. A factor
      above 1 stands for virtual friction in addition to the axis's friction.
    """

    # square_root is (5.19), annex (5): sqrt(2F/J); sqrt(F/J) is annex 5.2. The factor is F_cv/F_c
    # of annex 3.1, (5.42)
    action: Literal["cut", "brake", "none"]
    kind: Literal["square_root", "proportional"] = "square_root"
    formula: Literal["sqrt(2F/J)", "sqrt(F/J)"] | None = None
    gain_per_s: PositiveNumber | None = None
    band: PositiveLength | None = None
    settled_speed: PositiveVelocity | None = None
    rest_speed: PositiveVelocity | None = None
    virtual_coulomb_factor: Annotated[float, msgspec.Meta(ge=1)] = 1.0

    def __post_init__(self) -> None:
        root = self.kind == "square_root"
        if root != (self.formula is not None):
            raise ValueError(
                "`kind: square_root` needs `formula`, sqrt(2F/J) or sqrt(F/J); "
                "`kind: proportional` needs no formula"
            )
        if root != (self.gain_per_s is None):
            raise ValueError(
                "`kind: proportional` needs gain_per_s; the gain of `kind: square_root` follows "
                "from its formula"
            )
        if not root and self.virtual_coulomb_factor != 1.0:
            raise ValueError(
                "virtual_coulomb_factor belongs to `kind: square_root`; a proportional law does "
                "not use friction"
            )
        if (self.action == "brake") != (self.rest_speed is not None):
            raise ValueError(
                "`action: brake` needs rest_speed; with any other action remove rest_speed"
            )
        if self.action == "none" and self.settled_speed is not None:
            raise ValueError("settled_speed belongs to `action: cut` or `action: brake`")
        if self.action == "none" and not root and self.band is not None:
            raise ValueError(
                "`band` belongs to `kind: square_root`, `action: cut` or `action: brake`; a "
                "proportional law with `action: none` does not use it"
            )


class VelocityDesign(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Source of the speed signal: filtered differences of the encoder position, or a speed sensor.

    - `source`: `position`: the speed is computed from filtered differences of the encoder position.
      `measured`: the speed is the unfiltered signal of a speed sensor.
    - `order`: Order of the low-pass filter; order 1 has half the lag of order 2. The default is 2.
    - `filter_rad_s`: Bandwidth of the low-pass filter; 0 for unfiltered differences. The default is
      10 times the prefilter's frequency.
    """

    # order 2 is (5.70); the thesis states the default bandwidth below this equation
    source: Literal["position", "measured"] = "position"
    order: Literal[1, 2] | None = None
    filter_rad_s: Annotated[float, msgspec.Meta(ge=0)] | None = None

    def __post_init__(self) -> None:
        if self.source == "measured" and (self.filter_rad_s is not None or self.order is not None):
            raise ValueError(
                "`order` and filter_rad_s belong to `source: position`; "
                "a measured speed has no filter"
            )
        if self.filter_rad_s == 0.0 and self.order is not None:
            raise ValueError("`order` needs a filter, but filter_rad_s is 0; remove `order`")


class LimiterDesign(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Block of a position loop that switches the drive off near the target.

    The integrator keeps its value while the drive is off. The rest band is the range of position
    errors up to `band`.

    - `condition`: `energy` switches the drive off if the model's Coulomb friction alone stops the
      motion inside the rest band. `error` switches the drive off if the error is inside the rest
      band; this condition causes limit cycles and is for comparison only.
    - `band`: Half-width of the rest band. The default is the encoder's step, which is also the
      smallest allowed value.
    - `settled_speed`: The drive is switched off only if the speed of the prefilter or profile is
      below this value.
    - `virtual_coulomb`: Largest braking effort while the drive is otherwise off. The effort is
      -virtual_coulomb tanh(v/virtual_speed). The default is 0.
    - `virtual_speed`: Speed scale of the braking effort. The default is 10 virtual_coulomb
      T/inertia with the sample period T. Near rest, this brake reduces the speed with a time
      constant of 10 T.
    """

    # 5.2.2, (5.7); error is the cut-off that 5.2.1 argues against; the brake is (5.40), (5.41) with
    # F_cv and v_r
    condition: Literal["energy", "error"]
    band: PositiveLength | None = None
    settled_speed: PositiveVelocity | None = None
    virtual_coulomb: PositiveEffort | None = None
    virtual_speed: PositiveVelocity | None = None

    def __post_init__(self) -> None:
        if self.virtual_speed is not None and self.virtual_coulomb is None:
            raise ValueError("virtual_speed needs virtual_coulomb; add it, or remove virtual_speed")


class FrictionCompensationDesign(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Friction effort that is added to the drive, as a baseline for comparison.

    - `source`: `model` adds the model's friction. This friction is Coulomb friction times
      tanh(v/smoothing_speed) plus viscous friction times v. If the model has a Stribeck term or
      several speed regimes, or if the directions differ, the friction is a table over v instead. If
      the friction depends on the position, a table over the position is added. `observer` adds the
      disturbance that an observer estimates.
    - `velocity`: Origin of the speed v: the filtered reference, or the measured speed. The default
      is `measured`.
    - `smoothing_speed`: Speed scale below which the modelled friction decreases to 0. For the
      measured speed, the default is one encoder count per sample.
    - `observer_rad_s`: Bandwidth of the observer.
    - `gain`: Fraction of the friction effort that is added to the drive.
    """

    # 5.1 argues against it
    source: Literal["model", "observer"]
    velocity: Literal["reference", "measured"] | None = None
    smoothing_speed: PositiveVelocity | None = None
    observer_rad_s: PositiveNumber | None = None
    gain: Annotated[float, msgspec.Meta(gt=0, le=1.5)] = 1.0

    def __post_init__(self) -> None:
        if (self.source == "observer") != (self.observer_rad_s is not None):
            raise ValueError(
                "`source: observer` needs observer_rad_s; with `source: model` remove it"
            )
        if self.source == "observer" and (
            self.velocity is not None or self.smoothing_speed is not None
        ):
            raise ValueError(
                "`velocity` and smoothing_speed belong to `source: model`; `source: observer` uses "
                "the measured speed"
            )
        if self.velocity == "reference" and self.smoothing_speed is None:
            raise ValueError(
                "`velocity: reference` needs smoothing_speed, the speed below which the "
                "modelled friction decreases to 0"
            )


class ProfileDesign(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Profile with bounded jerk from the present position to the reference.

    With `{}`, all limits are derived from the drive, and `synth` prints each limit with its source.

    - `speed`: Largest speed. The default is the top speed in bench.yaml.
    - `acceleration`: Largest acceleration. The default is ((`drive_share` times the drive's largest
      effort) - friction - load)/inertia at `speed`, for the plant with the smallest result.
    - `jerk`: Largest jerk. The default lengthens a move by one period of the model's lowest
      resonance, compared with unlimited jerk. For a model without resonances, the default
      lengthens a move by a tenth of the time in which `speed` is reached.
    - `drive_share`: Fraction of the drive's limit that the default acceleration uses. The rest of
      the limit is left for the feedback.
    """

    speed: PositiveVelocity | None = None
    acceleration: PositiveAcceleration | None = None
    jerk: PositiveJerk | None = None
    drive_share: Annotated[float, msgspec.Meta(gt=0, le=1)] = 0.9


class FeedforwardDesign(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Effort that the modelled axis needs to follow its reference; it is added to the drive.

    With `{}`, all values follow from the model. Speed and acceleration of the reference come from
    `profile` or `prefilter`. If the design has neither of them, a filter differentiates the
    reference.

    - `inertia`: Inertia of the modelled axis.
    - `viscous`: Viscous friction of the modelled axis.
    - `coulomb`: Coulomb friction of the modelled axis.
    - `switch_on_speed`: Speed of the reference above which the Coulomb friction is added. The
      default is one encoder step in 10 samples. Below half of `switch_on_speed`, the Coulomb
      friction is no longer added.
    - `filter_rad_s`: Bandwidth of the filter that differentiates the reference.
    """

    inertia: Inertia | None = None
    viscous: Viscous | None = None
    coulomb: NonNegativeEffort | None = None
    switch_on_speed: PositiveVelocity | None = None
    filter_rad_s: PositiveNumber | None = None


class PrefilterDesign(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Second-order low-pass filter of the position reference.

    - `natural_frequency_rad_s`: Natural frequency of the filter.
    - `damping`: Damping ratio of the filter.
    """

    # (5.69)
    natural_frequency_rad_s: PositiveNumber
    damping: PositiveNumber

    def __post_init__(self) -> None:
        refuse_overflowing_prefilter(self.natural_frequency_rad_s, self.damping)


def refuse_overflowing_prefilter(natural_frequency: float, damping: float) -> None:
    """Raise ValueError if a coefficient of the prefilter's difference equation overflows."""
    if not isfinite(natural_frequency * (2.0 * damping + natural_frequency)):
        raise ValueError(
            f"natural_frequency_rad_s, damping: found {natural_frequency:g}, "
            f"{damping:g}; too large to be sampled: lower them"
        )
