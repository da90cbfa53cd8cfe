"""Blocks of `design.yaml` around the linear controller."""

from __future__ import annotations

from math import isfinite
from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import PositiveNumber
from frictool.documents.quantity import (
    PositiveEffort,
    PositiveLength,
    PositiveVelocity,
)


class PositionLawDesign(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Speed reference as a function of the position error, and the action inside the band.

    `kind`: `square_root` is (5.19), annex (5); `proportional` is gain_per_s times the error.
    `formula` of the square-root gain: `sqrt(2F/J)` is annex (5), `sqrt(F/J)` is annex 5.2 (lower by
    sqrt 2). `virtual_coulomb_factor` replaces F by F_cv > F_c (annex 3.1, (5.42)).

    `band`: by default the encoder's step (5.7). `action`: `cut` sets the drive to zero inside the
    band. `brake` first applies a speed reference of zero until the measured speed is below
    `rest_speed`, then sets the drive to zero. `none` keeps the loop closed. `cut` and `brake` wait
    until the prefilter moves more slowly than `settled_speed`.
    """

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
                "kind square_root needs a formula, sqrt(2F/J) or sqrt(F/J); kind "
                "proportional has none"
            )
        if root != (self.gain_per_s is None):
            raise ValueError(
                "kind proportional needs gain_per_s; the gain of kind square_root is its formula's"
            )
        if not root and self.virtual_coulomb_factor != 1.0:
            raise ValueError(
                "virtual_coulomb_factor is for kind square_root: a proportional law "
                "does not count on friction"
            )
        if (self.action == "brake") != (self.rest_speed is not None):
            raise ValueError("action brake needs rest_speed, and no other action has one")
        if self.action == "none" and self.settled_speed is not None:
            raise ValueError(
                "settled_speed is for action cut or brake: action none waits for nothing"
            )
        if self.action == "none" and not root and self.band is not None:
            raise ValueError(
                "band is for kind square_root, or for action cut or brake: a "
                "proportional law with action none reads none"
            )


class VelocityDesign(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Source of the speed signal: filtered difference of the encoder position, or a speed sensor.

    `measured` is the signal of a speed sensor, unfiltered. `order` 2 is (5.70); `order` 1 has half
    its lag. `filter_rad_s`: by default 10 times the prefilter's frequency, as below (5.70); 0 for
    none.
    """

    source: Literal["position", "measured"] = "position"
    order: Literal[1, 2] | None = None
    filter_rad_s: Annotated[float, msgspec.Meta(ge=0)] | None = None

    def __post_init__(self) -> None:
        if self.source == "measured" and (self.filter_rad_s is not None or self.order is not None):
            raise ValueError(
                "order and filter_rad_s are for source position: a measured speed is taken as it is"
            )
        if self.filter_rad_s == 0.0 and self.order is not None:
            raise ValueError("filter_rad_s is 0, the encoder's difference itself: leave out order")


class LimiterDesign(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Release of the drive near the target of a position loop (5.2.2); the integrator is frozen.

    `condition`: `energy` releases the drive if friction alone stops the motion at the target (5.7),
    by the model's inertia and Coulomb friction; `error` does so if the error is small, the cut-off
    that 5.2.1 argues against.

    `band`: delta_e; by default the encoder's step, which is also the smallest allowed value.
    `virtual_coulomb`: F_cv; the released drive applies the effort -F_cv tanh(v/v_r) (5.40), (5.41).
    `virtual_speed`: v_r; by default the value with which the brake near rest has a time constant of
    10 samples. `settled_speed`: the release waits until the prefilter moves more slowly than this.
    """

    condition: Literal["energy", "error"]
    band: PositiveLength | None = None
    settled_speed: PositiveVelocity | None = None
    virtual_coulomb: PositiveEffort | None = None
    virtual_speed: PositiveVelocity | None = None

    def __post_init__(self) -> None:
        if self.virtual_speed is not None and self.virtual_coulomb is None:
            raise ValueError(
                "virtual_speed is of the virtual friction: give virtual_coulomb too, "
                "or leave it out"
            )


class FrictionCompensationDesign(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Friction effort added to the drive: the baseline that 5.1 argues against, for comparison.

    `source`: `model` adds F_c tanh(v/smoothing_speed) + sigma_v v with the model's levels;
    `observer` adds the disturbance that an observer of bandwidth `observer_rad_s` estimates.
    `velocity` selects v: the speed of the filtered reference, or the measured speed. For the
    measured speed, smoothing_speed is by default the speed of one encoder count per sample. `gain`:
    fraction of the effort that is added.
    """

    source: Literal["model", "observer"]
    velocity: Literal["reference", "measured"] | None = None
    smoothing_speed: PositiveVelocity | None = None
    observer_rad_s: PositiveNumber | None = None
    gain: Annotated[float, msgspec.Meta(gt=0, le=1.5)] = 1.0

    def __post_init__(self) -> None:
        if (self.source == "observer") != (self.observer_rad_s is not None):
            raise ValueError("source observer needs observer_rad_s, and source model has none")
        if self.source == "observer" and (
            self.velocity is not None or self.smoothing_speed is not None
        ):
            raise ValueError(
                "velocity and smoothing_speed are for source model: an observer takes "
                "the measured speed as it is"
            )
        if self.velocity == "reference" and self.smoothing_speed is None:
            raise ValueError(
                "velocity reference needs smoothing_speed, the speed below which the "
                "modelled friction fades"
            )


class PrefilterDesign(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Second-order low-pass filter of the position reference (5.69)."""

    natural_frequency_rad_s: PositiveNumber
    damping: PositiveNumber

    def __post_init__(self) -> None:
        refuse_overflowing_prefilter(self.natural_frequency_rad_s, self.damping)


def refuse_overflowing_prefilter(natural_frequency: float, damping: float) -> None:
    """Raise ValueError if a coefficient of the prefilter's difference equation overflows."""
    if not isfinite(natural_frequency * (2.0 * damping + natural_frequency)):
        raise ValueError(
            f"natural_frequency_rad_s, damping: found {natural_frequency:g}, "
            f"{damping:g}; too large to be sampled"
        )
