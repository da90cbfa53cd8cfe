"""`observer.yaml`: observer of velocity and friction from position and drive."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Bench, Name, PositiveNumber, SamplePeriod
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Axis, Inertia, PositionSpan, PositiveVelocity
from frictool.runtime.object_view import ObjectView

Row = tuple[float, ...]
MOST_MODES = 201


class FrictionMap(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Friction that the observer assumes, as polynomials of the position over a travel.

    The friction is constant beyond the travel.

    - `over`: Travel on which the polynomials apply.
    - `forward`, `backward`: Coefficients of the friction's magnitude in this direction [N m | N],
      lowest power of the position [rad | m] first.
    - `viscous`: Viscous friction [N m s/rad | N s/m], at every speed.
    - `offset`: Constant effort [N m | N] that opposes a positive drive in both directions of
      motion.
    """

    # f of (6.2)
    over: PositionSpan
    forward: Row
    backward: Row
    viscous: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    offset: float = 0.0


class Mode(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One mode of a switched observer: a direction of the motion in a range of positions.

    - `index`: Number of the mode. Modes of forward motion have the numbers 1 to n, modes of
      backward motion -1 to -n, in the order of the position. Mode 0 is an axis at rest.
    - `direction`: Direction of the motion; 0 at rest.
    - `gains`: Matrix of observer gains. The rows belong to position [1], velocity [1/s] and wear
      alpha [per rad | m]; the columns belong to the measured signals.
    - `spectral_radius`: Largest magnitude of the poles of the estimation error in this mode, with
      the stored gains.
    - `over`: Range [low, high] of positions in which the mode applies [rad | m]. Beyond the travel,
      the first or the last mode applies.
    - `friction`: Mean magnitude of the assumed friction in the range `over` [N m | N].
    - `deviation`: Half of the difference between largest and smallest friction in the range `over`
      [N m | N].
    """

    # (6.18); gains L_i of (6.4), poles of A_i - L_i C_i; friction f_m(i) and deviation Delta_f(i)
    # of (6.15)
    index: int
    direction: Literal[-1, 0, 1]
    gains: tuple[Row, ...]
    spectral_radius: float
    over: tuple[float, float] | None = None
    friction: float = 0.0
    deviation: float = 0.0


class Switched(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Switched observer; its states are position, velocity and the wear alpha.

    The bound `gamma` is not valid in two cases: while the axis is at rest, and after a switch
    between moving modes that is not in `transitions`. The bound is valid again after the axis has
    moved for `motion_after_rest_s` after a rest, or for `motion_after_turn_s` after such a switch.
    If the document is edited, `observe design` must prove the bound again.

    - `wear`: Meaning of alpha, where f is the assumed friction. `multiplicative`: the friction is
      alpha f. `additive`: the friction is f + alpha.
    - `switch_speed`: Speed below which the axis counts as at rest (mode 0).
    - `weights`: Weights of position, velocity and alpha in the estimate's error z.
    - `modes`: Modes of the observer.
    - `transitions`: Pairs [i, j] of modes at successive samples for which `gamma` is proved.
    - `gamma`: Bound of ||z||/||Delta||, evaluated with the stored gains; Delta is the error of the
      assumed friction.
    - `decay`: Largest factor by which the error is multiplied per sample; 1 if no decay was
      required.
    - `stuck_speed`: Factor by which the estimated velocity is multiplied at each sample of mode 0,
      before the gains correct this velocity.
    - `switching_radius`: Largest spectral radius of the product of the error matrices of two modes
      that may alternate.
    - `simulated_gain`: Largest ||z||/||Delta|| in simulations that switch between the modes as
      `transitions` allows; at most gamma.
    - `smallest_gamma`: In a design with `quiet`, smallest gamma for the requested decay. In any
      other design, smallest gamma without a required decay; `gamma` may be larger because of the
      decay.
    - `motion_after_rest_s`: Duration of motion after which `gamma` is valid again, if the axis was
      at rest.
    - `motion_after_turn_s`: Duration of motion after which `gamma` is valid again, if a switch was
      not in `transitions`.
    - `quiet`: Limit of gamma, divided by the smallest gamma that is possible with this decay. Under
      this limit, the gains amplify encoder noise as little as possible.
    - `noise_gain`: Bound of ||z|| that is caused by encoder noise, divided by the standard
      deviation of the noise [rad | m].
    """

    # observer (6.4), gains from (6.6); wear (6.13), (6.22); switch_speed is Sigma; weights the
    # diagonal of C-bar (6.19);
    # stuck_speed is 0 in (6.18) (docs/theory/observers.md)
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
                f"modes: found {len(known)} modes with the indices "
                f"{', '.join(map(str, known))}; allowed: 1 to {MOST_MODES} modes, each index once"
            )
        for pair in self.transitions:
            if any(index not in known for index in pair):
                raise ValueError(
                    f"transitions: found {list(pair)}; allowed: pairs of the modes' indices"
                )


class Knee(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Increase of the viscous friction at speeds above `above`.

    - `above`: Speed at which the viscous friction increases.
    - `steeper`: Increase of the viscous friction [N m s/rad | N s/m].
    """

    # figure 4.10
    above: PositiveVelocity
    steeper: float


class ObserverBacklash(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Backlash between motor and load.

    - `width`: Full width [rad | m].
    - `friction`: Friction of the motor while the backlash is open [N m | N].
    """

    # (4.45)
    width: PositiveNumber
    friction: Annotated[float, msgspec.Meta(ge=0)]


class Tracking(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Observer of position, velocity and disturbance, with a prediction that the encoder corrects.

    - `gains`: Gains per sample from the innovation to position [1], velocity [1/s] and disturbance
      [N m/rad | N/m].
    - `bandwidth_rad_s`: Bandwidth of the observer. Its three poles are at exp(-bandwidth T) with
      the sample period T.
    - `cell`: Width of the dead zone that is applied to the innovation [rad | m]; 0 for no dead
      zone.
    - `breakaway_ratio`: Breakaway divided by Coulomb friction.
    - `knees`: Increases of the viscous friction above a speed.
    - `backlash`: Backlash between motor and load.
    """

    gains: tuple[float, float, float]
    bandwidth_rad_s: PositiveNumber
    cell: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    breakaway_ratio: Annotated[float, msgspec.Meta(ge=1)] = 1.0
    knees: tuple[Knee, ...] = ()
    backlash: ObserverBacklash | None = None


class Observer(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Observer of velocity and friction from position and drive: `observer.yaml`.

    Either the key `switched` or the key `tracking` is present. The other keys describe the plant
    that the observer assumes.

    - `friction`: Friction that the observer assumes.
    - `switched`: Modes and gains of a switched observer.
    - `tracking`: Gains of a tracking observer.
    """

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
            raise ValueError(
                "`switched`, `tracking`: found both or neither; allowed: exactly one of them"
            )

    @property
    def kind(self) -> Literal["multiplicative", "additive", "tracking"]:
        """Return "tracking" for a tracking observer, else the value of `switched.wear`."""
        return "tracking" if self.switched is None else self.switched.wear
