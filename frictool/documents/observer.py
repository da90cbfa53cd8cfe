"""`observer.yaml`: what estimates velocity and friction at every sample, from the position and the
drive."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Bench, Name, PositiveNumber, SamplePeriod
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Axis, Inertia, PositionSpan, PositiveVelocity

Row = tuple[float, ...]
MOST_MODES = 201


class FrictionMap(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """What is known of the friction beforehand, f of (6.2) [N m | N]: polynomials of the position
    `over` a travel, flat beyond it.

    forward, backward: coefficients, lowest power first, of the magnitude in either direction.
    viscous [N m s/rad | N s/m] at every speed. offset [N m | N]: opposes a positive effort in
    either direction.
    """

    over: PositionSpan
    forward: Row
    backward: Row
    viscous: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    offset: float = 0.0


class Mode(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One mode of (6.18): `direction` of the motion, 0 where it is stuck; positions [low, high]
    [rad | m] in which it holds.

    friction: f_m(i), its magnitude there [N m | N]; deviation: Delta_f(i), half of its spread.
    gains: L_i of (6.4), a row a state. spectral_radius: of A_i - L_i C_i, as rebuilt from the
    gains.
    """

    index: int
    direction: Literal[-1, 0, 1]
    gains: tuple[Row, ...]
    spectral_radius: float
    over: tuple[float, float] | None = None
    friction: float = 0.0
    deviation: float = 0.0


class Switched(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The observer (6.4) with the gains of (6.6), states position, velocity and alpha.

    wear: multiplicative, friction alpha f (6.13); additive, f + alpha (6.22). switch_speed: Sigma,
    below which the mode is 0. weights: the diagonal of C-bar (6.19). decay: lambda, 1 where none
    was imposed. transitions: the pairs (i, j) for which (6.6) holds. stuck_speed: what A_0
    multiplies the velocity by, 0 as (6.18) has it, or 1, so that a gain can move it
    (docs/theory/observers.md). gamma: that of the inequalities, evaluated again with the stored
    gains; smallest_gamma: without a decay. switching_radius: worst spectral radius over the
    products of two modes that may alternate. simulated_gain: the largest ||z||/||Delta|| seen along
    allowed switching sequences; at most gamma. Of what the inequalities do not cover:
    motion_after_rest_s of motion make up for a rest of any length, in which alpha stands still,
    motion_after_turn_s for a switch between moving modes that is not in `transitions`. quiet: gamma
    is up to so many times the smallest one with this decay, for gains that pass least of the
    encoder's noise: z is at most noise_gain times its standard deviation [rad | m], as a gain of
    signals.
    """

    wear: Literal["multiplicative", "additive"]
    switch_speed: PositiveVelocity
    weights: tuple[float, float, float]
    modes: tuple[Mode, ...]
    transitions: tuple[tuple[int, int], ...]
    gamma: PositiveNumber
    decay: Annotated[float, msgspec.Meta(gt=0, le=1)] = 1.0
    stuck_speed: Annotated[float, msgspec.Meta(ge=0, le=1)] = 1.0
    switching_radius: float = 0.0
    simulated_gain: float = 0.0
    smallest_gamma: float | None = None
    motion_after_rest_s: float | None = None
    motion_after_turn_s: float | None = None
    quiet: Annotated[float, msgspec.Meta(gt=1)] | None = None
    noise_gain: float | None = None

    def __post_init__(self) -> None:
        known = [mode.index for mode in self.modes]
        if len(set(known)) != len(known) or not 1 <= len(known) <= MOST_MODES:
            raise ValueError(
                f"modes: found {len(known)}; allowed: 1 to {MOST_MODES}, each index once"
            )
        for pair in self.transitions:
            if any(index not in known for index in pair):
                raise ValueError(
                    f"transitions: found {list(pair)}; allowed: pairs of the modes' indices"
                )


class Knee(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Above a speed the viscous friction grows by `steeper` [N m s/rad | N s/m] (figure 4.10)."""

    above: PositiveVelocity
    steeper: float


class ObserverBacklash(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Between motor and load (4.45): full width [rad | m], and the friction [N m | N] of the motor
    alone inside it."""

    width: PositiveNumber
    friction: Annotated[float, msgspec.Meta(ge=0)]


class Tracking(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """An observer of position, velocity and disturbance that moves by the model and is put right by
    what the encoder excludes.

    gains: of the innovation, on position [1], velocity [1/s] and disturbance [N m/rad | N/m], a
    sample; three poles at exp(-bandwidth T). cell: the innovation is what a position misses so much
    of the encoder's cell by [rad | m], 0: the whole difference. breakaway_ratio: of the friction at
    rest, over that in slip.
    """

    gains: tuple[float, float, float]
    bandwidth_rad_s: PositiveNumber
    cell: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    breakaway_ratio: Annotated[float, msgspec.Meta(ge=1)] = 1.0
    knees: tuple[Knee, ...] = ()
    backlash: ObserverBacklash | None = None


class Observer(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`observer.yaml`: one of `switched` and `tracking`, and the plant that it believes in."""

    format: Literal["observer/1"]
    name: Name
    axis: Axis
    sample_period_s: SamplePeriod
    inertia: Inertia
    friction: FrictionMap
    bench: Bench
    provenance: Provenance
    switched: Switched | None = None
    tracking: Tracking | None = None

    def __post_init__(self) -> None:
        if (self.switched is None) == (self.tracking is None):
            raise ValueError("found both or none of switched and tracking; allowed: one of them")

    @property
    def kind(self) -> Literal["multiplicative", "additive", "tracking"]:
        """Which observer it is."""
        return "tracking" if self.switched is None else self.switched.wear
