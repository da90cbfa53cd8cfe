"""`observer.yaml`: observer of velocity and friction from position and drive."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Bench, Name, PositiveNumber, SamplePeriod
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Axis, Inertia, PositionSpan, PositiveVelocity

Row = tuple[float, ...]
MOST_MODES = 201


class FrictionMap(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A-priori friction f of (6.2) [N m | N]: polynomials of the position `over` a travel.

    The friction is constant beyond the travel. `forward`, `backward`: coefficients of the magnitude
    in each direction, lowest power first. `viscous` [N m s/rad | N s/m] holds at every speed.
    `offset` [N m | N] opposes a positive effort in both directions.
    """

    over: PositionSpan
    forward: Row
    backward: Row
    viscous: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    offset: float = 0.0


class Mode(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One mode of (6.18): `direction` of the motion (0: stuck) in a range of positions.

    `over`: (low, high) position [rad | m] of the mode. `friction`: f_m(i), its magnitude there [N m
    | N]. `deviation`: Delta_f(i), half of its spread. `gains`: L_i of (6.4), one row per state.
    `spectral_radius`: that of A_i - L_i C_i with the stored gains.
    """

    index: int
    direction: Literal[-1, 0, 1]
    gains: tuple[Row, ...]
    spectral_radius: float
    over: tuple[float, float] | None = None
    friction: float = 0.0
    deviation: float = 0.0


class Switched(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Observer (6.4) with gains from (6.6); its states are position, velocity and alpha.

    `wear`: multiplicative is the friction alpha f (6.13), additive is f + alpha (6.22).
    `switch_speed`: Sigma; below it the mode is 0. `weights`: the diagonal of C-bar (6.19).

    `transitions`: the pairs (i, j) for which (6.6) holds. `stuck_speed`: factor of the velocity in
    A_0. It is 0 in (6.18); with 1 a gain can change the velocity (docs/theory/observers.md).

    `gamma`: that of the inequalities, evaluated with the stored gains. `decay`: lambda, 1 if none
    was imposed. `smallest_gamma`: the smallest gamma without a decay. `switching_radius`: largest
    spectral radius of the products of two modes that may alternate. `simulated_gain`: largest
    ||z||/||Delta|| over simulated allowed switching sequences; at most gamma.

    The inequalities do not cover a rest, in which alpha is constant, nor a switch between moving
    modes that is not in `transitions`. A rest of any length must be followed by
    `motion_after_rest_s` of motion, and such a switch by `motion_after_turn_s` of motion.

    `quiet`: limit of gamma relative to the smallest gamma with this decay; within this limit the
    gains pass as little encoder noise as possible. `noise_gain`: bound of z relative to the
    standard deviation of this noise [rad | m], as a gain of signals.
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
    """Increase of the viscous friction above a speed (figure 4.10).

    `steeper` is in N m s/rad | N s/m.
    """

    above: PositiveVelocity
    steeper: float


class ObserverBacklash(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Backlash between motor and load (4.45).

    `width` is its full width [rad | m], `friction` that of the motor alone inside it [N m | N].
    """

    width: PositiveNumber
    friction: Annotated[float, msgspec.Meta(ge=0)]


class Tracking(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Observer of position, velocity and disturbance: model prediction, corrected by the encoder.

    `gains`: per sample, from the innovation to position [1], velocity [1/s] and disturbance [N
    m/rad | N/m]; the three poles are at exp(-bandwidth T). `cell`: width of the innovation's dead
    zone [rad | m]; 0 for none. `breakaway_ratio`: friction at rest divided by friction in slip.
    """

    gains: tuple[float, float, float]
    bandwidth_rad_s: PositiveNumber
    cell: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    breakaway_ratio: Annotated[float, msgspec.Meta(ge=1)] = 1.0
    knees: tuple[Knee, ...] = ()
    backlash: ObserverBacklash | None = None


class Observer(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`observer.yaml`: either `switched` or `tracking`, with the plant that it assumes."""

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
        """Return the kind of observer."""
        return "tracking" if self.switched is None else self.switched.wear
